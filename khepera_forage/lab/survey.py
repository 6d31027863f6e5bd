"""What the camera knows of a laboratory: where each robot is, and whether everything stands where it should."""

import math
from collections.abc import Sequence

from khepera_forage.lab.operator import RobotMark, holes
from khepera_forage.lab.settings import Tolerance
from khepera_forage.robots.khepera import ARM_RAISED, FOOD_RADIUS, JAW_OPEN, Senses
from khepera_forage.sim.arena import Arena, Point, Pose
from khepera_forage.vision.scene import MM_PER_PIXEL, Region, Scene
from khepera_forage.vision.shapes import Plate, under_plate

_PLAY = 10
"""Positions by which arm and jaw may read otherwise than commanded. Assumption."""
_OUTSIDE = 20.0
"""mm by which a region may seem to lie outside its arena and still belong to it."""


def within(arena: Arena, region: Region) -> bool:
    """Whether a region lies in an arena."""
    x, y = place_of(region)
    x1, y1, x2, y2 = arena.bounds
    return x1 - _OUTSIDE <= x <= x2 + _OUTSIDE and y1 - _OUTSIDE <= y <= y2 + _OUTSIDE


def place_of(region: Region) -> Point:
    """A region's centre in mm."""
    return Point(region.x * MM_PER_PIXEL, region.y * MM_PER_PIXEL)


def pose_of(region: Region) -> Pose:
    """A marker's pose in mm and radians, -pi..pi."""
    turned = (region.orientation + 180) % 360 - 180
    return Pose(*place_of(region), math.radians(turned))


def own_marker(scene: Scene, arena: Arena, count: int) -> Region | None:
    """A robot's marker: the first region with as many holes in its own arena; None before it was ever seen."""
    return next((r for r in scene.regions if r.holes == count and within(arena, r)), None)


def survey(
    scene: Scene,
    arenas: Sequence[Arena],
    robots: Sequence[RobotMark],
    foods: Sequence[Point] | None,
    tolerance: Tolerance,
) -> tuple[str, ...]:
    """What does not stand where it should, in words, a line each.

    Food that a marker covers cannot be seen; where some should lie covered, it is taken to lie there.

    Args:
        scene: What the camera reports.
        arenas: Every robot's own.
        robots: Where robots should stand.
        foods: Where all food should lie; None asks about none.
        tolerance: How far off its mark anything may be.
    """
    faults = [
        fault for mark in robots for fault in _robot_faults(scene, arenas[mark.number], mark, tolerance)
    ]
    if foods is not None:
        faults += _food_faults(scene, arenas, foods, tolerance)
    return tuple(faults)


def closed_grippers(robots: Sequence[RobotMark], senses: Sequence[Senses]) -> tuple[str, ...]:
    """Grippers that are not up and open, as every episode begins, in words."""
    return tuple(
        f"robot {mark.name}: arm at {its.arm} and jaw at {its.jaw} instead of {ARM_RAISED} and {JAW_OPEN}"
        for mark, its in zip(robots, senses, strict=True)
        if abs(its.arm - ARM_RAISED) > _PLAY or its.jaw < JAW_OPEN - _PLAY
    )


def _robot_faults(scene: Scene, arena: Arena, mark: RobotMark, tolerance: Tolerance) -> list[str]:
    markers = [r for r in scene.regions if r.holes and r.found and within(arena, r)]
    others = [r for r in markers if r.holes != mark.holes]
    own = [r for r in markers if r.holes == mark.holes]
    faults = [
        f"a marker with {holes(r.holes)} is in the arena of robot {mark.name}, whose own has {mark.holes}"
        for r in others
    ]
    if len(own) != 1:
        seen = (
            f"{len(own)} markers with {holes(mark.holes)} are"
            if own
            else f"no marker with {holes(mark.holes)} is"
        )
        return [*faults, f"robot {mark.name}: {seen} seen in its arena"]
    x, y, heading = pose_of(own[0])
    off = math.dist((x, y), mark.pose[:2])
    if off > tolerance.position:
        faults.append(f"robot {mark.name} stands at ({x:.0f}, {y:.0f}) mm, {off:.0f} mm off its mark")
    turned = (math.degrees(heading - mark.pose.heading) + 180) % 360 - 180
    if abs(turned) > tolerance.heading:
        way = "left" if turned > 0 else "right"
        faults.append(f"robot {mark.name} is turned {abs(turned):.0f} degrees too far to the {way}")
    return faults


def _food_faults(
    scene: Scene, arenas: Sequence[Arena], foods: Sequence[Point], tolerance: Tolerance
) -> list[str]:
    seen = [
        place_of(r)
        for r in scene.regions
        if r.found and not r.holes and any(within(arena, r) for arena in arenas)
    ]
    plates = [
        Plate(x, y, math.cos(heading), math.sin(heading))
        for x, y, heading in (pose_of(r) for r in scene.regions if r.holes)
    ]
    faults = []
    for food in foods:
        nearest = min(seen, key=lambda place: math.dist(place, food), default=None)
        if nearest is not None and math.dist(nearest, food) <= tolerance.position:
            seen.remove(nearest)
        elif not under_plate(*food, FOOD_RADIUS, plates):
            faults.append(f"no food is seen at ({food.x:.0f}, {food.y:.0f}) mm")
    return faults + [f"food at ({x:.0f}, {y:.0f}) mm belongs elsewhere, or away" for x, y in seen]
