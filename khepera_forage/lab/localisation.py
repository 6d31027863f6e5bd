"""Where robots and food are, in mm, as the camera or a gripper reports them; and whether they are in their places."""

import math
from collections.abc import Sequence

from khepera_forage.lab.operator import RobotMark
from khepera_forage.lab.settings_file import Tolerance
from khepera_forage.robots.khepera import (
    ARM_ON_FLOOR,
    ARM_RAISED,
    FINGER_LENGTH,
    FOOD_RADIUS,
    JAW_OPEN,
    JAW_ROOT,
    RADIUS,
    Robot,
)
from khepera_forage.robots.real_robot import RealRobot
from khepera_forage.sim.arena import Arena, Point, Pose
from khepera_forage.sim.world import FoodPlace
from khepera_forage.vision.scene import MM_PER_PIXEL, Region, Scene
from khepera_forage.vision.shapes import Plate, under_plate

_MARGIN = 20.0
"""mm by which a region may appear outside its arena. Assumption."""


def _position_of(region: Region) -> Point:
    return Point(region.x * MM_PER_PIXEL, region.y * MM_PER_PIXEL)


def pose_of(region: Region) -> Pose:
    """A marker's pose in mm and radians, -pi..pi."""
    degrees = (region.orientation + 180) % 360 - 180
    return Pose(*_position_of(region), math.radians(degrees))


def _is_in(arena: Arena, region: Region) -> bool:
    x, y = _position_of(region)
    x1, y1, x2, y2 = arena.bounds
    return x1 - _MARGIN <= x <= x2 + _MARGIN and y1 - _MARGIN <= y <= y2 + _MARGIN


def find_marker(scene: Scene, arena: Arena, holes: int) -> Region | None:
    """The first region in an arena with a number of holes; None if there is none."""
    return next((r for r in scene.regions if r.holes == holes and _is_in(arena, r)), None)


def food_regions(scene: Scene, arenas: Sequence[Arena]) -> list[Region]:
    """The regions without holes in any arena."""
    return [r for r in scene.regions if not r.holes and any(_is_in(arena, r) for arena in arenas)]


_GRIP_CENTRE = JAW_ROOT + FINGER_LENGTH / 2
"""mm from the robot's centre forward to the middle of the fingers."""

_CONTACT = RADIUS + FOOD_RADIUS
"""mm from the centre of a robot without a gripper to that of food that it pushes."""


def _ahead(pose: Pose, distance: float) -> Point:
    return Point(pose.x + distance * math.cos(pose.heading), pose.y + distance * math.sin(pose.heading))


class FoodLocator:
    """The food objects of a laboratory, in the order of its layout.

    A region without holes, in one of the arenas, stays assigned to one object; a new region is assigned to the nearest
    object without a region. While a robot's optical barrier is interrupted, it holds the object that was nearest to its
    gripper. A robot without a gripper pushes food that its marker hides: while it touches it, the food moves along.

    Attributes:
        places: Of each object.
        held: The object in each robot's gripper, by number.
    """

    def __init__(self, places: Sequence[Point], arenas: Sequence[Arena]) -> None:
        self.places = [FoodPlace(x, y, False) for x, y in places]
        self._arenas = arenas
        self._object_of_region: dict[int, int] = {}
        self.held: dict[int, int] = {}

    def ahead_of(self, pose: Pose, reach: float) -> int | None:
        """Number of the object that lies before a robot without a gripper, at most `reach` mm from its centre."""
        cosine, sine = math.cos(pose.heading), math.sin(pose.heading)
        for k, food in enumerate(self.places):
            dx, dy = food.x - pose.x, food.y - pose.y
            if 0 < dx * cosine + dy * sine <= reach and abs(dy * cosine - dx * sine) <= FOOD_RADIUS:
                return k
        return None

    def update(self, scene: Scene, robots: Sequence[tuple[Pose, RealRobot]]) -> None:
        """Update the positions after a round, from the camera's regions and from the robots and their places."""
        for number, (pose, robot) in enumerate(robots):
            if robot.model.has_gripper:
                self._update_held(number, pose, robot)
        food = food_regions(scene, self._arenas)
        labels = {region.label for region in food}
        self._object_of_region = {label: k for label, k in self._object_of_region.items() if label in labels}
        seen = set()
        for region in food:
            if not region.found:
                continue
            place = _position_of(region)
            if region.label not in self._object_of_region:
                nearest = self._nearest_free(place, set(self._object_of_region.values()))
                if nearest is None:
                    continue
                self._object_of_region[region.label] = nearest
            k = self._object_of_region[region.label]
            seen.add(k)
            if k not in self.held.values():
                self.places[k] = FoodPlace(*place, False)
        for pose, robot in robots:
            k_ahead = self.ahead_of(pose, robot.model.reach)
            if not robot.model.has_gripper and robot.touches and k_ahead is not None and k_ahead not in seen:
                self.places[k_ahead] = FoodPlace(*_ahead(pose, _CONTACT), False)

    def _update_held(self, number: int, pose: Pose, robot: RealRobot) -> None:
        """Move held food with its robot; released food stays at its last position."""
        senses = robot.sense()
        if not senses.object_presence or not self.places:
            released = self.held.pop(number, None)
            if released is not None:
                self.places[released] = self.places[released]._replace(lifted=False)
            return
        place = _ahead(pose, _GRIP_CENTRE)
        if number not in self.held:
            nearest = self._nearest_free(place, set(self.held.values()))
            if nearest is None:
                return
            self.held[number] = nearest
        self.places[self.held[number]] = FoodPlace(*place, senses.arm < ARM_ON_FLOOR)

    def _nearest_free(self, place: Point, taken: set[int]) -> int | None:
        free = [k for k in range(len(self.places)) if k not in taken]
        return min(free, key=lambda k: math.dist(place, self.places[k][:2]), default=None)


_GRIPPER_TOLERANCE = 10
"""Positions by which the readings of arm and jaw may deviate from their targets. Assumption."""


def placement_errors(
    scene: Scene,
    arenas: Sequence[Arena],
    robots: Sequence[RobotMark],
    foods: Sequence[Point] | None,
    tolerance: Tolerance,
) -> tuple[str, ...]:
    """Robots and food (None: not checked) that are not in their places, one sentence each.

    Food under a marker is invisible; if food should lie there, it counts as correctly placed.
    """
    errors = []
    for mark in robots:
        markers = [r for r in scene.regions if r.holes and r.found and _is_in(arenas[mark.number], r)]
        errors += [
            f"marker {r.holes} is in the arena of robot {mark.name}, whose marker is {mark.holes}"
            for r in markers
            if r.holes != mark.holes
        ]
        own = [r for r in markers if r.holes == mark.holes]
        if len(own) != 1:
            seen = f"seen {len(own)} times" if own else "not seen"
            errors.append(f"robot {mark.name}: marker {mark.holes} is {seen} in its arena")
            continue
        x, y, heading = pose_of(own[0])
        distance = math.dist((x, y), mark.pose[:2])
        if distance > tolerance.position:
            errors.append(f"robot {mark.name} stands at ({x:.0f}, {y:.0f}) mm, {distance:.0f} mm off its mark")
        turn = (math.degrees(heading - mark.pose.heading) + 180) % 360 - 180
        if abs(turn) > tolerance.heading:
            side = "left" if turn > 0 else "right"
            errors.append(f"robot {mark.name} is turned {abs(turn):.0f} degrees too far to the {side}")
    if foods is None:
        return tuple(errors)
    spare = [_position_of(r) for r in food_regions(scene, arenas) if r.found]
    plates = [
        Plate(x, y, math.cos(heading), math.sin(heading))
        for x, y, heading in (pose_of(r) for r in scene.regions if r.holes)
    ]
    for food in foods:
        nearest = min(spare, key=lambda position: math.dist(position, food), default=None)
        if nearest is not None and math.dist(nearest, food) <= tolerance.position:
            spare.remove(nearest)
        elif not under_plate(*food, FOOD_RADIUS, plates):
            errors.append(f"no food is seen at ({food.x:.0f}, {food.y:.0f}) mm")
    misplaced = [f"food at ({x:.0f}, {y:.0f}) mm is misplaced, or must be removed" for x, y in spare]
    return (*errors, *misplaced)


def gripper_errors(marks: Sequence[RobotMark], robots: Sequence[Robot]) -> tuple[str, ...]:
    """Grippers that are not raised and open, as at the start of every episode, one sentence each."""
    errors = []
    for mark, robot in zip(marks, robots, strict=True):
        own = robot.sense()
        is_raised = abs(own.arm - ARM_RAISED) <= _GRIPPER_TOLERANCE
        if robot.has_gripper and not (is_raised and own.jaw >= JAW_OPEN - _GRIPPER_TOLERANCE):
            where = f"arm at {own.arm} and jaw at {own.jaw} instead of {ARM_RAISED} and {JAW_OPEN}"
            errors.append(f"robot {mark.name}: {where}")
    return tuple(errors)
