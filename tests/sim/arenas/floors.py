"""The floor that a robot can use, for tests of arenas: polygons eroded by the clearance of body and gripper."""

from typing import Any

import shapely

from khepera_forage.sim.arena import Arena


def usable_floor(arena: Arena, clearance: float = 85.0) -> Any:
    """Where the centre of a robot can be: a polygon, or several."""
    obstacles = shapely.union_all([shapely.Polygon(corners) for corners in arena.obstacles])
    return shapely.Polygon(arena.walls).difference(obstacles).buffer(-clearance)
