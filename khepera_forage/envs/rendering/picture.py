"""A whole picture: the arenas on the left, one panel per robot beside them, a header above and a legend below."""

import itertools
import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import pygame
from numpy.typing import NDArray

from khepera_forage.envs.rendering import palette
from khepera_forage.envs.rendering.arena import draw_arena, draw_floor, draw_food, draw_region
from khepera_forage.envs.rendering.drawing import Canvas, box, clamped, dot, fitted, text_width, write
from khepera_forage.envs.rendering.palette import Colour
from khepera_forage.envs.rendering.panel import Panel
from khepera_forage.envs.rendering.view import FoodView, RobotView, View
from khepera_forage.robots.khepera import MARKER_LENGTH, MARKER_WIDTH
from khepera_forage.sim.arena import Arena
from khepera_forage.task.states import FoodType
from khepera_forage.vision.scene import MM_PER_PIXEL, Region

GAP = 16
"""Pixels around and between arenas and panels."""
HEADER = 62
FOOTER = 34
MAX_WIDTH = 1400
"""Greatest width of a picture in pixels; exceeded only when the panels would become illegible."""
MAX_HEIGHT = 760
"""Greatest height in pixels between header and footer; exceeded likewise."""
MAX_SCALE = 1.3
"""Greatest number of pixels per mm."""
MARGIN = 30.0
"""mm shown outside the walls."""

WIDE_PANEL = (430, 350)
"""Width and least height of a panel with two columns at text scale 1."""
TALL_PANEL = (296, 540)
"""Width and least height of a panel with one column at text scale 1."""
TEXT_SCALES = (1.2, 1.15, 1.1, 1.05, 1.0, 0.95, 0.9, 0.85, 0.8)

NAME_SIZE = 18
"""Text size of the robots' names."""
LEGEND_SCALE = 0.42
"""Pixels per mm of the symbols in the legend."""
LEGEND_SIZE = 16
"""Text size of the legend."""


class PictureLayout(NamedTuple):
    """Positions and sizes of all parts of a picture.

    Attributes:
        size: Width and height of the picture, both even, as video encoders require.
        arena: The part that shows the arenas.
        scale: Pixels per mm in `arena`.
        left: x in mm at the left side of `arena`.
        top: y in mm at the upper side of `arena`.
        panels: One per robot.
        columns: Columns in each panel, 1 or 2.
        text_scale: Scale of the panels' text.
    """

    size: tuple[int, int]
    arena: pygame.Rect
    scale: float
    left: float
    top: float
    panels: tuple[pygame.Rect, ...]
    columns: int
    text_scale: float

    def pixel(self, x: float, y: float) -> tuple[int, int]:
        """Column and row of the picture that show a position in mm."""
        return (
            self.arena.left + math.floor((x - self.left) * self.scale),
            self.arena.top + math.floor((self.top - y) * self.scale),
        )


def arrange(arenas: Sequence[Arena], robots: int) -> PictureLayout:
    """The best of many layouts, with large arenas, large text and little empty space.

    Args:
        arenas: At least one.
        robots: Number of panels.

    Raises:
        ValueError: No arena.
    """
    if not arenas:
        raise ValueError("no arenas to show; allowed: at least one")
    candidates = (
        _candidate(arenas, robots, across, columns, text_scale)
        for text_scale in TEXT_SCALES
        for columns in (2, 1)
        for across in range(1, max(robots, 1) + 1)
    )
    return max(candidates, key=lambda candidate: candidate[0])[1]


def _candidate(
    arenas: Sequence[Arena], robots: int, across: int, columns: int, text_scale: float
) -> tuple[float, PictureLayout]:
    """The quality of a layout, and the layout; `across` is the number of panels side by side."""
    lefts, bottoms, rights, tops = zip(*(arena.bounds for arena in arenas), strict=True)
    ground = (max(rights) - min(lefts) + 2 * MARGIN, max(tops) - min(bottoms) + 2 * MARGIN)
    down = math.ceil(robots / across)
    panel = [round(side * text_scale) for side in (WIDE_PANEL if columns == 2 else TALL_PANEL)]
    # Width of the panels, including the gap between them and the arenas.
    panels_width = across * (panel[0] + GAP) if robots else 0
    panels_height = down * (panel[1] + GAP) - GAP
    room = MAX_WIDTH - 2 * GAP - panels_width
    scale = max(0.2, min(MAX_SCALE, room / ground[0], max(MAX_HEIGHT, panels_height) / ground[1]))
    arena = (round(ground[0] * scale), round(ground[1] * scale))
    body = max(arena[1], panels_height)
    width, height = 2 * GAP + arena[0] + panels_width, HEADER + body + FOOTER
    panel_height = (body - (down - 1) * GAP) // max(down, 1)
    panels = [
        pygame.Rect(
            2 * GAP + arena[0] + i % across * (panel[0] + GAP),
            HEADER + i // across * (panel_height + GAP),
            panel[0],
            panel_height,
        )
        for i in range(robots)
    ]
    if bottoms[-1] > bottoms[0] and across == 1:
        # Arenas that are stacked upwards have their panels in the same order, each beside its own arena.
        panels.reverse()
    used = (arena[0] * arena[1] + across * down * panel[0] * panel[1]) / ((width - 2 * GAP) * body)
    # Oversize reduces the quality strongly, but does not exclude a layout: many robots need it.
    excess = max(width / MAX_WIDTH, 1.0) * max(body / MAX_HEIGHT, 1.0)
    quality = min(text_scale, 1.1) * scale * used / excess**4
    return quality, PictureLayout(
        size=(width + width % 2, height + height % 2),
        arena=pygame.Rect(GAP, HEADER + (body - arena[1]) // 2, *arena),
        scale=scale,
        left=min(lefts) - MARGIN,
        top=max(tops) + MARGIN,
        panels=tuple(panels),
        columns=columns,
        text_scale=text_scale,
    )


class Painter:
    """Paints views on surfaces in memory, without a display.

    The layout, the legend and the floor are drawn once and reused while the arenas and the number of robots stay.
    """

    def __init__(self) -> None:
        self._prepared_for: tuple[tuple[Arena, ...], int] | None = None
        self._layout: PictureLayout
        self._base: pygame.Surface
        self._canvas: Canvas
        self._floor: pygame.Surface

    def paint(self, view: View) -> pygame.Surface:
        """The picture of a view, a new surface.

        Raises:
            ValueError: The view has no arena.
        """
        if self._prepared_for != (view.arenas, len(view.robots)):
            self._prepare(view.arenas, len(view.robots))
        layout, picture = self._layout, self._base.copy()
        learners = itertools.cycle(palette.LEARNERS)
        colours = [palette.TEACHER if robot.holes == 1 else next(learners) for robot in view.robots]
        placed = [
            (robot, colour)
            for robot, colour in zip(view.robots, colours, strict=True)
            if all(math.isfinite(value) for value in robot.pose)
        ]
        _draw_header(picture, view)
        self._canvas.surface.blit(self._floor, (0, 0))
        draw_arena(self._canvas, placed, view.foods, view.regions)
        picture.blit(self._canvas.downsampled(), layout.arena)
        if len(view.robots) > 1:
            _draw_names(picture, layout, placed)
        for robot, colour, panel in zip(view.robots, colours, layout.panels, strict=True):
            Panel(picture, panel, layout.columns, layout.text_scale, robot, colour).draw()
        return picture

    def _prepare(self, arenas: tuple[Arena, ...], robots: int) -> None:
        layout = arrange(arenas, robots)
        self._canvas = Canvas(layout.arena.size, layout.scale, layout.left, layout.top)
        draw_floor(self._canvas, arenas)
        self._floor = self._canvas.surface.copy()
        self._base = pygame.Surface(layout.size, 0, 32)
        legend = _legend(layout.size[0], panels=robots > 0)
        # Reducing a surface may change its colour by one level. Using the legend's colour everywhere hides its edge.
        self._base.fill(legend.get_at((0, 0)))
        self._base.blit(legend, (0, layout.size[1] - FOOTER))
        for panel in layout.panels:
            box(self._base, panel, palette.CARD, 8, palette.EDGE)
        self._layout, self._prepared_for = layout, (arenas, robots)


def to_array(picture: pygame.Surface) -> NDArray[np.uint8]:
    """A picture as a new array, height x width x 3."""
    width, height = picture.get_size()
    rows = np.frombuffer(pygame.image.tobytes(picture, "RGB"), np.uint8)
    return rows.reshape(height, width, 3).copy()


def _draw_header(picture: pygame.Surface, view: View) -> None:
    """Title on the left, figures on the right, and under them a progress bar of the episode."""
    right, middle = picture.get_width() - GAP, 27
    limit = "" if view.limit is None else f" / {view.limit}"
    figures = [("STEP", f"{view.step}{limit}"), ("DELIVERED", str(view.delivered))]
    if view.score is not None:
        figures.append(("SCORE", f"{view.score:.1f} %"))
    x = right
    for label, value in reversed(figures):
        write(picture, value, x, middle, 24, palette.INK, "right")
        x -= text_width(value, 24) + 7
        write(picture, label, x, middle + 1, 16, palette.MUTED, "right")
        x -= text_width(label, 16) + 26
    write(picture, fitted(view.title, 28, x - GAP), GAP, middle, 28, palette.INK)
    box(picture, (GAP, 48, right - GAP, 3), palette.EDGE)
    if view.limit:
        box(picture, (GAP, 48, (right - GAP) * clamped(view.step / view.limit), 3), palette.WALL)


def _draw_names(picture: pygame.Surface, layout: PictureLayout, robots: Sequence[tuple[RobotView, Colour]]) -> None:
    """Each robot's name below its marker."""
    picture.set_clip(layout.arena)
    for robot, colour in robots:
        x, y, heading = robot.pose
        reach = (MARKER_LENGTH * abs(math.sin(heading)) + MARKER_WIDTH * abs(math.cos(heading))) / 2
        column, row = layout.pixel(x, y - reach)
        row += 9
        for dx, dy in ((-1, 0), (1, 0), (0, -1), (0, 1)):  # a light border keeps the name legible over lines
            write(picture, robot.name, column + dx, row + dy, NAME_SIZE, palette.FLOOR, "centre")
        write(picture, robot.name, column, row, NAME_SIZE, colour, "centre")
    picture.set_clip(None)


def _legend(width: int, panels: bool) -> pygame.Surface:
    """Meaning of the colours and symbols in a strip of one line; entries that do not fit are left out."""
    middle, size, right = FOOTER / 2, LEGEND_SIZE, width - GAP
    canvas = Canvas((width, FOOTER), LEGEND_SCALE, 0.0, FOOTER / LEGEND_SCALE)
    canvas.surface.fill(palette.BACKGROUND)
    food = FoodView(0.0, middle / LEGEND_SCALE)
    region = Region(0, 0.0, food.y / MM_PER_PIXEL, 0, 0, True, False, 0, 0, 0, 0)
    symbols: tuple[tuple[str, FoodView | Region], ...] = (
        ("Unknown food", food),
        ("Pickable", food._replace(food_type=FoodType.PICKABLE)),
        ("Pushable", food._replace(food_type=FoodType.PUSHABLE)),
        ("Poisonous", food._replace(food_type=FoodType.POISONOUS)),
        ("Delivered", food._replace(delivered=True)),
        ("Seen by camera", region),
        ("Lost", region._replace(found=False)),
    )
    labels: list[tuple[str, int]] = []
    left = GAP
    for label, symbol in symbols:
        end = left + 26 + text_width(label, size)
        if end > right:
            break
        x = (left + 11) / LEGEND_SCALE
        if isinstance(symbol, FoodView):
            draw_food(canvas, symbol._replace(x=x))
        else:
            draw_region(canvas, symbol._replace(x=x / MM_PER_PIXEL))
        labels.append((label, left + 26))
        left = end + 18
    strip = canvas.downsampled()
    for label, x in labels:
        write(strip, label, x, middle, size, palette.MUTED)
    if panels:
        _draw_panel_symbols(strip, left + 18)
    return strip


def _draw_panel_symbols(strip: pygame.Surface, left: int) -> None:
    """Write how a panel's list of behaviours marks the state's own, the heard and the executed behaviour."""
    middle, size = FOOTER / 2, LEGEND_SIZE
    for label in ("State's own", "Heard", "Executed"):
        width = text_width(label, size) + 12
        if left + width > strip.get_width() - GAP:
            return
        pill = (left, middle - 8, width, 16)
        if label == "State's own":
            dot(strip, left + 3, middle, 3, palette.INK)
            write(strip, label, left + 12, middle, size, palette.MUTED)
        elif label == "Heard":
            box(strip, pill, palette.CARD, 5, palette.INK)
            write(strip, label, left + 6, middle, size, palette.INK)
        else:
            box(strip, pill, palette.TEACHER, 5)
            write(strip, label, left + 6, middle, size, palette.CARD)
        left += width + 18
