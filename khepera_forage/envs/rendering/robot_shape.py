"""A Khepera from above: body, wheels, marker, infra-red beams, and the gripper as it stands."""

import math
from collections.abc import Sequence

from khepera_forage.envs.rendering import palette
from khepera_forage.envs.rendering.palette import Colour
from khepera_forage.envs.rendering.pen import Pen, Spot, block, placed
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
from khepera_forage.sim.arena import Pose
from khepera_forage.vision.shapes import HOLE_SIDE, MARKER_HOLES

MARKER = block(-MARKER_LENGTH / 2, -MARKER_WIDTH / 2, MARKER_LENGTH / 2, MARKER_WIDTH / 2)
BEAM = math.radians(15.0)
"""Half the opening of a beam."""
LIFT = 7.0
"""mm that the shadow of a raised gripper, or of what it holds, lies to the side."""


def lifted(arm: float) -> float:
    """How high an arm is: 0 lowered, 1 raised."""
    return max(0.0, min(1.0, (ARM_DOWN - arm) / (ARM_DOWN - ARM_RAISED)))


def draw_marker(pen: Pen, robot: RobotView) -> None:
    """The sheet on the robot's back: faint, for it would hide the robot."""
    corners = placed(robot.pose, MARKER)
    pen.polygon(corners, palette.MARKER, alpha=105)
    pen.path(corners, palette.SHADOW, 1.0)


def draw_beams(pen: Pen, robot: RobotView) -> None:
    """A wedge for each infra-red sensor: the higher its reading, the longer and the stronger."""
    for (forward, left, cosine, sine), reading in zip(SENSORS, robot.proximity, strict=False):
        strength = max(0.0, min(1.0, reading / MAX_READING))
        length, axis = 14.0 + 24.0 * strength, math.atan2(sine, cosine)
        # From a point behind the sensor: it then is as broad as a sensor where it leaves the body.
        foot = (forward - 8.0 * cosine, left - 8.0 * sine)
        rim = [
            (
                foot[0] + (8.0 + length) * math.cos(axis + turn),
                foot[1] + (8.0 + length) * math.sin(axis + turn),
            )
            for turn in (-BEAM, -BEAM / 2, 0.0, BEAM / 2, BEAM)
        ]
        pen.polygon(placed(robot.pose, (foot, *rim)), palette.INFRA_RED, alpha=round(22 + 165 * strength))


def draw_robot(pen: Pen, robot: RobotView, accent: Colour) -> None:
    """A robot's body and gripper, edged in the colour of its panel."""
    for side in (-1, 1):
        pen.polygon(placed(robot.pose, block(-7.5, side * 29.0, 7.5, side * 23.0)), palette.WHEEL)
    centre = (robot.pose.x, robot.pose.y)
    pen.disc(centre, RADIUS, accent)
    pen.disc(centre, RADIUS - 4.0, palette.BODY)
    for along, aside in MARKER_HOLES.get(robot.holes, ()):
        half = HOLE_SIDE / 2
        hole = placed(robot.pose, block(along - half, aside - half, along + half, aside + half))
        pen.polygon(hole, palette.MARKER, alpha=36)
        pen.path(hole, palette.SHADOW, 0.8)
    _draw_gripper(pen, robot)


def _draw_gripper(pen: Pen, robot: RobotView) -> None:
    """Two fingers as far apart as the jaw says: dark on the floor, light above their shadow when raised."""
    height = lifted(robot.arm)
    gap = half_gap(max(JAW_CLOSED, min(JAW_OPEN, robot.jaw)))
    parts: list[Sequence[Spot]] = [block(JAW_ROOT - 7.0, -33.0, JAW_ROOT, 33.0)]
    for side in (-1, 1):
        parts.append(block(4.0, side * 17.0, JAW_ROOT - 7.0, side * 22.0))
        parts.append(block(JAW_ROOT, side * gap, FINGER_TIP, side * (gap + FINGER_THICKNESS)))
    if height > 0:
        for part in parts:
            _shaded(pen, robot.pose, part, height)
    fill = palette.mixed(palette.LOWERED, palette.RAISED, height)
    for part in parts:
        corners = placed(robot.pose, part)
        pen.polygon(corners, fill)
        pen.path(corners, palette.LOWERED, 1.2)


def _shaded(pen: Pen, pose: Pose, part: Sequence[Spot], height: float) -> None:
    pen.polygon(placed(pose, part, dx=LIFT * height, dy=-LIFT * height), palette.WHEEL, alpha=46)
