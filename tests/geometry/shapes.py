"""Random polygons and places."""

import math
from typing import NamedTuple

from hypothesis import settings
from hypothesis import strategies as st

from khepera_forage.geometry.polygon import Corner

PROPERTY = settings(max_examples=150)

Place = tuple[float, float]

radii_lists = st.lists(st.floats(20, 500), min_size=3, max_size=9)
places = st.tuples(st.floats(-600, 600), st.floats(-600, 600))


def star(radii: list[float], centre: Place = (0.0, 0.0)) -> tuple[Corner, ...]:
    """A simple polygon around a centre, mostly not convex: one corner a radius."""
    x, y = centre
    n = len(radii)
    return tuple(
        (x + r * math.cos(2 * math.pi * i / n), y + r * math.sin(2 * math.pi * i / n)) for i, r in enumerate(radii)
    )


class Enclosure(NamedTuple):
    """An outer wall and obstacles, which may overlap each other and reach through the outer wall."""

    walls: tuple[Corner, ...]
    obstacles: tuple[tuple[Corner, ...], ...]

    @property
    def polygons(self) -> tuple[tuple[Corner, ...], ...]:
        return (self.walls, *self.obstacles)


_obstacles = st.builds(star, st.lists(st.floats(10, 200), min_size=3, max_size=6), places)
enclosures = st.builds(Enclosure, st.builds(star, radii_lists), st.lists(_obstacles, max_size=3).map(tuple))
