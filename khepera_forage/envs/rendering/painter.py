"""A whole picture: heading, arenas, panels and key."""

from collections.abc import Callable

import numpy as np
import pygame
from numpy.typing import NDArray

from khepera_forage.envs.rendering import palette
from khepera_forage.envs.rendering.arena_layer import ArenaLayer, draw_food, draw_region
from khepera_forage.envs.rendering.layout import FOOTER, GAP, HEADER, Layout, arrange
from khepera_forage.envs.rendering.lettering import Lettering
from khepera_forage.envs.rendering.palette import Colour
from khepera_forage.envs.rendering.panel import Panel
from khepera_forage.envs.rendering.pen import Pen
from khepera_forage.envs.rendering.view import FoodView, RobotView, View
from khepera_forage.foraging.states import FoodType
from khepera_forage.vision.scene import Region
from khepera_forage.worlds.arena import Arena


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
        self._base = pygame.Surface(self._layout.size, 0, 32)
        self._base.fill(palette.PAPER)
        for box in self._layout.panels:
            self._lettering.box(self._base, box, palette.CARD, 8, palette.EDGE)
        self._draw_key(robots > 0)
        self._arenas = ArenaLayer(arenas, self._layout, self._lettering)
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

    def _draw_key(self, panels: bool) -> None:
        """What colours and signs mean, in one line as far as it fits."""
        width, height = self._layout.size
        scale = 0.4
        pen = Pen((width, FOOTER), scale, 0.0, FOOTER / scale)
        pen.surface.fill(palette.PAPER)
        middle = FOOTER / 2
        labels: list[tuple[float, str]] = []
        x = float(GAP)

        def region(found: bool) -> Callable[[float], None]:
            return lambda mm: draw_region(pen, Region(0, mm / 5, middle / scale / 5, 0, 0, found, False, 0, 0, 0, 0, 0))

        def food(kind: FoodType, delivered: bool = False) -> Callable[[float], None]:
            return lambda mm: draw_food(pen, FoodView(mm, middle / scale, kind, delivered=delivered))

        signs: list[tuple[str, Callable[[float], None]]] = [
            *((f"{kind.name.capitalize()} food", food(kind)) for kind in FoodType),
            ("Delivered", food(FoodType.UNKNOWN, delivered=True)),
            ("Seen by the camera", region(True)),
            ("Lost by the camera", region(False)),
        ]
        for text, sign in signs:
            sign((x + 9) / scale)
            labels.append((x + 24, text))
            x += 24 + self._lettering.width(text, 16) + 20
        self._base.blit(pen.shrunk(), (0, height - FOOTER))
        for left, text in labels:
            self._lettering.write(self._base, text, left, height - FOOTER + middle, 16, palette.FADED)


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
