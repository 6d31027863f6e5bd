"""Anti-aliased shapes, given in mm, on a pygame surface that is drawn enlarged and then reduced."""

import math
from collections.abc import Iterable, Sequence

import pygame
import pygame.gfxdraw

from khepera_forage.envs.rendering.palette import Colour
from khepera_forage.sim.arena import Pose

SUPERSAMPLING = 3
"""The surface is larger than the picture by this factor."""

XY = tuple[float, float]


class Canvas:
    """Draws shapes on an enlarged surface; positions are in mm, y up, and line widths in pixels of the picture.

    Attributes:
        surface: The surface, `SUPERSAMPLING` times larger than the picture.
    """

    def __init__(self, size: tuple[int, int], scale: float, left: float, top: float) -> None:
        """A blank surface.

        Args:
            size: Width and height of the picture in pixels.
            scale: Pixels of the picture per mm.
            left: x in mm of the picture's left side.
            top: y in mm of the picture's upper side.
        """
        self.surface = pygame.Surface((size[0] * SUPERSAMPLING, size[1] * SUPERSAMPLING), 0, 32)
        self._small = pygame.Surface(size, 0, 32)
        self._scale = scale * SUPERSAMPLING
        self._mm_per_pixel = 1.0 / scale
        self._left = left
        self._top = top

    def downsampled(self) -> pygame.Surface:
        """The picture; the same surface at every call."""
        return pygame.transform.smoothscale(self.surface, self._small.get_size(), self._small)

    def polygon(self, corners: Iterable[XY], colour: Colour, alpha: int = 255) -> None:
        """Fill a polygon."""
        points = [self._surface_point(corner) for corner in corners]
        if alpha == 255:
            pygame.draw.polygon(self.surface, colour, points)
        else:
            pygame.gfxdraw.filled_polygon(self.surface, points, (*colour, alpha))

    def disc(self, centre: XY, radius: float, colour: Colour) -> None:
        """Fill a circle with a radius in mm."""
        pygame.draw.circle(self.surface, colour, self._surface_point(centre), radius * self._scale)

    def ring(self, centre: XY, radius: float, colour: Colour, width: float = 1.0) -> None:
        """Draw a circle whose line lies just inside the radius."""
        line = max(1, round(width * SUPERSAMPLING))
        pygame.draw.circle(self.surface, colour, self._surface_point(centre), radius * self._scale, line)

    def line(self, a: XY, b: XY, colour: Colour, width: float = 1.0) -> None:
        """Draw a straight line with square ends, of the same width at every slope."""
        length = math.hypot(b[0] - a[0], b[1] - a[1])
        if length == 0:
            return
        half = width * self._mm_per_pixel / 2
        dx, dy = (b[0] - a[0]) / length * half, (b[1] - a[1]) / length * half
        # The ends extend half a width beyond their points, so that two lines that meet form a closed corner.
        a, b = (a[0] - dx, a[1] - dy), (b[0] + dx, b[1] + dy)
        self.polygon(
            ((a[0] - dy, a[1] + dx), (a[0] + dy, a[1] - dx), (b[0] + dy, b[1] - dx), (b[0] - dy, b[1] + dx)),
            colour,
        )

    def outline(
        self, corners: Sequence[XY], colour: Colour, width: float = 1.0, dash: float | None = None
    ) -> None:
        """Draw a closed line through the corners; dashes have this length in pixels."""
        for a, b in zip(corners, (*corners[1:], corners[0]), strict=True):
            if dash is None:
                self.line(a, b, colour, width)
                continue
            length = math.hypot(b[0] - a[0], b[1] - a[1])
            # With an odd number of pieces every side begins and ends with a dash, which shows the corners.
            pieces = 2 * max(1, round(length / (2 * dash * self._mm_per_pixel))) + 1
            for i in range(0, pieces, 2):
                self.line(
                    _interpolated(a, b, i / pieces), _interpolated(a, b, (i + 1) / pieces), colour, width
                )

    def _surface_point(self, position: XY) -> XY:
        """Pixels of the enlarged surface; limited, because pygame's drawing functions overflow."""
        x = max(-9000.0, min(9000.0, (position[0] - self._left) * self._scale))
        y = max(-9000.0, min(9000.0, (self._top - position[1]) * self._scale))
        return x, y


def transformed(pose: Pose, corners: Iterable[XY], dx: float = 0.0, dy: float = 0.0) -> list[XY]:
    """Points in a robot's frame (mm forward, mm left) as points in the arena, shifted by (dx, dy) mm."""
    cosine, sine = math.cos(pose.heading), math.sin(pose.heading)
    return [(pose.x + dx + x * cosine - y * sine, pose.y + dy + x * sine + y * cosine) for x, y in corners]


def rectangle(x1: float, y1: float, x2: float, y2: float) -> tuple[XY, XY, XY, XY]:
    """Corners of an axis-aligned rectangle, in order."""
    return (x1, y1), (x2, y1), (x2, y2), (x1, y2)


def regular_polygon(centre: XY, radius: float, corners: int) -> list[XY]:
    """Corners of a regular polygon, as an approximation of a circle."""
    angles = (2 * math.pi * i / corners for i in range(corners))
    return [(centre[0] + radius * math.cos(a), centre[1] + radius * math.sin(a)) for a in angles]


def _interpolated(a: XY, b: XY, share: float) -> XY:
    return a[0] + (b[0] - a[0]) * share, a[1] + (b[1] - a[1]) * share
