"""Walls of an enclosure: one outer polygon, with obstacles on the floor inside. Millimetres."""

from functools import lru_cache

from khepera_forage.geometry import polygon
from khepera_forage.geometry.polygon import Corner

_ROUNDING = 1e-3
"""Square mm by which polygons that touch may seem to overlap, in a copy of an enclosure at an offset."""


@lru_cache(maxsize=256)
def check(name: str, walls: tuple[Corner, ...], obstacles: tuple[tuple[Corner, ...], ...]) -> None:
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
        polygon.check(name, corners)
    if not obstacles:
        return
    import shapely  # takes 0.1 s, which importing this package should not

    outer, shapes = shapely.Polygon(walls), shapely.polygons([shapely.linearrings(o) for o in obstacles])
    outside = shapely.area(shapely.difference(shapes, outer))
    for obstacle, shape, area in zip(obstacles, shapes, outside, strict=True):
        if area > _ROUNDING:
            part = "stands outside" if area > shape.area - _ROUNDING else "reaches through"
            raise ValueError(
                f"{name}: obstacle {_text(obstacle)} {part} the walls; "
                f"allowed: on the floor, within {polygon.bounds(walls)}"
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
