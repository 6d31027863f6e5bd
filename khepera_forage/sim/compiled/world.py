"""`CompiledWorld`: robots, food and a camera on compiled bodies, as a `World`."""

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from khepera_forage.compilation import entry
from khepera_forage.counter_rng import random_bits
from khepera_forage.noise import Noise, checked_noise
from khepera_forage.robots.khepera import (
    ARM_ON_FLOOR,
    FOOD_RADIUS,
    RADIUS,
    Motors,
    Senses,
    applicable,
    check_finite,
)
from khepera_forage.sim.arena import MOST_FOODS, Arena, Point, Pose
from khepera_forage.sim.compiled.camera import forget_tracks
from khepera_forage.sim.compiled.moving import put_down
from khepera_forage.sim.compiled.records import (
    constants_of,
    corner_dtype,
    detection_dtype,
    food_dtype,
    robot_dtype,
    track_dtype,
    wall_dtype,
)
from khepera_forage.sim.compiled.step import advance
from khepera_forage.sim.layout_checks import (
    arena_of,
    cable_anchor,
    check_apart,
    check_robot,
    check_starts,
    check_world,
)
from khepera_forage.sim.world import FoodPlace, Layout, Timing
from khepera_forage.vision.scene import Region, Scene
from khepera_forage.vision.shapes import (
    FOOD_FEATURES,
    FOOD_RADIUS_PX,
    MARKER_FEATURES,
    in_picture,
    marker_outline,
)


class CompiledKhepera:
    """A robot of a `CompiledWorld`.

    Args:
        record: Its `RobotState` record.
    """

    def __init__(self, record: Any) -> None:
        self._record = record

    def sense(self) -> Senses:
        """What the robot senses since the last round."""
        record = self._record
        return Senses(
            tuple(record["proximity"].astype(np.int64).tolist()),
            int(record["left_pulses"]),
            int(record["right_pulses"]),
            int(record["arm_reading"]),
            int(record["jaw_reading"]),
            int(record["object_presence"]),
        )

    def drive(self, motors: Motors) -> Motors:
        """Command motors from the next round on; returns the command as applied."""
        check_finite(motors)
        applied = applicable(motors)
        record = self._record
        record["left"], record["right"] = applied.left, applied.right
        record["arm_target"], record["jaw_target"] = applied.arm, applied.jaw
        return applied

    def stop(self) -> None:
        """Wheels to zero; arm and jaw complete their movements."""
        self._record["left"] = self._record["right"] = 0.0

    def close(self) -> None:
        """Stop."""
        self.stop()


class Enclosure(NamedTuple):
    """What is in one arena of a world.

    Attributes:
        robots: `RobotState` records.
        foods: `FoodState` records.
        tracks: `Track` records of food.
    """

    robots: NDArray[Any]
    foods: NDArray[Any]
    tracks: NDArray[Any]


class CompiledCamera:
    """The camera of a `CompiledWorld`: the markers' regions come first, in the order of the robots; food follows."""

    def __init__(self) -> None:
        self._robots: tuple[Any, ...] = ()
        self._enclosures: tuple[Enclosure, ...] = ()

    def reset(self, robots: tuple[Any, ...], enclosures: tuple[Enclosure, ...]) -> None:
        """Show other records.

        Args:
            robots: `RobotState` records, in the order of the robots.
            enclosures: What is in each arena.
        """
        self._robots, self._enclosures = robots, enclosures

    def look(self) -> Scene:
        """The regions of the last frame; none before the first."""
        regions = [_marker_region(i, robot) for i, robot in enumerate(self._robots)]
        foods = []
        for number, enclosure in enumerate(self._enclosures):
            for label, x, y, _, found, _ in enclosure.tracks.tolist():
                if label >= 0:
                    edge = not in_picture(x, y, FOOD_RADIUS_PX, FOOD_RADIUS_PX)
                    # Each arena numbers its own tracks.
                    label = len(self._robots) + label * len(self._enclosures) + number
                    first = x, y + FOOD_RADIUS_PX
                    foods.append(Region(label, x, y, 0, 0, found, edge, *first, *FOOD_FEATURES))
        return Scene((*regions, *sorted(foods)))


def _marker_region(label: int, robot: Any) -> Region:
    x, y, holes = float(robot["marker_x"]), float(robot["marker_y"]), int(robot["holes"])
    heading, found = int(robot["marker_heading"]), bool(robot["marker_found"])
    turned = math.radians(heading)
    half_width, half_height, first = marker_outline(math.cos(turned), math.sin(turned))
    edge = not in_picture(x, y, half_width, half_height)
    return Region(
        label, x, y, holes, heading, found, edge, x + first, y + half_height, *MARKER_FEATURES[holes]
    )


class CompiledWorld:
    """Kheperas, food and an overhead camera above one or more enclosures, on the compiled bodies.

    Bodies and camera behave like those of `PymunkWorld`, with the same noise; `contact` says how contacts differ.

    Args:
        arenas: The enclosures, in one frame of millimetres. The gap between them must be wider than a marker reaches.
        markers: Number of holes of each robot's marker, 1 or 2; one robot each.
        noise: By default `Noise.laboratory()`.
        timing: Duration of a round, and speeds of arm and jaw.

    Raises:
        ValueError: No arena, no robot, a marker with another number of holes, or arenas that the camera does not see.
    """

    def __init__(
        self,
        arenas: Sequence[Arena],
        markers: Sequence[int],
        noise: Noise | str | None = None,
        *,
        timing: Timing,
    ) -> None:
        check_world(arenas, markers)
        self.arenas, self.markers = tuple(arenas), tuple(markers)
        self.noise = checked_noise(noise)
        self.round_duration = timing.round_duration
        self.robots: tuple[CompiledKhepera, ...] = ()
        self.camera = CompiledCamera()
        self._constants = constants_of(self.noise, timing)
        self._walls = [
            (
                np.array(list(map(tuple, arena.wall_records)), wall_dtype),
                np.array([(x, y) for x, y, _, _ in arena.corners], corner_dtype),
            )
            for arena in self.arenas
        ]

    def reset(self, rng: np.random.Generator, layout: Layout) -> None:
        """Put everything in its place.

        Args:
            rng: Spawned into the generator of this world's random numbers.
            layout: One start a robot, and at most 16 food objects in an arena.

        Raises:
            ValueError: Another number of starts or food objects, or something that does not stand on the free floor.
        """
        check_starts(layout, len(self.markers))
        homes = [arena_of(self.arenas, "robot", start, RADIUS) for start in layout.starts]
        for home, start in zip(homes, layout.starts, strict=True):
            check_robot(home, start)
        plates = [arena_of(self.arenas, "food", food, FOOD_RADIUS) for food in layout.foods]
        check_apart(layout)
        key = rng.spawn(1)[0].integers(2**64, dtype=np.uint64)
        robots = np.zeros(len(homes), robot_dtype)
        robots["key"] = random_bits(np.full(len(homes), key), np.arange(len(homes), dtype=np.uint64))
        robots["key"][0], robots["holes"] = key, self.markers
        robots["x"], robots["y"], robots["heading"] = np.array(layout.starts).T
        enclosures, places = [], np.array(layout.foods).reshape(-1, 2)
        for arena in self.arenas:
            here = [food is arena for food in plates]
            if sum(here) > MOST_FOODS:
                raise ValueError(f"{sum(here)} food objects; allowed: at most {MOST_FOODS} in an arena")
            foods = np.zeros(sum(here), food_dtype)
            foods["x"], foods["y"] = places[here].T
            inside = robots[[home is arena for home in homes]]
            enclosures.append(Enclosure(inside, foods, np.zeros(2 * len(foods), track_dtype)))
        self.show(enclosures, [self.arenas.index(a) for a in homes], [self.arenas.index(a) for a in plates])
        for enclosure in self._enclosures:
            _begin(*enclosure, self._constants)
        self.advance()  # Nothing moves: this takes the first frame.

    def show(self, enclosures: Sequence[Enclosure], homes: Sequence[int], plates: Sequence[int]) -> None:
        """Be the world of these records, which others may change.

        Args:
            enclosures: What is in each arena.
            homes: Number of the arena of each robot.
            plates: Number of the arena of each food object.
        """
        self._enclosures, self._homes = tuple(enclosures), tuple(homes)
        self._robots = _in_order(homes, [enclosure.robots for enclosure in enclosures])
        self._foods = _in_order(plates, [enclosure.foods for enclosure in enclosures])
        self._detections = [np.zeros(len(enclosure.foods), detection_dtype) for enclosure in enclosures]
        self.robots = tuple(map(CompiledKhepera, self._robots))
        self.camera.reset(self._robots, self._enclosures)

    def advance(self) -> None:
        """One round.

        Raises:
            RuntimeError: The world was never reset.
        """
        if not self.robots:
            raise RuntimeError("advance() before reset()")
        anchor = cable_anchor(self.arenas)
        for enclosure, detections, walls in zip(self._enclosures, self._detections, self._walls, strict=True):
            if len(enclosure.robots):
                _advance(*enclosure, detections, *walls, *anchor, self._constants)

    def poses(self) -> tuple[Pose, ...]:
        """The true poses of the robots."""
        return tuple(Pose(*(float(robot[name]) for name in ("x", "y", "heading"))) for robot in self._robots)

    def food_places(self) -> tuple[FoodPlace, ...]:
        """The true places of the food."""
        lifted = [
            enclosure.foods[robot["held"]]
            for enclosure in self._enclosures
            for robot in enclosure.robots
            if robot["held"] >= 0 and robot["arm"] < ARM_ON_FLOOR
        ]
        return tuple(
            FoodPlace(float(food["x"]), float(food["y"]), any(np.shares_memory(food, up) for up in lifted))
            for food in self._foods
        )

    def held(self, robot: int = 0) -> int:
        """Number of the food object in the gripper of a robot, counted in its arena; -1 without."""
        return int(self._robots[robot]["held"])

    def place(self, robot: int, pose: Pose) -> None:
        """Put a robot down elsewhere in its arena, at rest, with the food that it holds.

        Raises:
            ValueError: The place is not on the free floor, or taken.
        """
        record, home = self._robots[robot], self._homes[robot]
        foods = self._enclosures[home].foods
        carried = foods[record["held"]] if record["held"] >= 0 else None
        check_robot(self.arenas[home], pose)
        others = tuple(other for i, other in enumerate(self.poses()) if i != robot)
        places = tuple(
            Point(place.x, place.y)
            for food, place in zip(self._foods, self.food_places(), strict=True)
            if not place.lifted and (carried is None or not np.shares_memory(food, carried))
        )
        check_apart(Layout((*others, pose), places))
        record["x"], record["y"], record["heading"] = pose
        record["cos"], record["sin"] = cos, sin = math.cos(pose.heading), math.sin(pose.heading)
        record["last_forward"] = record["last_turn"] = 0.0
        if carried is not None:
            ahead, aside = record["grip_x"], record["grip_y"]
            carried["x"], carried["y"] = (
                pose.x + ahead * cos - aside * sin,
                pose.y + ahead * sin + aside * cos,
            )

    def stop(self) -> None:
        """Stop the wheels of all robots."""
        for robot in self.robots:
            robot.stop()

    def close(self) -> None:
        """Stop the robots."""
        for robot in self.robots:
            robot.close()


def _in_order(numbers: Sequence[int], parts: Sequence[NDArray[Any]]) -> tuple[Any, ...]:
    """The records of several arenas in the order of all robots, or of all food; `numbers` are those of their arenas."""
    nexts = [iter(part) for part in parts]
    return tuple(next(nexts[number]) for number in numbers)


@entry
def _begin(robots: Any, foods: Any, tracks: Any, constants: Any) -> None:
    for i in range(len(robots)):
        put_down(robots[i], robots[i].x, robots[i].y, robots[i].heading, constants[0])
    forget_tracks(foods, tracks)


@entry
def _advance(
    robots: Any,
    foods: Any,
    tracks: Any,
    detections: Any,
    walls: Any,
    corners: Any,
    anchor_x: float,
    anchor_y: float,
    constants: Any,
) -> None:
    advance(robots, foods, tracks, detections, walls, corners, anchor_x, anchor_y, constants[0])
