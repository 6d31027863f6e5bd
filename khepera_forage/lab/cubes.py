"""Cubes on a mat in a laboratory: an operator that needs nobody, and the mat as a camera."""

import math
import time
from collections.abc import Callable, Sequence

from khepera_forage.lab.operator import OperatorGaveUp, OperatorRequest
from khepera_forage.robots.khepera import RADIUS, SPEED_UNIT
from khepera_forage.robots.mat import COMMAND_DURATION, MatRobot
from khepera_forage.sim.arena import Arena, Point
from khepera_forage.vision.scene import MM_PER_PIXEL, Region, Scene
from khepera_forage.vision.shapes import FOOD_FEATURES

_FAST, _SLOW = 8, 5
"""Speed units of a wheel on the way, and near the place."""
_CLOSE, _EXACT = 60.0, 6.0
"""mm on the plan: distance from which a cube drives slowly, and at which it has arrived."""
_TURN_EXACT = math.radians(4)
_AROUND = 80.0
"""mm on the plan by which a cube keeps away from the others on its way."""
_STEP = 0.05
"""Seconds from one command to the next on the way."""
_LONGEST, _SETTLE = 0.3, 0.25
"""Seconds of a movement near the place, and after it: longer than Bluetooth delays commands and places."""
_MAX_DRIVE = 40.0
"""Seconds after which a cube gives up."""
_MAX_REPEATS = 10
"""Repetitions of a request before the operator gives up: the cubes cannot reach their places."""


class CubeOperator:
    """Drives robots (in the order of the laboratory) and food to the places of a request, one after the other.

    A cube leaves out the others on its way. What it has pushed nevertheless is placed again when the laboratory
    repeats the request. Food for which there is no place leaves the arenas.
    """

    def __init__(
        self,
        robots: Sequence[MatRobot],
        foods: Sequence[MatRobot],
        arenas: Sequence[Arena],
        sleep: Callable[[float], None] = time.sleep,
    ) -> None:
        self._robots, self._foods, self._arenas, self._sleep = robots, foods, arenas, sleep
        self._cubes = [*robots, *foods]
        self._repeats = 0

    def __call__(self, request: OperatorRequest) -> None:
        """Carry out a request."""
        if not request.robots and request.foods is None:
            raise OperatorGaveUp(f"this needs a person: {request.reason}")
        self._repeats = self._repeats + 1 if request.errors else 0
        if self._repeats >= _MAX_REPEATS:
            raise OperatorGaveUp(f"the cubes do not reach their places: {'; '.join(request.errors)}")
        for food in self._foods:
            food.receive()
        if request.foods is not None:
            places = request.foods
            if len(self._foods) < len(places):
                raise OperatorGaveUp(f"{len(self._foods)} food cubes for {len(places)} places; allowed: one each")
            free, nearest = list(self._foods), []
            for place in places:
                nearest.append(min(free, key=lambda cube: math.dist(cube.pose[:2], place)))
                free.remove(nearest[-1])
            for cube in free:
                if not self._is_outside(*cube.pose[:2]):
                    self._drive(cube, self._place_outside(cube))
            for cube, place in zip(nearest, places, strict=True):
                self._drive(cube, place)
        for mark in request.robots:
            self._drive(self._robots[mark.number], Point(*mark.pose[:2]), mark.pose.heading)

    def _is_outside(self, x: float, y: float) -> bool:
        return all(arena.clearance(Point(x, y)) <= -RADIUS for arena in self._arenas)

    def _place_outside(self, cube: MatRobot) -> Point:
        """The nearest place outside all arenas with room for a cube."""
        width, height = (int(size - RADIUS) for size in cube.mat_size)
        others = [other.pose[:2] for other in self._cubes if other is not cube]
        places = [
            Point(x, y)
            for x in range(round(RADIUS), width, 10)
            for y in range(round(RADIUS), height, 10)
            if self._is_outside(x, y) and all(math.dist((x, y), other) >= _AROUND for other in others)
        ]
        if not places:
            raise OperatorGaveUp(f"the mat has no room beside the arenas for {cube.port}: take it away")
        return min(places, key=lambda place: math.dist(place, cube.pose[:2]))

    def _drive(self, cube: MatRobot, place: Point, heading: float | None = None) -> None:
        """Drive a cube to a place, and turn it; stops it in any case."""
        try:
            passed = 0.0
            while passed < _MAX_DRIVE:
                cube.receive()
                distance = math.hypot(place.x - cube.pose.x, place.y - cube.pose.y)
                wanted = self._direction(cube, place) if distance > _EXACT else heading
                if wanted is None:
                    return
                turn = math.remainder(wanted - cube.pose.heading, math.tau)
                if distance <= _EXACT and abs(turn) <= _TURN_EXACT:
                    return
                wait = self._step(cube, distance, turn)
                self._sleep(wait)
                passed += wait
        finally:
            cube.stop()

    def _step(self, cube: MatRobot, distance: float, turn: float) -> float:
        """One short command: turn on the spot, or drive with a small correction.

        Returns:
            Seconds until the next one: on the way before it ends, otherwise when the cube has come to rest.
        """
        far, slow = distance > _CLOSE, _SLOW * SPEED_UNIT
        correction = max(-2.0, min(2.0, 4 * turn))
        if distance <= _EXACT or abs(turn) > math.radians(20 if far else 12):
            side = math.copysign(_SLOW, turn)
            left, right, seconds = -side, side, abs(turn) * cube.model.plan_base / (2 * slow)
        elif far:
            cube.turn_for(_FAST - correction, _FAST + correction, COMMAND_DURATION)
            return _STEP
        else:
            left, right, seconds = _SLOW - correction, _SLOW + correction, distance / slow
        milliseconds = 10 * max(1, round(100 * min(seconds, _LONGEST)))
        cube.turn_for(left, right, milliseconds)
        return milliseconds / 1000 + _SETTLE

    def _direction(self, cube: MatRobot, place: Point) -> float:
        """The heading to a place, around the other cubes, in radians."""
        x, y, _ = cube.pose
        dx, dy = place.x - x, place.y - y
        distance = math.hypot(dx, dy) or 1e-6
        ux, uy = dx / distance, dy / distance
        for other in self._cubes:
            ox, oy = other.pose.x - x, other.pose.y - y
            ahead, aside = ox * ux + oy * uy, oy * ux - ox * uy
            if other is not cube and 0 < ahead < min(distance, 2 * _AROUND) and abs(aside) < _AROUND:
                side = -1.0 if aside >= 0 else 1.0
                away = side * (_AROUND - abs(aside)) / max(ahead, _AROUND / 2)
                return math.atan2(uy + ux * away, ux - uy * away)
        return math.atan2(dy, dx)


class MatCamera:
    """A camera whose regions are cubes: robots, with the holes of the markers that they stand for, and food.

    A cube that was lifted off the mat, or has left it, keeps its last place and counts as lost, like a region that the
    tracker does not find.
    """

    def __init__(self, robots: Sequence[MatRobot], holes: Sequence[int], foods: Sequence[MatRobot]) -> None:
        self._cubes = [*zip(robots, holes, strict=True), *((food, 0) for food in foods)]
        self._foods = foods
        self._scene = Scene(())

    def begin_round(self) -> None:
        """Nothing to do: places are taken in `expose`."""

    def forget(self) -> None:
        """Nothing to do: a cube's place does not follow from earlier ones."""

    def reset(self) -> None:
        """As `expose`."""
        self.expose()

    def expose(self) -> None:
        """Take the place of every cube."""
        for food in self._foods:
            food.receive()
        self._scene = Scene(tuple(_region(label, cube, holes) for label, (cube, holes) in enumerate(self._cubes)))

    def look(self) -> Scene:
        """The places of the last `expose`."""
        return self._scene

    def close(self) -> None:
        """Stop and disconnect the food; a second call does nothing."""
        for food in self._foods:
            food.close()


def _region(label: int, cube: MatRobot, holes: int) -> Region:
    x, y, heading = cube.pose
    degrees = round(math.degrees(heading)) % 360 if holes else 0
    place = x / MM_PER_PIXEL, y / MM_PER_PIXEL
    return Region(label, *place, holes, degrees, cube.on_mat, False, *place, *FOOD_FEATURES)
