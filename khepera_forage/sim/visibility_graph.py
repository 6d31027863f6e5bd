"""Visibility graphs: the shortest paths around the corners of a region (shapely, scipy)."""

from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from shapely import Polygon

_ROUNDING = 0.01
"""mm by which a path may leave a region, along whose edges it runs."""


def inward_corners(region: Any) -> Any:
    """The corners that point into a region, with the corners before and after each.

    Args:
        region: A shapely polygon, or several.

    Returns:
        Shape (3, corners, 2): the corners before, the corners themselves, and the corners after.
    """
    return np.concatenate([_of_polygon(part) for part in getattr(region, "geoms", [region])], axis=1)


def shortest_lengths(waypoints: Any, region: Any) -> Any:
    """Lengths of the shortest paths between waypoints within a region.

    Args:
        waypoints: As of `inward_corners`.
        region: A shapely polygon, or several: where the paths run.

    Returns:
        Shape (waypoints, waypoints); infinite without a path.
    """
    import shapely
    from scipy.sparse.csgraph import shortest_path

    before, here, after = waypoints
    count = len(here)
    first, second = np.triu_indices(count, 1)
    # A shortest path touches each corner that it goes round: only such pairs can be part of one.
    touched = _is_touched(here[first], here[second], before[first], after[first]) & _is_touched(
        here[second], here[first], before[second], after[second]
    )
    first, second = first[touched], second[touched]
    lines = shapely.linestrings(np.stack([here[first], here[second]], axis=1))
    allowed = region.buffer(_ROUNDING, join_style="mitre")
    shapely.prepare(allowed)
    seen = shapely.covers(allowed, lines)
    graph = np.full((count, count), np.inf)
    graph[first[seen], second[seen]] = shapely.length(lines[seen])
    return shortest_path(graph, directed=False)


def _of_polygon(part: "Polygon") -> Any:
    from shapely.geometry.polygon import orient

    found = [np.zeros((3, 0, 2))]
    turned = orient(part)
    for ring in (turned.exterior, *turned.interiors):
        here = np.asarray(ring.coords)[:-1]
        before, after = np.roll(here, 1, axis=0), np.roll(here, -1, axis=0)
        found.append(np.stack([before, here, after])[:, _cross(here - before, after - here) < 0])
    return np.concatenate(found, axis=1)


def _is_touched(place: Any, to: Any, before: Any, after: Any) -> Any:
    """Whether lines from corners touch them: the sides that meet there are on the same side of the line."""
    way = to - place
    return _cross(way, before - place) * _cross(way, after - place) >= -_ROUNDING


def _cross(a: Any, b: Any) -> Any:
    return a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]
