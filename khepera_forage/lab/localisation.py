"""Positions in millimetres of the regions that the camera reports."""

import math

from khepera_forage.sim.arena import Arena, Point, Pose
from khepera_forage.vision.scene import MM_PER_PIXEL, Region, Scene

_MARGIN = 20.0
"""mm by which a region may appear outside its arena. Assumption."""


def position_of(region: Region) -> Point:
    """A region's centre in mm."""
    return Point(region.x * MM_PER_PIXEL, region.y * MM_PER_PIXEL)


def pose_of(region: Region) -> Pose:
    """A marker's pose in mm and radians, -pi..pi."""
    degrees = (region.orientation + 180) % 360 - 180
    return Pose(*position_of(region), math.radians(degrees))


def is_in(arena: Arena, region: Region) -> bool:
    """Whether a region lies in an arena."""
    x, y = position_of(region)
    x1, y1, x2, y2 = arena.bounds
    return x1 - _MARGIN <= x <= x2 + _MARGIN and y1 - _MARGIN <= y <= y2 + _MARGIN


def find_marker(scene: Scene, arena: Arena, holes: int) -> Region | None:
    """The first region in an arena with a number of holes; None if there is none."""
    return next((r for r in scene.regions if r.holes == holes and is_in(arena, r)), None)
