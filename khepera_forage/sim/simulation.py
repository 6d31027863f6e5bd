"""`Simulation`: what the simulated worlds share. They differ in who moves robots that touch something."""

import math
from abc import ABC, abstractmethod
from collections.abc import Sequence
from typing import Any

import numpy as np

from khepera_forage.counter_rng import random_bits
from khepera_forage.noise import Noise, checked_noise
from khepera_forage.records import in_python
from khepera_forage.robots.khepera import FINGER_LENGTH, FOOD_RADIUS, RADIUS, Motors, Senses, applicable, check_finite
from khepera_forage.robots.model import KHEPERA, RobotModel
from khepera_forage.robots.parameters import RobotParameters
from khepera_forage.sim.arena import MOST_FOODS, Arena, Point, Pose
from khepera_forage.sim.driving import is_lifted, set_motors
from khepera_forage.sim.layout_checks import arena_of, cable_anchor, check_apart, check_robot, check_seen, check_starts
from khepera_forage.sim.records import Enclosure, constants_of
from khepera_forage.sim.sensing import SimulatedCamera
from khepera_forage.sim.world import FoodPlace, Layout, Timing
from khepera_forage.vision.scene import Truth


class SimulatedKhepera:
    """A `Robot` of a simulation.

    Args:
        records: The `RobotState` records of an enclosure.
        number: Of its record, looked up at each use: a kept element of an array would not belong to the array's copy.
    """

    def __init__(self, records: Sequence[Any], number: int) -> None:
        self._records, self._number = records, number

    @property
    def record(self) -> Any:
        """Its `RobotState` record."""
        return self._records[self._number]

    @property
    def pose(self) -> Pose:
        """Where the robot truly is."""
        record = self.record
        return Pose(float(record.x), float(record.y), float(record.heading))

    @property
    def has_gripper(self) -> bool:
        """Whether it can pick up food."""
        return bool(self.record.has_gripper)

    def sense(self) -> Senses:
        """What the robot senses since the last round."""
        senses = in_python(self.record.senses)
        values = (getattr(senses, name) for name in Senses._fields)
        # The infra-reds are a list, and of compiled worlds an array.
        return Senses._make(
            tuple(map(int, value)) if isinstance(value, list | np.ndarray) else value for value in values
        )

    def drive(self, motors: Motors) -> Motors:
        """Command motors from the next round on; returns the command as applied."""
        check_finite(motors)
        return set_motors(self.record, applicable(motors))

    def stop(self) -> None:
        """Wheels to zero; arm and jaw complete their movements."""
        record = self.record
        record.left = record.right = 0.0

    def close(self) -> None:
        """Stop."""
        self.stop()


class Simulation(ABC):
    """Kheperas, food and an overhead camera above one or more enclosures.

    Attributes:
        backend: What moves robots that touch something, "pymunk" or "compiled".

    Args:
        arenas: The enclosures, in one frame of millimetres. The gap between them must be wider than a marker reaches.
        markers: Number of holes of each robot's marker, 1 or 2; one robot each.
        noise: The laboratory's troubles.
        robot_parameters: Deviations of each robot; none by default.
        timing: How long a round lasts, and how fast arm and jaw move.
        model: The kind of robots.

    Raises:
        ValueError: No arena, no robot, a marker with another number of holes, arenas that the camera does not see, or
            not one `RobotParameters` per robot.
    """

    backend: str

    def __init__(
        self,
        arenas: Sequence[Arena],
        markers: Sequence[int],
        noise: Noise | str | None = None,
        robot_parameters: Sequence[RobotParameters] | None = None,
        *,
        timing: Timing,
        model: RobotModel = KHEPERA,
    ) -> None:
        if not arenas:
            raise ValueError("a world with no arena; allowed: at least 1")
        check_seen(arenas)
        if not markers or any(holes not in (1, 2) for holes in markers):
            raise ValueError(f"markers {tuple(markers)!r}; allowed: one or more of 1 and 2 holes")
        if robot_parameters is not None and len(robot_parameters) != len(markers):
            raise ValueError(f"{len(robot_parameters)} robot_parameters given; allowed: {len(markers)}, one per robot")
        self.robot_parameters = tuple(robot_parameters or [RobotParameters()] * len(markers))
        self.arenas, self.markers = tuple(arenas), tuple(markers)
        self.noise = checked_noise(noise)
        self.round_duration = timing.round_duration
        self.robots: tuple[SimulatedKhepera, ...] = ()
        self.camera = SimulatedCamera()
        self.constants = constants_of(self.noise, timing, model)
        self._anchor = cable_anchor(arenas)
        self._enclosures: tuple[Enclosure, ...] = ()

    def reset(self, rng: np.random.Generator, layout: Layout) -> None:
        """Put everything in its place.

        Args:
            rng: Spawned into the generator of this world's random numbers.
            layout: One start a robot, and at most 16 food objects in an arena.

        Raises:
            ValueError: Another number of starts or food objects, or something that does not stand on the free floor.
        """
        self.begin(int(rng.spawn(1)[0].integers(2**64, dtype=np.uint64)), 0, layout)

    @property
    def rounds(self) -> int:
        """Rounds since the random numbers began."""
        return int(self.robots[0].record.round) if self.robots else 0

    def begin(self, key: int, rounds: int, layout: Layout) -> None:
        """Put everything in its place, with given random numbers.

        Args:
            key: Of the random numbers.
            rounds: After how many rounds of that key it begins.
            layout: As for `reset`.

        Raises:
            ValueError: As `reset`.
        """
        check_starts(layout, len(self.markers))
        robot_arenas = [self._number_of("robot", start, RADIUS) for start in layout.starts]
        for number, start in zip(robot_arenas, layout.starts, strict=True):
            check_robot(self.arenas[number], start)
        food_arenas = [self._number_of("food", food, FOOD_RADIUS) for food in layout.foods]
        check_apart(layout)
        enclosures = []
        for number, arena in enumerate(self.arenas):
            foods = food_arenas.count(number)
            if foods > MOST_FOODS:
                raise ValueError(f"{foods} food objects; allowed: at most {MOST_FOODS} in an arena")
            enclosures.append(self._empty(arena, robot_arenas.count(number), foods))
        for i, (number, k) in enumerate(_numbered(robot_arenas)):
            robot, deviations = enclosures[number].robots[k], self.robot_parameters[i]
            robot.key, robot.round = random_bits(key, i) if i else key, rounds
            robot.holes = self.markers[i]
            robot.left_wheel_error = deviations.left_wheel_error
            robot.infra_red_error = deviations.infra_red_gain - 1.0
            robot.arm_reading_error = deviations.arm_reading_scale - 1.0
            robot.finger_shortage = FINGER_LENGTH - deviations.finger_length
            robot.x, robot.y, robot.heading = map(float, layout.starts[i])
        for place, (number, k) in zip(layout.foods, _numbered(food_arenas), strict=True):
            food = enclosures[number].foods[k]
            food.x, food.y = map(float, place)
        self._show(enclosures, robot_arenas, food_arenas)
        for enclosure in enclosures:
            self._begin(enclosure)
        self.advance()  # Nothing moves: this takes the first frame.

    def _number_of(self, what: str, place: Point | Pose, radius: float) -> int:
        """Number of the arena on whose free floor something stands."""
        return self.arenas.index(arena_of(self.arenas, what, place, radius))

    def _show(self, enclosures: Sequence[Enclosure], robot_arenas: Sequence[int], food_arenas: Sequence[int]) -> None:
        """Show these records, which others may change; with the number of each robot's and food's arena."""
        self._enclosures, self._robot_arenas = tuple(enclosures), tuple(robot_arenas)
        self._food_numbers = _numbered(food_arenas)
        self.robots = tuple(SimulatedKhepera(enclosures[number].robots, k) for number, k in _numbered(robot_arenas))
        self.camera = SimulatedCamera([robot.record for robot in self.robots], self._enclosures)

    def advance(self) -> None:
        """One round.

        Raises:
            RuntimeError: The world was never reset.
        """
        if not self.robots:
            raise RuntimeError("advance() before reset()")
        for number, enclosure in enumerate(self._enclosures):
            if len(enclosure.robots):
                self._advance(number, enclosure)

    @abstractmethod
    def _empty(self, arena: Arena, robots: int, foods: int) -> Enclosure:
        """Records for this many robots and food objects."""

    @abstractmethod
    def _begin(self, enclosure: Enclosure) -> None:
        """Put robots down where their records say, and forget all tracks."""

    @abstractmethod
    def _sense(self, enclosure: Enclosure) -> None:
        """Let the robots sense again, between two rounds."""

    @abstractmethod
    def _advance(self, number: int, enclosure: Enclosure) -> None:
        """One round in one arena."""

    def poses(self) -> tuple[Pose, ...]:
        """Where the robots truly are."""
        return tuple(robot.pose for robot in self.robots)

    def food_places(self) -> tuple[FoodPlace, ...]:
        """Where the food truly is."""
        places = []
        for number, k in self._food_numbers:
            enclosure = self._enclosures[number]
            food = enclosure.foods[k]
            places.append(FoodPlace(float(food.x), float(food.y), is_lifted(enclosure.robots, k)))
        return tuple(places)

    def place(self, robot: int, pose: Pose) -> None:
        """Put a robot down elsewhere in its arena, at rest, with the food that it holds.

        Raises:
            ValueError: The place is not on the free floor, or taken.
        """
        record, home = self.robots[robot].record, self._robot_arenas[robot]
        check_robot(self.arenas[home], pose)
        others = tuple(other for i, other in enumerate(self.poses()) if i != robot)
        places = tuple(
            Point(place.x, place.y)
            for number, place in zip(self._food_numbers, self.food_places(), strict=True)
            if not place.lifted and number != (home, record.held)
        )
        check_apart(Layout((*others, pose), places))
        record.x, record.y, record.heading = pose
        record.cos, record.sin = cos, sin = math.cos(pose.heading), math.sin(pose.heading)
        record.forward = record.turn = 0.0
        if record.held >= 0:
            carried, ahead, aside = (self._enclosures[home].foods[record.held], record.grip_x, record.grip_y)
            carried.x, carried.y = pose.x + ahead * cos - aside * sin, pose.y + ahead * sin + aside * cos
        self._sense(self._enclosures[home])

    def truth(self) -> Truth:
        """What a camera above this world sees, before any trouble of seeing."""
        markers = [(*pose, holes) for pose, holes in zip(self.poses(), self.markers, strict=True)]
        return Truth(tuple(markers), tuple((place.x, place.y) for place in self.food_places()))

    def __getstate__(self) -> dict[str, Any]:
        return self.__dict__ | {"robots": (), "camera": SimulatedCamera()}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        if self._enclosures:  # robots and camera of a copy show its own records
            self._show(self._enclosures, self._robot_arenas, [number for number, _ in self._food_numbers])

    def stop(self) -> None:
        """Stop the wheels of all robots."""
        for robot in self.robots:
            robot.stop()

    def close(self) -> None:
        """Stop the robots."""
        for robot in self.robots:
            robot.close()


def _numbered(arena_numbers: Sequence[int]) -> list[tuple[int, int]]:
    """For each robot or food object the number of its arena, and its own number in that arena."""
    return [(arena, arena_numbers[:i].count(arena)) for i, arena in enumerate(arena_numbers)]
