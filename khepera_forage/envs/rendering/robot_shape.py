"""A Khepera from above: body, wheels, marker, infra-red beams and gripper."""

import math
from collections.abc import Sequence

from khepera_forage.envs.rendering import palette
from khepera_forage.envs.rendering.canvas import XY, Canvas, rectangle, transformed
from khepera_forage.envs.rendering.palette import Colour
from khepera_forage.envs.rendering.view import RobotView
from khepera_forage.robots.khepera import (
    ARM_DOWN,
    ARM_RAISED,
    FINGER_THICKNESS,
    FINGER_TIP,
    JAW_CLOSED,
    JAW_OPEN,
    JAW_ROOT,
    MARKER_LENGTH,
    MARKER_WIDTH,
    RADIUS,
    half_gap,
)
from khepera_forage.robots.proximity import MAX_READING, SENSORS
from khepera_forage.vision.shapes import HOLE_SIDE, MARKER_HOLES

MARKER = rectangle(-MARKER_LENGTH / 2, -MARKER_WIDTH / 2, MARKER_LENGTH / 2, MARKER_WIDTH / 2)
BEAM = math.radians(15.0)
"""Half the opening angle of an infra-red beam."""
LIFTED_SHADOW = 7.0
"""mm by which the shadow of a raised gripper, or of food in it, is shifted to the side."""


def arm_height(arm: float) -> float:
    """Height of the arm: 0 lowered, 1 raised."""
    return max(0.0, min(1.0, (ARM_DOWN - arm) / (ARM_DOWN - ARM_RAISED)))


def draw_marker(canvas: Canvas, robot: RobotView) -> None:
    """Draw the marker, transparent because it covers the robot."""
    corners = transformed(robot.pose, MARKER)
    canvas.polygon(corners, palette.MARKER, alpha=105)
    canvas.outline(corners, palette.SHADOW, 1.0)


def draw_beams(canvas: Canvas, robot: RobotView) -> None:
    """Draw a wedge for each infra-red sensor; a higher reading makes it longer and more opaque."""
    for (forward, left, cosine, sine), reading in zip(SENSORS, robot.proximity, strict=False):
        strength = max(0.0, min(1.0, reading / MAX_READING))
        length, axis = 14.0 + 24.0 * strength, math.atan2(sine, cosine)
        # The wedge starts behind the sensor, so that it is as wide as a sensor where it leaves the body.
        start = (forward - 8.0 * cosine, left - 8.0 * sine)
        arc = [
            (
                start[0] + (8.0 + length) * math.cos(axis + turn),
                start[1] + (8.0 + length) * math.sin(axis + turn),
            )
            for turn in (-BEAM, -BEAM / 2, 0.0, BEAM / 2, BEAM)
        ]
        wedge = transformed(robot.pose, (start, *arc))
        canvas.polygon(wedge, palette.INFRA_RED, alpha=round(22 + 165 * strength))


def draw_robot(canvas: Canvas, robot: RobotView, colour: Colour) -> None:
    """Draw body and gripper, with an edge in the robot's colour."""
    for side in (-1, 1):
        wheel = transformed(robot.pose, rectangle(-7.5, side * 29.0, 7.5, side * 23.0))
        canvas.polygon(wheel, palette.WHEEL)
    centre = (robot.pose.x, robot.pose.y)
    canvas.disc(centre, RADIUS, colour)
    canvas.disc(centre, RADIUS - 4.0, palette.BODY)
    for forward, left in MARKER_HOLES.get(robot.holes, ()):
        half = HOLE_SIDE / 2
        square = rectangle(forward - half, left - half, forward + half, left + half)
        hole = transformed(robot.pose, square)
        canvas.polygon(hole, palette.MARKER, alpha=36)
        canvas.outline(hole, palette.SHADOW, 0.8)
    _draw_gripper(canvas, robot)


def _draw_gripper(canvas: Canvas, robot: RobotView) -> None:
    """Draw the fingers at the jaw's opening: dark when lowered, light with a shadow when raised."""
    height = arm_height(robot.arm)
    gap = half_gap(max(JAW_CLOSED, min(JAW_OPEN, robot.jaw)))
    parts: list[Sequence[XY]] = [rectangle(JAW_ROOT - 7.0, -33.0, JAW_ROOT, 33.0)]
    for side in (-1, 1):
        parts.append(rectangle(4.0, side * 17.0, JAW_ROOT - 7.0, side * 22.0))
        parts.append(rectangle(JAW_ROOT, side * gap, FINGER_TIP, side * (gap + FINGER_THICKNESS)))
    if height > 0:
        shift = LIFTED_SHADOW * height
        for part in parts:
            canvas.polygon(transformed(robot.pose, part, dx=shift, dy=-shift), palette.WHEEL, alpha=46)
    fill = palette.blended(palette.LOWERED, palette.RAISED, height)
    for part in parts:
        corners = transformed(robot.pose, part)
        canvas.polygon(corners, fill)
        canvas.outline(corners, palette.LOWERED, 1.2)
