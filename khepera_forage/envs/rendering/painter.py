"""A whole picture: header, arenas, panels and legend."""

import numpy as np
import pygame
from numpy.typing import NDArray

from khepera_forage.envs.rendering import palette
from khepera_forage.envs.rendering.arena_layer import ArenaLayer
from khepera_forage.envs.rendering.layout import FOOTER, GAP, Layout, arrange
from khepera_forage.envs.rendering.legend import draw_legend
from khepera_forage.envs.rendering.palette import Colour
from khepera_forage.envs.rendering.panel import Panel
from khepera_forage.envs.rendering.text import TextRenderer
from khepera_forage.envs.rendering.view import RobotView, View
from khepera_forage.sim.arena import Arena


class Painter:
    """Paints views on surfaces in memory, without a display.

    The layout, the legend and the floor are drawn once and reused while the arenas and the number of robots stay.
    """

    def __init__(self) -> None:
        self._text = TextRenderer()
        self._prepared_for: tuple[tuple[Arena, ...], int] | None = None
        self._layout: Layout
        self._base: pygame.Surface
        self._arenas: ArenaLayer
        self._picture: pygame.Surface

    def paint(self, view: View) -> pygame.Surface:
        """The picture of a view; the same surface while the arenas and the number of robots stay.

        Raises:
            ValueError: The view has no arena.
        """
        if self._prepared_for != (view.arenas, len(view.robots)):
            self._prepare(view.arenas, len(view.robots))
        colours = robot_colours(view.robots)
        self._picture.blit(self._base, (0, 0))
        self._draw_header(view)
        self._arenas.draw(self._picture, view, colours)
        for robot, colour, box in zip(view.robots, colours, self._layout.panels, strict=True):
            Panel(self._picture, box, self._layout, self._text, robot, colour).draw()
        return self._picture

    @staticmethod
    def to_array(picture: pygame.Surface) -> NDArray[np.uint8]:
        """A picture as a new array, height x width x 3."""
        width, height = picture.get_size()
        rows = np.frombuffer(pygame.image.tobytes(picture, "RGB"), np.uint8)
        return rows.reshape(height, width, 3).copy()

    def _prepare(self, arenas: tuple[Arena, ...], robots: int) -> None:
        self._layout = arrange(arenas, robots)
        self._picture = pygame.Surface(self._layout.size, 0, 32)
        self._arenas = ArenaLayer(arenas, self._layout, self._text)
        self._base = pygame.Surface(self._layout.size, 0, 32)
        legend = draw_legend(self._layout.size[0], robots > 0, self._text)
        # Reducing a surface may change its colour by one level. Using the legend's colour everywhere hides its edge.
        self._base.fill(legend.get_at((0, 0)))
        self._base.blit(legend, (0, self._layout.size[1] - FOOTER))
        for box in self._layout.panels:
            self._text.box(self._base, box, palette.CARD, 8, palette.EDGE)
        self._prepared_for = (arenas, robots)

    def _draw_header(self, view: View) -> None:
        """Title on the left, figures on the right, and under them a progress bar of the episode."""
        right, middle = self._layout.size[0] - GAP, 27
        limit = "" if view.limit is None else f" / {view.limit}"
        figures = [("STEP", f"{view.step}{limit}"), ("DELIVERED", str(view.delivered))]
        if view.score is not None:
            figures.append(("SCORE", f"{view.score:.1f} %"))
        x = float(right)
        for label, value in reversed(figures):
            self._text.write(self._picture, value, x, middle, 24, palette.INK, "right")
            x -= self._text.width(value, 24) + 7
            self._text.write(self._picture, label, x, middle + 1, 16, palette.MUTED, "right")
            x -= self._text.width(label, 16) + 26
        title = self._text.fitted(view.title, 28, x - GAP)
        self._text.write(self._picture, title, GAP, middle, 28, palette.INK)
        self._text.box(self._picture, (GAP, 48, right - GAP, 3), palette.EDGE)
        if view.limit:
            share = max(0.0, min(1.0, view.step / view.limit))
            self._text.box(self._picture, (GAP, 48, (right - GAP) * share, 3), palette.WALL)


def robot_colours(robots: tuple[RobotView, ...]) -> tuple[Colour, ...]:
    """The colour of each robot, in the arena and on its panel."""
    colours: list[Colour] = []
    learners = 0
    for robot in robots:
        if robot.holes == 1:
            colours.append(palette.TEACHER)
        else:
            colours.append(palette.LEARNERS[learners % len(palette.LEARNERS)])
            learners += 1
    return tuple(colours)
