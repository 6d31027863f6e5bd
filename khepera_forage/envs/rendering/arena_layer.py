"""The arenas from above: walls, homes, food and robots, and over them the regions that the camera reports."""

import math

import pygame

from khepera_forage.envs.rendering import palette
from khepera_forage.envs.rendering.canvas import SUPERSAMPLING, XY, Canvas, regular_polygon, transformed
from khepera_forage.envs.rendering.layout import Layout
from khepera_forage.envs.rendering.palette import Colour
from khepera_forage.envs.rendering.robot_shape import (
    LIFTED_SHADOW,
    MARKER,
    draw_beams,
    draw_marker,
    draw_robot,
)
from khepera_forage.envs.rendering.text import TextRenderer
from khepera_forage.envs.rendering.view import FoodView, RobotView, View
from khepera_forage.robots.khepera import FOOD_RADIUS, MARKER_LENGTH, MARKER_WIDTH
from khepera_forage.sim.arena import Arena, Pose
from khepera_forage.task.states import FoodType
from khepera_forage.vision.scene import MM_PER_PIXEL, Region
from khepera_forage.vision.shapes import MARKER_HOLES

WALL = 7.0
"""Thickness of a wall in mm; walls lie outside the floor."""
NAME_SIZE = 18
"""Text size of the robots' names."""

CHEVRON = ((-4.0, 8.0), (0.0, 8.0), (5.0, 0.0), (0.0, -8.0), (-4.0, -8.0), (1.0, 0.0))
STROKE = ((-9.0, 5.0), (-5.0, 9.0), (9.0, -5.0), (5.0, -9.0))
FOOD_SYMBOLS: dict[FoodType, tuple[tuple[XY, ...], ...]] = {
    # An arrow upwards: lift it.
    FoodType.PICKABLE: (
        ((-8.0, -1.0), (0.0, 9.0), (8.0, -1.0)),
        ((-2.5, -9.0), (-2.5, 0.0), (2.5, 0.0), (2.5, -9.0)),
    ),
    # A double arrow to the side: push it.
    FoodType.PUSHABLE: tuple(tuple((x + dx, y) for x, y in CHEVRON) for dx in (-4.0, 4.0)),
    # A cross: leave it.
    FoodType.POISONOUS: (STROKE, tuple((x, -y) for x, y in STROKE)),
}
"""Polygons in mm around the centre of food, so that colour is not the only sign of its type."""
TICK = ((-5.2, 0.3), (-3.4, 2.1), (-1.3, 0.0), (3.4, 4.6), (5.2, 2.8), (-1.3, -3.7))


class ArenaLayer:
    """Draws everything inside the arenas of one layout; static parts are drawn only once."""

    def __init__(self, arenas: tuple[Arena, ...], layout: Layout, text: TextRenderer) -> None:
        self._layout = layout
        self._text = text
        self._canvas = Canvas(layout.arena[2:], layout.scale, layout.left, layout.top)
        self._draw_floor(arenas)
        self._floor = self._canvas.surface.copy()

    def draw(self, picture: pygame.Surface, view: View, colours: tuple[Colour, ...]) -> None:
        """Draw the arenas at their place in the picture; `colours` has one entry per robot."""
        canvas = self._canvas
        canvas.surface.blit(self._floor, (0, 0))
        robots = [
            (robot, colour)
            for robot, colour in zip(view.robots, colours, strict=True)
            if all(math.isfinite(value) for value in robot.pose)
        ]
        for robot, _ in robots:
            draw_marker(canvas, robot)
            draw_beams(canvas, robot)
        for food in sorted(view.foods, key=lambda f: f.lifted):
            draw_food(canvas, food)
        for robot, colour in robots:
            draw_robot(canvas, robot, colour)
        for region in view.regions:
            draw_region(canvas, region)
        picture.blit(canvas.downsampled(), self._layout.arena[:2])
        if len(view.robots) > 1:
            picture.set_clip(self._layout.arena)
            for robot, colour in robots:
                self._draw_name(picture, robot, colour)
            picture.set_clip(None)

    def _draw_floor(self, arenas: tuple[Arena, ...]) -> None:
        canvas = self._canvas
        canvas.surface.fill(palette.BACKGROUND)
        width = 2 * WALL * self._layout.scale
        for arena in arenas:
            canvas.outline(arena.walls, palette.WALL, width)
        for arena in arenas:
            canvas.polygon(arena.walls, palette.FLOOR)
            home = (arena.home.x, arena.home.y)
            canvas.disc(home, arena.home_radius, palette.HOME)
            canvas.ring(home, arena.home_radius, palette.HOME_EDGE, 1.5)
            for obstacle in arena.obstacles:
                canvas.polygon(obstacle, palette.WALL)
            # The word is low in the circle, because food is put down near the middle.
            column, row = self._layout.pixel(home[0], home[1] - 0.72 * arena.home_radius)
            self._text.write(
                canvas.surface,
                "HOME",
                (column - self._layout.arena.left) * SUPERSAMPLING,
                (row - self._layout.arena.top) * SUPERSAMPLING,
                SUPERSAMPLING * max(13.0, 20.0 * self._layout.scale),
                palette.HOME_EDGE,
                "centre",
            )

    def _draw_name(self, picture: pygame.Surface, robot: RobotView, colour: Colour) -> None:
        """The robot's name below its marker."""
        x, y, heading = robot.pose
        reach = (MARKER_LENGTH * abs(math.sin(heading)) + MARKER_WIDTH * abs(math.cos(heading))) / 2
        column, row = self._layout.pixel(x, y - reach)
        row += 9
        for dx, dy in ((-1, 0), (1, 0), (0, -1), (0, 1)):  # a light border keeps the name legible over lines
            self._text.write(picture, robot.name, column + dx, row + dy, NAME_SIZE, palette.FLOOR, "centre")
        self._text.write(picture, robot.name, column, row, NAME_SIZE, colour, "centre")


def draw_food(canvas: Canvas, food: FoodView) -> None:
    """Food as a disc with the colour and symbol of its type, a shadow if lifted, and a tick if delivered."""
    x, y = food.x, food.y
    if food.lifted:
        shadow = regular_polygon((x + LIFTED_SHADOW, y - LIFTED_SHADOW), FOOD_RADIUS, 40)
        canvas.polygon(shadow, palette.WHEEL, alpha=70)
    fill = palette.FOOD[food.food_type]
    edge = palette.WALL if food.food_type == FoodType.UNKNOWN else palette.blended(fill, palette.WHEEL, 0.45)
    canvas.disc((x, y), FOOD_RADIUS, edge)
    canvas.disc((x, y), FOOD_RADIUS - 1.8, fill)
    for polygon in FOOD_SYMBOLS.get(food.food_type, ()):
        canvas.polygon([(x + dx, y + dy) for dx, dy in polygon], palette.CARD)
    if food.delivered:
        x, y = x + 14.0, y + 14.0
        canvas.disc((x, y), 9.5, palette.CARD)
        canvas.disc((x, y), 8.3, palette.INK)
        canvas.polygon([(x + dx, y + dy) for dx, dy in TICK], palette.CARD)


def draw_region(canvas: Canvas, region: Region) -> None:
    """A region that the camera reports: outline and centre, and for a marker a line along its orientation."""
    colour = palette.FOUND if region.found else palette.LOST
    x, y = region.x * MM_PER_PIXEL, region.y * MM_PER_PIXEL
    pose = Pose(x, y, math.radians(region.orientation))
    if region.holes in MARKER_HOLES:
        canvas.outline(transformed(pose, MARKER), colour, 1.0, dash=None if region.found else 4.0)
        axis = transformed(pose, ((0.0, 0.0), (MARKER_LENGTH / 2, 0.0)))
        canvas.line(axis[0], axis[1], colour, 1.0)
        for dx, dy in ((5.0, 0.0), (0.0, 5.0)):
            canvas.line((x - dx, y - dy), (x + dx, y + dy), colour, 1.0)
        return
    radius = FOOD_RADIUS + 3.5
    rim = regular_polygon((x, y), radius, 28)
    if region.found:
        canvas.outline(rim, colour, 1.2)
    else:
        for a, b in zip(rim[::2], rim[1::2], strict=True):
            canvas.line(a, b, colour, 1.2)
    for dx, dy in (
        (1, 0),
        (-1, 0),
        (0, 1),
        (0, -1),
    ):  # cross-hairs outside the disc, clear of the food's symbol
        inner, outer = radius - 1.0, radius + 6.0
        canvas.line((x + dx * inner, y + dy * inner), (x + dx * outer, y + dy * outer), colour, 1.2)
