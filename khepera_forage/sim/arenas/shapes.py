"""Corners of shapes that arenas are made of. Millimetres."""

from khepera_forage.sim.arena import Point


def box(left: float, bottom: float, right: float, top: float) -> tuple[Point, ...]:
    """The corners of a rectangle with level sides, counter-clockwise."""
    return Point(left, bottom), Point(right, bottom), Point(right, top), Point(left, top)


def corners(*places: tuple[float, float]) -> tuple[Point, ...]:
    """Corners from pairs of numbers."""
    return tuple(Point(x, y) for x, y in places)
