"""The arenas from above: walls, homes, food and robots, and over them the regions that the camera reports."""

import math
from collections.abc import Sequence

from khepera_forage.envs.rendering import palette
from khepera_forage.envs.rendering.drawing import XY, Canvas, clamped, rectangle, regular_polygon, transformed
from khepera_forage.envs.rendering.palette import Colour
from khepera_forage.envs.rendering.view import FoodView, RobotView
from khepera_forage.robots.khepera import (
    ARM_DOWN,
    ARM_RAISED,
    FINGER_THICKNESS,
    FINGER_TIP,
    FOOD_RADIUS,
    JAW_CLOSED,
    JAW_OPEN,
    JAW_ROOT,
    MARKER_LENGTH,
    MARKER_WIDTH,
    RADIUS,
    half_gap,
)
from khepera_forage.robots.proximity import MAX_READING, SENSORS
from khepera_forage.sim.arena import Arena, Pose
from khepera_forage.task.states import FoodType
from khepera_forage.vision.scene import MM_PER_PIXEL, Region
from khepera_forage.vision.shapes import HOLE_SIDE, MARKER_HOLES

WALL = 7.0
"""Thickness of a wall in mm; walls lie outside the floor."""
MARKER = rectangle(-MARKER_LENGTH / 2, -MARKER_WIDTH / 2, MARKER_LENGTH / 2, MARKER_WIDTH / 2)
BEAM = math.radians(15.0)
"""Half the opening angle of an infra-red beam."""
LIFTED_SHADOW = 7.0
"""mm by which the shadow of a raised gripper, or of food in it, is shifted to the side."""

CHEVRON = ((-4.0, 8.0), (0.0, 8.0), (5.0, 0.0), (0.0, -8.0), (-4.0, -8.0), (1.0, 0.0))
STROKE = ((-9.0, 5.0), (-5.0, 9.0), (9.0, -5.0), (5.0, -9.0))
FOOD_SYMBOLS: dict[FoodType, tuple[tuple[XY, ...], ...]] = {
    # An arrow upwards: lift it.
    FoodType.PICKABLE: (((-8.0, -1.0), (0.0, 9.0), (8.0, -1.0)), ((-2.5, -9.0), (-2.5, 0.0), (2.5, 0.0), (2.5, -9.0))),
    # A double arrow to the side: push it.
    FoodType.PUSHABLE: tuple(tuple((x + dx, y) for x, y in CHEVRON) for dx in (-4.0, 4.0)),
    # A cross: leave it.
    FoodType.POISONOUS: (STROKE, tuple((x, -y) for x, y in STROKE)),
}
"""Polygons in mm around the centre of food, so that colour is not the only sign of its type."""
TICK = ((-5.2, 0.3), (-3.4, 2.1), (-1.3, 0.0), (3.4, 4.6), (5.2, 2.8), (-1.3, -3.7))


def draw_floor(canvas: Canvas, arenas: Sequence[Arena]) -> None:
    """Draw walls, obstacles and homes."""
    canvas.surface.fill(palette.BACKGROUND)
    for arena in arenas:
        canvas.outline(arena.walls, palette.WALL, 2 * WALL * canvas.scale)
    for arena in arenas:
        canvas.polygon(arena.walls, palette.FLOOR)
        x, y = arena.home.x, arena.home.y
        canvas.circle((x, y), arena.home_radius, palette.HOME)
        canvas.circle((x, y), arena.home_radius, palette.HOME_EDGE, 1.5)
        for obstacle in arena.obstacles:
            canvas.polygon(obstacle, palette.WALL)
        # The word is low in the circle, because food is put down near the middle.
        size = max(13.0, 20.0 * canvas.scale)
        canvas.label("HOME", (x, y - 0.72 * arena.home_radius), size, palette.HOME_EDGE)


def draw_arena(
    canvas: Canvas, robots: Sequence[tuple[RobotView, Colour]], foods: Sequence[FoodView], regions: Sequence[Region]
) -> None:
    """Draw on the floor: robots with finite poses and their colours, food, and regions that the camera reports."""
    for robot, _ in robots:
        if robot.has_gripper:
            _draw_marker(canvas, robot)
        _draw_beams(canvas, robot)
    for food in sorted(foods, key=lambda f: f.lifted):
        draw_food(canvas, food)
    for robot, colour in robots:
        _draw_body(canvas, robot, colour)
        if robot.has_gripper:
            _draw_gripper(canvas, robot)
    for region in regions:
        draw_region(canvas, region)


def draw_food(canvas: Canvas, food: FoodView) -> None:
    """Food as a disc with the colour and symbol of its type, a shadow if lifted, and a tick if delivered."""
    x, y = food.x, food.y
    if food.lifted:
        shadow = regular_polygon((x + LIFTED_SHADOW, y - LIFTED_SHADOW), FOOD_RADIUS, 40)
        canvas.polygon(shadow, palette.WHEEL, alpha=70)
    fill = palette.FOOD[food.food_type]
    edge = palette.WALL if food.food_type == FoodType.UNKNOWN else palette.blended(fill, palette.WHEEL, 0.45)
    canvas.circle((x, y), FOOD_RADIUS, edge)
    canvas.circle((x, y), FOOD_RADIUS - 1.8, fill)
    for polygon in FOOD_SYMBOLS.get(food.food_type, ()):
        canvas.polygon([(x + dx, y + dy) for dx, dy in polygon], palette.CARD)
    if food.delivered:
        x, y = x + 14.0, y + 14.0
        canvas.circle((x, y), 9.5, palette.CARD)
        canvas.circle((x, y), 8.3, palette.INK)
        canvas.polygon([(x + dx, y + dy) for dx, dy in TICK], palette.CARD)


def draw_region(canvas: Canvas, region: Region) -> None:
    """A region that the camera reports: outline and centre, and for a marker a line along its orientation."""
    colour = palette.FOUND if region.found else palette.LOST
    x, y = region.x * MM_PER_PIXEL, region.y * MM_PER_PIXEL
    if region.holes in MARKER_HOLES:
        pose = Pose(x, y, math.radians(region.orientation))
        if region.found:
            canvas.outline(transformed(pose, MARKER), colour)
        else:
            canvas.dashed_outline(transformed(pose, MARKER), colour, 4.0)
        middle, front = transformed(pose, ((0.0, 0.0), (MARKER_LENGTH / 2, 0.0)))
        canvas.line(middle, front, colour)
        canvas.line((x - 5.0, y), (x + 5.0, y), colour)
        canvas.line((x, y - 5.0), (x, y + 5.0), colour)
        return
    radius = FOOD_RADIUS + 3.5
    rim = regular_polygon((x, y), radius, 28)
    if region.found:
        canvas.outline(rim, colour, 1.2)
    else:
        for a, b in zip(rim[::2], rim[1::2], strict=True):
            canvas.line(a, b, colour, 1.2)
    inner, outer = radius - 1.0, radius + 6.0
    for dx, dy in ((1, 0), (-1, 0), (0, 1), (0, -1)):  # cross-hairs outside the disc, clear of the food's symbol
        canvas.line((x + dx * inner, y + dy * inner), (x + dx * outer, y + dy * outer), colour, 1.2)


def _draw_marker(canvas: Canvas, robot: RobotView) -> None:
    """Draw the marker, transparent because it covers the robot."""
    corners = transformed(robot.pose, MARKER)
    canvas.polygon(corners, palette.MARKER, alpha=105)
    canvas.outline(corners, palette.SHADOW)


def _draw_beams(canvas: Canvas, robot: RobotView) -> None:
    """Draw a wedge for each infra-red sensor; a higher reading makes it longer and more opaque."""
    for (forward, left, cosine, sine), reading in zip(SENSORS, robot.proximity, strict=False):
        strength = clamped(reading / MAX_READING)
        # The wedge starts behind the sensor, so that it is as wide as a sensor where it leaves the body.
        x, y = forward - 8.0 * cosine, left - 8.0 * sine
        length, axis = 22.0 + 24.0 * strength, math.atan2(sine, cosine)
        angles = [axis + turn for turn in (-BEAM, -BEAM / 2, 0.0, BEAM / 2, BEAM)]
        arc = [(x + length * math.cos(angle), y + length * math.sin(angle)) for angle in angles]
        wedge = transformed(robot.pose, ((x, y), *arc))
        canvas.polygon(wedge, palette.INFRA_RED, alpha=round(22 + 165 * strength))


def _draw_body(canvas: Canvas, robot: RobotView, colour: Colour) -> None:
    """Draw wheels, body and the marker's holes, with an edge in the robot's colour."""
    for side in (-1, 1):
        wheel = transformed(robot.pose, rectangle(-7.5, side * 29.0, 7.5, side * 23.0))
        canvas.polygon(wheel, palette.WHEEL)
    centre = (robot.pose.x, robot.pose.y)
    canvas.circle(centre, RADIUS, colour)
    canvas.circle(centre, RADIUS - 4.0, palette.BODY)
    half = HOLE_SIDE / 2
    for forward, left in MARKER_HOLES.get(robot.holes, ()):
        square = rectangle(forward - half, left - half, forward + half, left + half)
        hole = transformed(robot.pose, square)
        canvas.polygon(hole, palette.MARKER, alpha=36)
        canvas.outline(hole, palette.SHADOW, 0.8)


def _draw_gripper(canvas: Canvas, robot: RobotView) -> None:
    """Draw the fingers at the jaw's opening: dark when lowered, light with a shadow when raised."""
    height = clamped((ARM_DOWN - robot.arm) / (ARM_DOWN - ARM_RAISED))
    gap = half_gap(max(JAW_CLOSED, min(JAW_OPEN, robot.jaw)))
    parts = [rectangle(JAW_ROOT - 7.0, -33.0, JAW_ROOT, 33.0)]
    for side in (-1, 1):
        parts.append(rectangle(4.0, side * 17.0, JAW_ROOT - 7.0, side * 22.0))
        parts.append(rectangle(JAW_ROOT, side * gap, FINGER_TIP, side * (gap + FINGER_THICKNESS)))
    if height > 0:
        shift = LIFTED_SHADOW * height
        shadow = robot.pose._replace(x=robot.pose.x + shift, y=robot.pose.y - shift)
        for part in parts:
            canvas.polygon(transformed(shadow, part), palette.WHEEL, alpha=46)
    fill = palette.blended(palette.LOWERED, palette.RAISED, height)
    for part in parts:
        corners = transformed(robot.pose, part)
        canvas.polygon(corners, fill)
        canvas.outline(corners, palette.LOWERED, 1.2)
