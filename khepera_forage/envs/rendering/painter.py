"""A whole picture: heading, arenas, panels and key."""

import numpy as np
import pygame
from numpy.typing import NDArray

from khepera_forage.envs.rendering import palette
from khepera_forage.envs.rendering.arena_layer import ArenaLayer
from khepera_forage.envs.rendering.key import draw_key
from khepera_forage.envs.rendering.layout import FOOTER, GAP, Layout, arrange
from khepera_forage.envs.rendering.lettering import Lettering
from khepera_forage.envs.rendering.palette import Colour
from khepera_forage.envs.rendering.panel import Panel
from khepera_forage.envs.rendering.view import RobotView, View
from khepera_forage.sim.arena import Arena


class Painter:
    """Paints views on surfaces in memory; what does not change between views of the same arenas is kept."""

    def __init__(self) -> None:
        self._lettering = Lettering()
        self._kept: tuple[tuple[Arena, ...], int] | None = None
        self._layout: Layout
        self._base: pygame.Surface
        self._arenas: ArenaLayer
        self._picture: pygame.Surface

    def paint(self, view: View) -> pygame.Surface:
        """The picture of a view; the same surface as long as the arenas and the number of robots stay.

        Raises:
            ValueError: The view has no arena.
        """
        if self._kept != (view.arenas, len(view.robots)):
            self._prepare(view.arenas, len(view.robots))
        accents = accents_of(view.robots)
        self._picture.blit(self._base, (0, 0))
        self._draw_header(view)
        self._arenas.draw(self._picture, view, accents)
        for robot, accent, box in zip(view.robots, accents, self._layout.panels, strict=True):
            Panel(self._picture, box, self._layout, self._lettering, robot, accent).draw()
        return self._picture

    @staticmethod
    def pixels(picture: pygame.Surface) -> NDArray[np.uint8]:
        """A picture as a fresh array, height x width x 3."""
        width, height = picture.get_size()
        rows = np.frombuffer(pygame.image.tobytes(picture, "RGB"), np.uint8)
        return rows.reshape(height, width, 3).copy()

    def _prepare(self, arenas: tuple[Arena, ...], robots: int) -> None:
        self._layout = arrange(arenas, robots)
        self._picture = pygame.Surface(self._layout.size, 0, 32)
        self._arenas = ArenaLayer(arenas, self._layout, self._lettering)
        self._base = pygame.Surface(self._layout.size, 0, 32)
        key = draw_key(self._layout.size[0], robots > 0, self._lettering)
        # The colour as shrinking leaves it, which may be one off: the arenas' ground would show as a box.
        self._base.fill(key.get_at((0, 0)))
        self._base.blit(key, (0, self._layout.size[1] - FOOTER))
        for box in self._layout.panels:
            self._lettering.box(self._base, box, palette.CARD, 8, palette.EDGE)
        self._kept = (arenas, robots)

    def _draw_header(self, view: View) -> None:
        """Title on the left, figures on the right, how far the episode is under them."""
        right, middle = self._layout.size[0] - GAP, 27
        limit = "" if view.limit is None else f" / {view.limit}"
        figures = [("STEP", f"{view.step}{limit}"), ("DELIVERED", str(view.delivered))]
        if view.score is not None:
            figures.append(("SCORE", f"{view.score:.1f} %"))
        x = float(right)
        for label, value in reversed(figures):
            self._lettering.write(self._picture, value, x, middle, 24, palette.INK, "right")
            x -= self._lettering.width(value, 24) + 7
            self._lettering.write(self._picture, label, x, middle + 1, 16, palette.FADED, "right")
            x -= self._lettering.width(label, 16) + 26
        title = self._lettering.fitted(view.title, 28, x - GAP)
        self._lettering.write(self._picture, title, GAP, middle, 28, palette.INK)
        self._lettering.box(self._picture, (GAP, 48, right - GAP, 3), palette.EDGE)
        if view.limit:
            share = max(0.0, min(1.0, view.step / view.limit))
            self._lettering.box(self._picture, (GAP, 48, (right - GAP) * share, 3), palette.WALL)


def accents_of(robots: tuple[RobotView, ...]) -> tuple[Colour, ...]:
    """The colour of each robot, in the arena and on its panel."""
    accents: list[Colour] = []
    learners = 0
    for robot in robots:
        if robot.holes == 1:
            accents.append(palette.TEACHER)
        else:
            accents.append(palette.LEARNERS[learners % len(palette.LEARNERS)])
            learners += 1
    return tuple(accents)
