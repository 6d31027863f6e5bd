"""Checking by camera that the operator has placed robots and food correctly."""

import math
from collections.abc import Sequence

from khepera_forage.lab.localisation import is_in, pose_of, position_of
from khepera_forage.lab.operator import RobotMark, holes_text
from khepera_forage.lab.settings import Tolerance
from khepera_forage.robots.khepera import ARM_RAISED, FOOD_RADIUS, JAW_OPEN, Senses
from khepera_forage.sim.arena import Arena, Point
from khepera_forage.vision.scene import Scene
from khepera_forage.vision.shapes import Plate, under_plate

_GRIPPER_TOLERANCE = 10
"""Positions by which the readings of arm and jaw may deviate from their targets. Assumption."""


def placement_errors(
    scene: Scene,
    arenas: Sequence[Arena],
    robots: Sequence[RobotMark],
    foods: Sequence[Point] | None,
    tolerance: Tolerance,
) -> tuple[str, ...]:
    """Robots and food that are not in their places, one sentence each.

    Food under a marker is invisible; if food should lie there, it counts as correctly placed.

    Args:
        scene: Regions reported by the camera.
        arenas: The arena of every robot.
        robots: Requested poses of robots.
        foods: Requested positions of all food; None skips the check of food.
        tolerance: Allowed deviations.
    """
    errors = [
        error for mark in robots for error in _robot_errors(scene, arenas[mark.number], mark, tolerance)
    ]
    if foods is not None:
        errors += _food_errors(scene, arenas, foods, tolerance)
    return tuple(errors)


def gripper_errors(
    robots: Sequence[RobotMark], senses: Sequence[Senses], has_gripper: Sequence[bool]
) -> tuple[str, ...]:
    """Grippers that are not raised and open, as at the start of every episode, one sentence each."""
    return tuple(
        f"robot {mark.name}: arm at {own.arm} and jaw at {own.jaw} instead of {ARM_RAISED} and {JAW_OPEN}"
        for mark, own, gripper in zip(robots, senses, has_gripper, strict=True)
        if gripper
        and (abs(own.arm - ARM_RAISED) > _GRIPPER_TOLERANCE or own.jaw < JAW_OPEN - _GRIPPER_TOLERANCE)
    )


def _robot_errors(scene: Scene, arena: Arena, mark: RobotMark, tolerance: Tolerance) -> list[str]:
    markers = [r for r in scene.regions if r.holes and r.found and is_in(arena, r)]
    others = [r for r in markers if r.holes != mark.holes]
    own = [r for r in markers if r.holes == mark.holes]
    errors = [
        f"a marker with {holes_text(r.holes)} is in the arena of robot {mark.name}, whose marker has {mark.holes}"
        for r in others
    ]
    if len(own) != 1:
        seen = (
            f"{len(own)} markers with {holes_text(mark.holes)} are"
            if own
            else f"no marker with {holes_text(mark.holes)} is"
        )
        return [*errors, f"robot {mark.name}: {seen} seen in its arena"]
    x, y, heading = pose_of(own[0])
    distance = math.dist((x, y), mark.pose[:2])
    if distance > tolerance.position:
        errors.append(f"robot {mark.name} stands at ({x:.0f}, {y:.0f}) mm, {distance:.0f} mm off its mark")
    turn = (math.degrees(heading - mark.pose.heading) + 180) % 360 - 180
    if abs(turn) > tolerance.heading:
        side = "left" if turn > 0 else "right"
        errors.append(f"robot {mark.name} is turned {abs(turn):.0f} degrees too far to the {side}")
    return errors


def _food_errors(
    scene: Scene, arenas: Sequence[Arena], foods: Sequence[Point], tolerance: Tolerance
) -> list[str]:
    seen = [
        position_of(r)
        for r in scene.regions
        if r.found and not r.holes and any(is_in(arena, r) for arena in arenas)
    ]
    plates = [
        Plate(x, y, math.cos(heading), math.sin(heading))
        for x, y, heading in (pose_of(r) for r in scene.regions if r.holes)
    ]
    errors = []
    for food in foods:
        nearest = min(seen, key=lambda position: math.dist(position, food), default=None)
        if nearest is not None and math.dist(nearest, food) <= tolerance.position:
            seen.remove(nearest)
        elif not under_plate(*food, FOOD_RADIUS, plates):
            errors.append(f"no food is seen at ({food.x:.0f}, {food.y:.0f}) mm")
    return errors + [f"food at ({x:.0f}, {y:.0f}) mm is misplaced, or must be removed" for x, y in seen]
