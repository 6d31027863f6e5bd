"""Drawing in millimetres on a surface that is finer than the picture: shrunk, its edges are smooth."""

import math
from collections.abc import Iterable, Sequence

import pygame
import pygame.gfxdraw

from khepera_forage.envs.rendering.palette import Colour
from khepera_forage.sim.arena import Pose

FINER = 3
"""How many times finer than the picture the surface is."""

Spot = tuple[float, float]


class Pen:
    """Draws on a fine surface; places are in mm, y up, and widths of lines in pixels of the picture.

    Attributes:
        surface: `FINER` times larger than what it becomes.
    """

    def __init__(self, size: tuple[int, int], scale: float, west: float, north: float) -> None:
        """A blank surface.

        Args:
            size: Of the shrunk picture.
            scale: Pixels of the picture a millimetre.
            west: x in mm of its left side.
            north: y in mm of its upper side.
        """
        self.surface = pygame.Surface((size[0] * FINER, size[1] * FINER), 0, 32)
        self._small = pygame.Surface(size, 0, 32)
        self._scale = scale * FINER
        self._pixel = 1.0 / scale
        self._west = west
        self._north = north

    def shrunk(self) -> pygame.Surface:
        """The picture; the same surface every time."""
        return pygame.transform.smoothscale(self.surface, self._small.get_size(), self._small)

    def polygon(self, corners: Iterable[Spot], colour: Colour, alpha: int = 255) -> None:
        """Fill a polygon."""
        spots = [self._spot(c) for c in corners]
        if alpha == 255:
            pygame.draw.polygon(self.surface, colour, spots)
        else:
            pygame.gfxdraw.filled_polygon(self.surface, spots, (*colour, alpha))

    def disc(self, centre: Spot, radius: float, colour: Colour) -> None:
        """Fill a circle of a radius in mm."""
        pygame.draw.circle(self.surface, colour, self._spot(centre), radius * self._scale)

    def ring(self, centre: Spot, radius: float, colour: Colour, width: float = 1.0) -> None:
        """Draw a circle, its line just inside the radius."""
        line = max(1, round(width * FINER))
        pygame.draw.circle(self.surface, colour, self._spot(centre), radius * self._scale, line)

    def line(self, a: Spot, b: Spot, colour: Colour, width: float = 1.0) -> None:
        """Draw a straight line with square ends, as wide at every slope."""
        length = math.hypot(b[0] - a[0], b[1] - a[1])
        if length == 0:
            return
        half = width * self._pixel / 2
        dx, dy = (b[0] - a[0]) / length * half, (b[1] - a[1]) / length * half
        # Ends reach half a width beyond their points, so that lines that meet close their corner.
        a, b = (a[0] - dx, a[1] - dy), (b[0] + dx, b[1] + dy)
        self.polygon(
            ((a[0] - dy, a[1] + dx), (a[0] + dy, a[1] - dx), (b[0] + dy, b[1] - dx), (b[0] - dy, b[1] + dx)),
            colour,
        )

    def path(
        self, spots: Sequence[Spot], colour: Colour, width: float = 1.0, dash: float | None = None
    ) -> None:
        """Draw a closed line through the spots, in dashes of so many pixels if wanted."""
        for a, b in zip(spots, (*spots[1:], spots[0]), strict=True):
            if dash is None:
                self.line(a, b, colour, width)
                continue
            length = math.hypot(b[0] - a[0], b[1] - a[1])
            # An odd number of pieces: dashes then begin and end every side, and show its corners.
            pieces = 2 * max(1, round(length / (2 * dash * self._pixel))) + 1
            for i in range(0, pieces, 2):
                self.line(_between(a, b, i / pieces), _between(a, b, (i + 1) / pieces), colour, width)

    def _spot(self, place: Spot) -> Spot:
        # Far outside the surface nothing is seen, and the drawing functions would overflow.
        x = max(-9000.0, min(9000.0, (place[0] - self._west) * self._scale))
        y = max(-9000.0, min(9000.0, (self._north - place[1]) * self._scale))
        return x, y


def placed(pose: Pose, corners: Iterable[Spot], dx: float = 0.0, dy: float = 0.0) -> list[Spot]:
    """Points of a robot (mm forward, mm left) where the robot stands, moved by an offset in mm."""
    cosine, sine = math.cos(pose.heading), math.sin(pose.heading)
    return [(pose.x + dx + x * cosine - y * sine, pose.y + dy + x * sine + y * cosine) for x, y in corners]


def block(x1: float, y1: float, x2: float, y2: float) -> tuple[Spot, Spot, Spot, Spot]:
    """Corners of an upright rectangle, in turn."""
    return (x1, y1), (x2, y1), (x2, y2), (x1, y2)


def around(centre: Spot, radius: float, corners: int) -> list[Spot]:
    """Corners of a regular polygon about a centre: a circle to draw in dashes."""
    steps = (2 * math.pi * i / corners for i in range(corners))
    return [(centre[0] + radius * math.cos(a), centre[1] + radius * math.sin(a)) for a in steps]


def _between(a: Spot, b: Spot, share: float) -> Spot:
    return a[0] + (b[0] - a[0]) * share, a[1] + (b[1] - a[1]) * share
