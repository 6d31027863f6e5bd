"""Anti-aliased text and rounded boxes at whole pixels; drawn pieces are cached."""

import math
from typing import Literal

import pygame

from khepera_forage.envs.rendering.palette import Colour

Anchor = Literal["left", "centre", "right"]
Rect = tuple[float, float, float, float]
"""Left, top, width and height in pixels."""

CACHE_SIZE = 3000
"""Greatest number of cached texts, and of cached boxes; an episode needs a few hundred."""
BOX_SUPERSAMPLING = 4
"""Boxes are drawn enlarged by this factor, then reduced."""
TEXT_SUPERSAMPLING = 3
"""The same for text. Small text would be spaced unevenly, because letters are placed at whole pixels."""


class TextRenderer:
    """Draws text and rounded boxes with pygame's built-in font, which is the same on every computer."""

    def __init__(self) -> None:
        pygame.font.init()
        self._fonts: dict[int, pygame.font.Font] = {}
        self._texts: dict[tuple[str, int, Colour], pygame.Surface] = {}
        self._boxes: dict[tuple[int, int, int, Colour, Colour | None], pygame.Surface] = {}

    def width(self, text: str, size: float) -> int:
        """Width of a text in pixels."""
        return math.ceil(self._font(size).size(_on_one_line(text))[0] / TEXT_SUPERSAMPLING)

    def fitted(self, text: str, size: float, width: float) -> str:
        """The text, shortened with an ellipsis if it is wider than `width` pixels."""
        text = _on_one_line(text)
        if self.width(text, size) <= width:
            return text
        while text and self.width(text + "…", size) > width:
            text = text[:-1]
        return text.rstrip() + "…" if text else ""

    def write(
        self,
        surface: pygame.Surface,
        text: str,
        x: float,
        y: float,
        size: float,
        colour: Colour,
        anchor: Anchor = "left",
    ) -> None:
        """Write at `x`, with capital letters vertically centred on `y`."""
        key = (_on_one_line(text), round(size * TEXT_SUPERSAMPLING), colour)
        drawn = self._texts.get(key)
        if drawn is None:
            if len(self._texts) >= CACHE_SIZE:
                self._texts.clear()
            large = self._font(size).render(key[0], True, colour)
            small = (
                math.ceil(large.get_width() / TEXT_SUPERSAMPLING),
                math.ceil(large.get_height() / TEXT_SUPERSAMPLING),
            )
            drawn = self._texts[key] = pygame.transform.smoothscale(large, small)
        left = x - {"left": 0.0, "centre": 0.5, "right": 1.0}[anchor] * drawn.get_width()
        # Half the height of a capital letter is a quarter of the font's size (measured).
        top = y - self._font(size).get_ascent() / TEXT_SUPERSAMPLING + 0.25 * size
        surface.blit(drawn, (round(left), round(top)))

    def box(
        self,
        surface: pygame.Surface,
        rect: Rect,
        colour: Colour,
        radius: float = 0.0,
        edge: Colour | None = None,
    ) -> None:
        """Fill a rectangle with rounded corners, and draw an edge one pixel wide if `edge` is a colour."""
        left, top = round(rect[0]), round(rect[1])
        width, height = round(rect[0] + rect[2]) - left, round(rect[1] + rect[3]) - top
        if width <= 0 or height <= 0:
            return
        radius = min(round(radius), width // 2, height // 2)
        if radius == 0 and edge is None:
            surface.fill(colour, (left, top, width, height))
            return
        key = (width, height, int(radius), colour, edge)
        drawn = self._boxes.get(key)
        if drawn is None:
            if len(self._boxes) >= CACHE_SIZE:
                self._boxes.clear()
            drawn = self._boxes[key] = _smooth_box(*key)
        surface.blit(drawn, (left, top))

    def dot(self, surface: pygame.Surface, x: float, y: float, radius: float, colour: Colour) -> None:
        """Fill a circle."""
        self.box(surface, (x - radius, y - radius, 2 * radius, 2 * radius), colour, radius)

    def _font(self, size: float) -> pygame.font.Font:
        large = round(size * TEXT_SUPERSAMPLING)
        if large not in self._fonts:
            self._fonts[large] = pygame.font.Font(None, large)
        return self._fonts[large]


def _on_one_line(text: str) -> str:
    """The text on one line, without null characters, which fonts refuse."""
    return " ".join(text.replace("\0", "").split())


def _smooth_box(width: int, height: int, radius: int, colour: Colour, edge: Colour | None) -> pygame.Surface:
    large = pygame.Surface((width * BOX_SUPERSAMPLING, height * BOX_SUPERSAMPLING), pygame.SRCALPHA, 32)
    # Transparent pixels have the outline's colour: black ones would darken the edge when the box is reduced.
    large.fill((*(edge or colour), 0))
    rect = large.get_rect()
    pygame.draw.rect(large, edge or colour, rect, border_radius=radius * BOX_SUPERSAMPLING)
    if edge is not None:
        inner = rect.inflate(-2 * BOX_SUPERSAMPLING, -2 * BOX_SUPERSAMPLING)
        pygame.draw.rect(large, colour, inner, border_radius=max(0, radius - 1) * BOX_SUPERSAMPLING)
    return pygame.transform.smoothscale(large, (width, height))
