"""The floor that a robot can use, for tests of arenas: polygons eroded by the clearance of body and gripper."""

import math
from itertools import pairwise
from typing import Any

import shapely

from khepera_forage.sim.arena import Arena, Point
from khepera_forage.sim.ways import shortest_path


def usable_floor(arena: Arena, clearance: float = 85.0) -> Any:
    """Where the centre of a robot can be: a polygon, or several."""
    obstacles = shapely.union_all([shapely.Polygon(corners) for corners in arena.obstacles])
    return shapely.Polygon(arena.walls).difference(obstacles).buffer(-clearance, quad_segs=2)


def longest_path(arena: Arena) -> float:
    """Length of the path from home to the furthest place, which is at a corner of the floor."""
    corners = [Point(x, y) for x, y in shapely.get_coordinates(usable_floor(arena))]
    paths = [shortest_path(arena, corner, arena.home) for corner in corners]
    return max(sum(math.dist(*leg) for leg in pairwise(path)) for path in paths)
