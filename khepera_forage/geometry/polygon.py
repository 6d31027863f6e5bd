"""Plane geometry of walls: simple polygons as tuples of (x, y) corners, and enclosures of several polygons."""

import math
from functools import lru_cache

Corner = tuple[float, float]
Segment = tuple[float, float, float, float]


def check(name: str, corners: tuple[Corner, ...]) -> None:
    """Complain unless the corners make a simple polygon.

    Raises:
        ValueError: Fewer than three corners, corners that are not finite or the same twice in a row, no area, or sides
            that cross or touch.
    """
    if len(corners) < 3:
        raise ValueError(f"{name}: walls are {[tuple(c) for c in corners]}; allowed: at least 3 corners")
    for corner in corners:
        if not all(math.isfinite(c) for c in corner):
            raise ValueError(f"{name}: wall corner {tuple(corner)}; allowed: finite coordinates in mm")
    for x1, y1, x2, y2 in edges(corners):
        if (x1, y1) == (x2, y2):
            raise ValueError(f"{name}: wall corner ({x1:g}, {y1:g}) follows itself; allowed: each corner once")
    import shapely  # takes 0.1 s, which importing this package should not

    shape = shapely.Polygon(corners)
    if shape.convex_hull.area == 0:
        raise ValueError(f"{name}: walls {[tuple(c) for c in corners]} enclose no area")
    if not shape.is_valid:
        where = shapely.is_valid_reason(shape).partition("[")[2].rstrip("]").replace(" ", ", ")
        raise ValueError(f"{name}: walls cross or touch at ({where}); allowed: a simple polygon")


@lru_cache(maxsize=256)
def edges(corners: tuple[Corner, ...]) -> tuple[Segment, ...]:
    """The sides, each as (x1, y1, x2, y2)."""
    return tuple((*a, *b) for a, b in zip(corners, (*corners[1:], corners[0]), strict=True))


def area(corners: tuple[Corner, ...]) -> float:
    """Twice the signed area, positive when the corners run counter-clockwise."""
    return sum(x1 * y2 - x2 * y1 for x1, y1, x2, y2 in edges(corners))


def bounds(corners: tuple[Corner, ...]) -> tuple[float, float, float, float]:
    """Smallest x and y, largest x and y."""
    xs, ys = [c[0] for c in corners], [c[1] for c in corners]
    return min(xs), min(ys), max(xs), max(ys)


@lru_cache(maxsize=256)
def inward_corners(polygons: tuple[tuple[Corner, ...], ...]) -> tuple[tuple[float, float, int, int], ...]:
    """The corners that point into the floor of an enclosure.

    Args:
        polygons: Corners of the outer wall, then those of each obstacle.

    Returns:
        x and y of each, and the numbers of the sides that end and begin there, counted over all polygons.
    """
    found: list[tuple[float, float, int, int]] = []
    first = 0
    for k, corners in enumerate(polygons):
        sides = edges(corners)
        count = len(sides)
        turning = 1.0 if (area(corners) > 0) == (k == 0) else -1.0
        for i, (ax, ay, bx, by) in enumerate(sides):
            _, _, cx, cy = sides[(i + 1) % count]
            if turning * ((bx - ax) * (cy - by) - (by - ay) * (cx - bx)) < 0:
                found.append((bx, by, first + i, first + (i + 1) % count))
        first += count
    return tuple(found)


def line_of(segment: Segment) -> tuple[float, float, float]:
    """The line through a segment as a unit normal (x, y) and an offset: normal . point = offset on it."""
    x1, y1, x2, y2 = segment
    length = math.hypot(x2 - x1, y2 - y1)
    normal_x, normal_y = (y1 - y2) / length, (x2 - x1) / length
    return normal_x, normal_y, normal_x * x1 + normal_y * y1


_ROUNDING = 1e-3
"""Square mm by which polygons that touch may seem to overlap, in a copy of an enclosure at an offset."""


@lru_cache(maxsize=256)
def check_enclosure(name: str, walls: tuple[Corner, ...], obstacles: tuple[tuple[Corner, ...], ...]) -> None:
    """Complain unless the walls enclose a floor on which the obstacles stand, beside one another.

    Obstacles may touch the outer wall and one another.

    Args:
        name: Of the enclosure, for messages.
        walls: Corners of the outer wall.
        obstacles: Corners of each.

    Raises:
        ValueError: One of them is not a simple polygon, an obstacle is not on the floor, or two overlap.
    """
    for corners in (walls, *obstacles):
        check(name, corners)
    if not obstacles:
        return
    import shapely  # takes 0.1 s, which importing this package should not

    outer, shapes = shapely.Polygon(walls), shapely.polygons([shapely.linearrings(o) for o in obstacles])
    outside = shapely.area(shapely.difference(shapes, outer))
    for obstacle, shape, area in zip(obstacles, shapes, outside, strict=True):
        if area > _ROUNDING:
            part = "stands outside" if area > shape.area - _ROUNDING else "reaches through"
            raise ValueError(
                f"{name}: obstacle {_text(obstacle)} {part} the walls; allowed: on the floor, within {bounds(walls)}"
            )
    first, second = shapely.STRtree(shapes).query(shapes, "intersects")
    first, second = first[first < second], second[first < second]
    shared = shapely.area(shapely.intersection(shapes[first], shapes[second]))
    for i, j, area in zip(first, second, shared, strict=True):
        if area > _ROUNDING:
            raise ValueError(
                f"{name}: obstacles {_text(obstacles[i])} and {_text(obstacles[j])} overlap; "
                "allowed: beside one another"
            )


def _text(corners: tuple[Corner, ...]) -> str:
    return str([tuple(corner) for corner in corners])
