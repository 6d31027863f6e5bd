"""Text and rounded boxes, at whole pixels, with smooth edges; what has been drawn once is kept."""

import math
from typing import Literal

import pygame

from khepera_forage.envs.rendering.palette import Colour

Anchor = Literal["left", "centre", "right"]
Rect = tuple[float, float, float, float]

KEPT = 3000
"""Pieces of text, and of boxes, kept at most; an episode needs a few hundred."""
FINER = 4
"""How many times finer boxes are drawn before they are shrunk."""
LARGER = 3
"""How many times larger text is drawn: drawn small, letters stand at whole pixels, unevenly."""


class Lettering:
    """Writes with pygame's own font, which is the same on every computer."""

    def __init__(self) -> None:
        pygame.font.init()
        self._fonts: dict[int, pygame.font.Font] = {}
        self._texts: dict[tuple[str, int, Colour], pygame.Surface] = {}
        self._boxes: dict[tuple[int, int, int, Colour, Colour | None], pygame.Surface] = {}

    def width(self, text: str, size: float) -> int:
        """Pixels across a text."""
        return math.ceil(self._font(size).size(_plain(text))[0] / LARGER)

    def fitted(self, text: str, size: float, width: float) -> str:
        """The text, its end cut off if it is wider than `width` pixels."""
        text = _plain(text)
        if self.width(text, size) <= width:
            return text
        while text and self.width(text + "…", size) > width:
            text = text[:-1]
        return text.rstrip() + "…" if text else ""

    def write(
        self,
        on: pygame.Surface,
        text: str,
        x: float,
        middle: float,
        size: float,
        colour: Colour,
        anchor: Anchor = "left",
    ) -> None:
        """Write at `x`, capitals centred on the height `middle`."""
        key = (_plain(text), round(size * LARGER), colour)
        drawn = self._texts.get(key)
        if drawn is None:
            if len(self._texts) >= KEPT:
                self._texts.clear()
            large = self._font(size).render(key[0], True, colour)
            small = math.ceil(large.get_width() / LARGER), math.ceil(large.get_height() / LARGER)
            drawn = self._texts[key] = pygame.transform.smoothscale(large, small)
        left = x - {"left": 0.0, "centre": 0.5, "right": 1.0}[anchor] * drawn.get_width()
        # Half a capital is a quarter of the font's size, by measure.
        top = middle - self._font(size).get_ascent() / LARGER + 0.25 * size
        on.blit(drawn, (round(left), round(top)))

    def box(
        self, on: pygame.Surface, rect: Rect, colour: Colour, radius: float = 0.0, edge: Colour | None = None
    ) -> None:
        """Fill a rectangle with round corners, with an edge one pixel wide if it has a colour."""
        left, top = round(rect[0]), round(rect[1])
        width, height = round(rect[0] + rect[2]) - left, round(rect[1] + rect[3]) - top
        if width <= 0 or height <= 0:
            return
        radius = min(round(radius), width // 2, height // 2)
        if radius == 0 and edge is None:
            on.fill(colour, (left, top, width, height))
            return
        key = (width, height, int(radius), colour, edge)
        drawn = self._boxes.get(key)
        if drawn is None:
            if len(self._boxes) >= KEPT:
                self._boxes.clear()
            drawn = self._boxes[key] = _smooth_box(*key)
        on.blit(drawn, (left, top))

    def dot(self, on: pygame.Surface, x: float, y: float, radius: float, colour: Colour) -> None:
        """Fill a circle."""
        self.box(on, (x - radius, y - radius, 2 * radius, 2 * radius), colour, radius)

    def _font(self, size: float) -> pygame.font.Font:
        large = round(size * LARGER)
        if large not in self._fonts:
            self._fonts[large] = pygame.font.Font(None, large)
        return self._fonts[large]


def _plain(text: str) -> str:
    """On one line, without the zero character, which fonts refuse."""
    return " ".join(text.replace("\0", "").split())


def _smooth_box(width: int, height: int, radius: int, colour: Colour, edge: Colour | None) -> pygame.Surface:
    large = pygame.Surface((width * FINER, height * FINER), pygame.SRCALPHA, 32)
    # See-through pixels of the outline's own colour: black ones would darken the edge when it is shrunk.
    large.fill((*(edge or colour), 0))
    rect = large.get_rect()
    pygame.draw.rect(large, edge or colour, rect, border_radius=radius * FINER)
    if edge is not None:
        inner = rect.inflate(-2 * FINER, -2 * FINER)
        pygame.draw.rect(large, colour, inner, border_radius=max(0, radius - 1) * FINER)
    return pygame.transform.smoothscale(large, (width, height))
