"""Lengths of shortest paths through an arena, in mm."""

import math
from collections.abc import Sequence
from contextlib import suppress
from itertools import pairwise

from khepera_forage.sim.arena import Arena, Point
from khepera_forage.sim.ways import CLEARANCE, shortest_path


def path_length(path: Sequence[Point]) -> float:
    """Length of a path from waypoint to waypoint."""
    return sum(math.dist(*leg) for leg in pairwise(path))


def longest_path(arena: Arena) -> float:
    """Length of the shortest path from the home to the furthest place that a robot can reach and where it can turn."""
    import shapely  # takes 0.1 s, which importing this package should not

    obstacles = shapely.union_all([shapely.Polygon(corners) for corners in arena.obstacles])
    # No place is further than the corners of this region.
    region = shapely.Polygon(arena.walls).difference(obstacles).buffer(-(CLEARANCE + 5.0), quad_segs=2)
    lengths = [0.0]
    for x, y in shapely.get_coordinates(region).tolist():
        with suppress(ValueError):  # a part of the floor without a way to the home
            lengths.append(path_length(shortest_path(arena, Point(x, y), arena.home)))
    return max(lengths)
