"""The arenas from above: walls, homes, food, robots, and over them what the camera reports."""

import math

import pygame

from khepera_forage.envs.rendering import palette
from khepera_forage.envs.rendering.layout import Layout
from khepera_forage.envs.rendering.lettering import Lettering
from khepera_forage.envs.rendering.palette import Colour
from khepera_forage.envs.rendering.pen import FINER, Pen, Spot, around, placed
from khepera_forage.envs.rendering.robot_shape import LIFT, MARKER, draw_beams, draw_marker, draw_robot
from khepera_forage.envs.rendering.view import FoodView, RobotView, View
from khepera_forage.robots.khepera import FOOD_RADIUS, MARKER_LENGTH, MARKER_WIDTH
from khepera_forage.sim.arena import Arena, Pose
from khepera_forage.task.states import FoodType
from khepera_forage.vision.scene import MM_PER_PIXEL, Region
from khepera_forage.vision.shapes import MARKER_HOLES

WALL = 7.0
"""mm; walls stand outside the floor."""
TAG = 18
"""Size of the robots' names."""

CHEVRON = ((-4.0, 8.0), (0.0, 8.0), (5.0, 0.0), (0.0, -8.0), (-4.0, -8.0), (1.0, 0.0))
STROKE = ((-9.0, 5.0), (-5.0, 9.0), (9.0, -5.0), (5.0, -9.0))
SIGNS: dict[FoodType, tuple[tuple[Spot, ...], ...]] = {
    FoodType.PICKABLE: (  # an arrow upwards: lift it
        ((-8.0, -1.0), (0.0, 9.0), (8.0, -1.0)),
        ((-2.5, -9.0), (-2.5, 0.0), (2.5, 0.0), (2.5, -9.0)),
    ),
    FoodType.PUSHABLE: tuple(
        tuple((x + dx, y) for x, y in CHEVRON) for dx in (-4.0, 4.0)
    ),  # sideways: push it
    FoodType.POISONOUS: (STROKE, tuple((x, -y) for x, y in STROKE)),  # crossed out: leave it
}
"""Signs on food, polygons in mm about its centre, so that its colour is not all that tells its type."""
TICK = ((-5.2, 0.3), (-3.4, 2.1), (-1.3, 0.0), (3.4, 4.6), (5.2, 2.8), (-1.3, -3.7))


class ArenaLayer:
    """Draws all that lies in the arenas of one layout; what never moves is drawn once."""

    def __init__(self, arenas: tuple[Arena, ...], layout: Layout, lettering: Lettering) -> None:
        self._layout = layout
        self._lettering = lettering
        self._pen = Pen(layout.arena[2:], layout.scale, layout.west, layout.north)
        self._draw_ground(arenas)
        self._ground = self._pen.surface.copy()

    def draw(self, on: pygame.Surface, view: View, accents: tuple[Colour, ...]) -> None:
        """Draw the arenas in their place of the picture."""
        pen = self._pen
        pen.surface.blit(self._ground, (0, 0))
        shown = [
            (robot, accent)
            for robot, accent in zip(view.robots, accents, strict=True)
            if all(math.isfinite(part) for part in robot.pose)
        ]
        for robot, _ in shown:
            draw_marker(pen, robot)
            draw_beams(pen, robot)
        for food in sorted(view.foods, key=lambda f: f.lifted):
            draw_food(pen, food)
        for robot, accent in shown:
            draw_robot(pen, robot, accent)
        for region in view.regions:
            draw_region(pen, region)
        on.blit(pen.shrunk(), self._layout.arena[:2])
        if len(view.robots) > 1:
            on.set_clip(self._layout.arena)
            for robot, accent in shown:
                self._tag(on, robot, accent)
            on.set_clip(None)

    def _draw_ground(self, arenas: tuple[Arena, ...]) -> None:
        pen = self._pen
        pen.surface.fill(palette.PAPER)
        width = 2 * WALL * self._layout.scale
        for arena in arenas:
            pen.path(arena.walls, palette.WALL, width)
        for arena in arenas:
            pen.polygon(arena.walls, palette.FLOOR)
            home = (arena.home.x, arena.home.y)
            pen.disc(home, arena.home_radius, palette.HOME)
            pen.ring(home, arena.home_radius, palette.HOME_EDGE, 1.5)
            for obstacle in arena.obstacles:
                pen.polygon(obstacle, palette.WALL)
            # Low in the circle: food is put down near its middle.
            column, row = self._layout.pixel(home[0], home[1] - 0.72 * arena.home_radius)
            self._lettering.write(
                pen.surface,
                "HOME",
                (column - self._layout.arena.left) * FINER,
                (row - self._layout.arena.top) * FINER,
                FINER * max(13.0, 20.0 * self._layout.scale),
                palette.HOME_EDGE,
                "centre",
            )

    def _tag(self, on: pygame.Surface, robot: RobotView, accent: Colour) -> None:
        """The robot's name, under its marker."""
        x, y, heading = robot.pose
        reach = (MARKER_LENGTH * abs(math.sin(heading)) + MARKER_WIDTH * abs(math.cos(heading))) / 2
        column, row = self._layout.pixel(x, y - reach)
        row += 9
        for dx, dy in ((-1, 0), (1, 0), (0, -1), (0, 1)):  # a halo keeps it legible over lines
            self._lettering.write(on, robot.name, column + dx, row + dy, TAG, palette.FLOOR, "centre")
        self._lettering.write(on, robot.name, column, row, TAG, accent, "centre")


def draw_food(pen: Pen, food: FoodView) -> None:
    """A disc whose colour and sign tell its type; lifted above its shadow, with a tick once delivered."""
    x, y = food.x, food.y
    if food.lifted:
        pen.polygon(around((x + LIFT, y - LIFT), FOOD_RADIUS, 40), palette.WHEEL, alpha=70)
    fill = palette.FOOD[food.food_type]
    edge = palette.WALL if food.food_type == FoodType.UNKNOWN else palette.mixed(fill, palette.WHEEL, 0.45)
    pen.disc((x, y), FOOD_RADIUS, edge)
    pen.disc((x, y), FOOD_RADIUS - 1.8, fill)
    for sign in SIGNS.get(food.food_type, ()):
        pen.polygon([(x + dx, y + dy) for dx, dy in sign], palette.CARD)
    if food.delivered:
        x, y = x + 14.0, y + 14.0
        pen.disc((x, y), 9.5, palette.CARD)
        pen.disc((x, y), 8.3, palette.INK)
        pen.polygon([(x + dx, y + dy) for dx, dy in TICK], palette.CARD)


def draw_region(pen: Pen, region: Region) -> None:
    """What the camera reports: an outline, its centre marked, a stroke towards its orientation if any."""
    colour = palette.FOUND if region.found else palette.LOST
    x, y = region.x * MM_PER_PIXEL, region.y * MM_PER_PIXEL
    pose = Pose(x, y, math.radians(region.orientation))
    if region.holes in MARKER_HOLES:
        pen.path(placed(pose, MARKER), colour, 1.0, dash=None if region.found else 4.0)
        stroke = placed(pose, ((0.0, 0.0), (MARKER_LENGTH / 2, 0.0)))
        pen.line(stroke[0], stroke[1], colour, 1.0)
        for dx, dy in ((5.0, 0.0), (0.0, 5.0)):
            pen.line((x - dx, y - dy), (x + dx, y + dy), colour, 1.0)
        return
    radius = FOOD_RADIUS + 3.5
    rim = around((x, y), radius, 28)
    if region.found:
        pen.path(rim, colour, 1.2)
    else:
        for a, b in zip(rim[::2], rim[1::2], strict=True):
            pen.line(a, b, colour, 1.2)
    for dx, dy in ((1, 0), (-1, 0), (0, 1), (0, -1)):  # cross-hairs, which leave the food's sign alone
        inner, outer = radius - 1.0, radius + 6.0
        pen.line((x + dx * inner, y + dy * inner), (x + dx * outer, y + dy * outer), colour, 1.2)
