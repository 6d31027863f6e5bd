"""Drawing on pygame surfaces: shapes in mm on a canvas that is reduced later, text and boxes at whole pixels."""

import math
from collections.abc import Iterable, Sequence
from functools import lru_cache
from typing import Literal

import pygame
import pygame.gfxdraw

from khepera_forage.envs.rendering.palette import Colour
from khepera_forage.sim.arena import Pose

SUPERSAMPLING = 3
"""Canvases and text are drawn enlarged by this factor, then reduced."""
BOX_SUPERSAMPLING = 4
"""The same for boxes."""
CACHE_SIZE = 3000
"""Greatest number of cached texts, and of cached boxes; an episode needs a few hundred."""

XY = tuple[float, float]
Anchor = Literal["left", "centre", "right"]
Rect = tuple[float, float, float, float] | pygame.Rect
"""Left, top, width and height in pixels."""


def clamped(share: float) -> float:
    """The nearest number in 0..1."""
    return max(0.0, min(1.0, share))


class Canvas:
    """Draws shapes on an enlarged surface; positions are in mm, y up, and line widths in pixels of the picture.

    Args:
        size: Width and height of the picture in pixels.
        scale: Pixels of the picture per mm.
        left: x in mm of the picture's left side.
        top: y in mm of the picture's upper side.

    Attributes:
        surface: The surface, `SUPERSAMPLING` times larger than the picture.
        scale: As given.
    """

    def __init__(self, size: tuple[int, int], scale: float, left: float, top: float) -> None:
        self.surface = pygame.Surface((size[0] * SUPERSAMPLING, size[1] * SUPERSAMPLING), 0, 32)
        self._size = size
        self.scale = scale
        self._left = left
        self._top = top

    def downsampled(self) -> pygame.Surface:
        """The picture, a new surface."""
        return pygame.transform.smoothscale(self.surface, self._size)

    def polygon(self, corners: Iterable[XY], colour: Colour, alpha: int = 255) -> None:
        """Fill a polygon."""
        points = [self._surface_point(corner) for corner in corners]
        if alpha == 255:
            pygame.draw.polygon(self.surface, colour, points)
        else:
            pygame.gfxdraw.filled_polygon(self.surface, points, (*colour, alpha))

    def circle(self, centre: XY, radius: float, colour: Colour, width: float = 0.0) -> None:
        """Fill a circle with a radius in mm, or draw a line of this width just inside the radius."""
        point, large = self._surface_point(centre), radius * (self.scale * SUPERSAMPLING)
        pygame.draw.circle(self.surface, colour, point, large, round(width * SUPERSAMPLING))

    def line(self, a: XY, b: XY, colour: Colour, width: float = 1.0) -> None:
        """Draw a straight line with square ends, of the same width at every slope."""
        length = math.hypot(b[0] - a[0], b[1] - a[1])
        if length == 0:
            return
        half = width / self.scale / 2
        dx, dy = (b[0] - a[0]) / length * half, (b[1] - a[1]) / length * half
        # The ends extend half a width beyond their points, so that two lines that meet form a closed corner.
        a, b = (a[0] - dx, a[1] - dy), (b[0] + dx, b[1] + dy)
        corners = ((a[0] - dy, a[1] + dx), (a[0] + dy, a[1] - dx), (b[0] + dy, b[1] - dx), (b[0] - dy, b[1] + dx))
        self.polygon(corners, colour)

    def outline(self, corners: Sequence[XY], colour: Colour, width: float = 1.0) -> None:
        """Draw a closed line through the corners."""
        for a, b in zip(corners, (*corners[1:], corners[0]), strict=True):
            self.line(a, b, colour, width)

    def dashed_outline(self, corners: Sequence[XY], colour: Colour, dash: float) -> None:
        """Draw a closed line through the corners in dashes of this length in pixels."""
        for (x1, y1), (x2, y2) in zip(corners, (*corners[1:], corners[0]), strict=True):
            length = math.hypot(x2 - x1, y2 - y1) * self.scale
            # With an odd number of pieces every side begins and ends with a dash, which shows the corners.
            pieces = 2 * max(1, round(length / (2 * dash))) + 1
            ends = [(x1 + (x2 - x1) * i / pieces, y1 + (y2 - y1) * i / pieces) for i in range(pieces + 1)]
            for a, b in zip(ends[::2], ends[1::2], strict=True):
                self.line(a, b, colour)

    def label(self, text: str, centre: XY, size: float, colour: Colour) -> None:
        """Write a text in the middle of a position; its size is in pixels of the picture."""
        x = math.floor((centre[0] - self._left) * self.scale) * SUPERSAMPLING
        y = math.floor((self._top - centre[1]) * self.scale) * SUPERSAMPLING
        write(self.surface, text, x, y, size * SUPERSAMPLING, colour, "centre")

    def _surface_point(self, position: XY) -> XY:
        """Pixels of the enlarged surface; limited, because pygame's drawing functions overflow."""
        scale = self.scale * SUPERSAMPLING
        x = max(-9000.0, min(9000.0, (position[0] - self._left) * scale))
        y = max(-9000.0, min(9000.0, (self._top - position[1]) * scale))
        return x, y


def transformed(pose: Pose, corners: Iterable[XY]) -> list[XY]:
    """Points in a robot's frame (mm forward, mm left) as points in the arena."""
    cosine, sine = math.cos(pose.heading), math.sin(pose.heading)
    return [(pose.x + x * cosine - y * sine, pose.y + x * sine + y * cosine) for x, y in corners]


def rectangle(x1: float, y1: float, x2: float, y2: float) -> tuple[XY, XY, XY, XY]:
    """Corners of an axis-aligned rectangle, in order."""
    return (x1, y1), (x2, y1), (x2, y2), (x1, y2)


def regular_polygon(centre: XY, radius: float, corners: int) -> list[XY]:
    """Corners of a regular polygon, as an approximation of a circle."""
    angles = (2 * math.pi * i / corners for i in range(corners))
    return [(centre[0] + radius * math.cos(a), centre[1] + radius * math.sin(a)) for a in angles]


def write(
    surface: pygame.Surface, text: str, x: float, y: float, size: float, colour: Colour, anchor: Anchor = "left"
) -> None:
    """Write at `x`, with capital letters vertically centred on `y`."""
    drawn, ascent = _text_picture(_on_one_line(text), round(size * SUPERSAMPLING), colour)
    left = x - {"left": 0.0, "centre": 0.5, "right": 1.0}[anchor] * drawn.get_width()
    # Half the height of a capital letter is a quarter of the font's size (measured).
    surface.blit(drawn, (round(left), round(y - ascent + 0.25 * size)))


@lru_cache(CACHE_SIZE)
def text_width(text: str, size: float) -> int:
    """Width of a text in pixels."""
    width, _ = _font(round(size * SUPERSAMPLING)).size(_on_one_line(text))
    return math.ceil(width / SUPERSAMPLING)


def fitted(text: str, size: float, width: float) -> str:
    """The text, shortened with an ellipsis if it is wider than `width` pixels."""
    text = _on_one_line(text)
    if text_width(text, size) <= width:
        return text
    while text and text_width(text + "…", size) > width:
        text = text[:-1]
    return text.rstrip() + "…" if text else ""


def box(surface: pygame.Surface, rect: Rect, colour: Colour, radius: float = 0.0, edge: Colour | None = None) -> None:
    """Fill a rectangle with rounded corners, and draw an edge one pixel wide if `edge` is a colour."""
    left, top = round(rect[0]), round(rect[1])
    width, height = round(rect[0] + rect[2]) - left, round(rect[1] + rect[3]) - top
    if width <= 0 or height <= 0:
        return
    radius = min(round(radius), width // 2, height // 2)
    if radius == 0 and edge is None:
        surface.fill(colour, (left, top, width, height))
    else:
        surface.blit(_box_picture(width, height, radius, colour, edge), (left, top))


def dot(surface: pygame.Surface, x: float, y: float, radius: float, colour: Colour) -> None:
    """Fill a circle."""
    box(surface, (x - radius, y - radius, 2 * radius, 2 * radius), colour, radius)


def _on_one_line(text: str) -> str:
    """The text on one line, without null characters, which fonts refuse."""
    return " ".join(text.replace("\0", "").split())


def _font(size: int) -> pygame.font.Font:
    """The built-in font of pygame, which is the same on every computer.

    It is not cached: other programs' `pygame.quit` makes fonts unusable, but not pictures of text.
    """
    pygame.font.init()
    return pygame.font.Font(None, size)


@lru_cache(CACHE_SIZE)
def _text_picture(text: str, size: int, colour: Colour) -> tuple[pygame.Surface, float]:
    """A text and its ascent in pixels; small fonts would space it unevenly, as letters are at whole pixels."""
    font = _font(size)
    large = font.render(text, True, colour)
    width, height = large.get_size()
    reduced = math.ceil(width / SUPERSAMPLING), math.ceil(height / SUPERSAMPLING)
    return pygame.transform.smoothscale(large, reduced), font.get_ascent() / SUPERSAMPLING


@lru_cache(CACHE_SIZE)
def _box_picture(width: int, height: int, radius: int, colour: Colour, edge: Colour | None) -> pygame.Surface:
    large = pygame.Surface((width * BOX_SUPERSAMPLING, height * BOX_SUPERSAMPLING), pygame.SRCALPHA, 32)
    # Transparent pixels have the outline's colour: black ones would darken the edge when the box is reduced.
    large.fill((*(edge or colour), 0))
    rect = large.get_rect()
    pygame.draw.rect(large, edge or colour, rect, border_radius=radius * BOX_SUPERSAMPLING)
    if edge is not None:
        inner = rect.inflate(-2 * BOX_SUPERSAMPLING, -2 * BOX_SUPERSAMPLING)
        pygame.draw.rect(large, colour, inner, border_radius=max(0, radius - 1) * BOX_SUPERSAMPLING)
    return pygame.transform.smoothscale(large, (width, height))
