"""`CompiledWorld`: robots in one arena, their food and a camera on compiled bodies, as a `World`."""

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from khepera_forage.compilation import entry
from khepera_forage.counter_rng import random_bits
from khepera_forage.noise import Noise, checked_noise
from khepera_forage.robots.khepera import ARM_ON_FLOOR, FOOD_RADIUS, Motors, Senses, applicable, check_finite
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
    check_seen,
    check_starts,
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


class CompiledCamera:
    """The camera of a `CompiledWorld`: the markers' regions come first, in the order of the robots; food follows."""

    def __init__(self) -> None:
        self._robots, self._tracks = np.zeros(0, robot_dtype), np.zeros(0, track_dtype)

    def reset(self, robots: NDArray[Any], tracks: NDArray[Any]) -> None:
        """Show other records.

        Args:
            robots: `RobotState` records.
            tracks: Tracks of food, `Track` records.
        """
        self._robots, self._tracks = robots, tracks

    def look(self) -> Scene:
        """The regions of the last frame; none before the first."""
        regions = [_marker_region(i, robot) for i, robot in enumerate(self._robots)]
        for label, x, y, _, found, _ in sorted(self._tracks.tolist()):
            if label >= 0:
                edge = not in_picture(x, y, FOOD_RADIUS_PX, FOOD_RADIUS_PX)
                label += len(self._robots)
                regions.append(Region(label, x, y, 0, 0, found, edge, x, y + FOOD_RADIUS_PX, *FOOD_FEATURES))
        return Scene(tuple(regions))


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
    """Kheperas, food and an overhead camera above one arena, on the compiled bodies.

    Bodies and camera behave like those of `PymunkWorld`, with the same noise; `contact` says how contacts differ.

    Args:
        arena: The enclosure.
        noise: By default `Noise.laboratory()`.
        holes: Holes of the robot's marker, 1 or 2; one number a robot for several robots.
        timing: Duration of a round, and speeds of arm and jaw.

    Raises:
        ValueError: Another number of holes, or an arena that the camera does not see.
    """

    def __init__(
        self, arena: Arena, noise: Noise | str | None = None, *, holes: int | Sequence[int], timing: Timing
    ) -> None:
        self.markers = (holes,) if isinstance(holes, int) else tuple(holes)
        if not self.markers or any(number not in (1, 2) for number in self.markers):
            raise ValueError(f"holes is {holes!r}; allowed: 1 or 2")
        check_seen([arena])
        self.arenas = (arena,)
        self.noise = checked_noise(noise)
        self._timing = timing
        self.round_duration = self._timing.round_duration
        self.robots: tuple[CompiledKhepera, ...] = ()
        self.camera = CompiledCamera()
        self._walls = np.array(list(map(tuple, arena.wall_records)), wall_dtype)
        self._corners = np.array([(x, y) for x, y, _, _ in arena.corners], corner_dtype)
        self._constants = constants_of(self.noise, timing)

    def reset(self, rng: np.random.Generator, layout: Layout) -> None:
        """Put everything in its place.

        Args:
            rng: Spawned into the generator of this world's random numbers.
            layout: One start a robot, and at most 16 food objects.

        Raises:
            ValueError: Another number of starts or food objects, or something that does not stand on the free floor.
        """
        arena, foods = self.arenas[0], len(layout.foods)
        check_starts(layout, len(self.markers))
        if foods > MOST_FOODS:
            raise ValueError(f"{foods} food objects; allowed: at most {MOST_FOODS} in a compiled world")
        for start in layout.starts:
            check_robot(arena, start)
        for food in layout.foods:
            arena_of(self.arenas, "food", food, FOOD_RADIUS)
        check_apart(layout)
        robots, records = np.zeros(len(self.markers), robot_dtype), np.zeros(foods, food_dtype)
        key = rng.spawn(1)[0].integers(2**64, dtype=np.uint64)
        robots["key"] = random_bits(np.full(len(robots), key), np.arange(len(robots), dtype=np.uint64))
        robots["key"][0] = key
        robots["holes"] = self.markers
        records["x"], records["y"] = np.array(layout.foods).reshape(-1, 2).T
        self.show(robots, records, np.zeros(2 * foods, track_dtype))
        _begin(self._robots, self._foods, self._tracks, np.array(layout.starts), self._constants)
        self.advance()  # Nothing moves: this takes the first frame.

    def show(self, robots: NDArray[Any], foods: NDArray[Any], tracks: NDArray[Any]) -> None:
        """Be the world of these records, which others may change.

        Args:
            robots: `RobotState` records.
            foods: `FoodState` records.
            tracks: `Track` records.
        """
        self._robots, self._foods, self._tracks = robots, foods, tracks
        self._detections = np.zeros(len(foods), detection_dtype)
        self.robots = tuple(CompiledKhepera(robots[i]) for i in range(len(robots)))
        self.camera.reset(robots, tracks)

    def advance(self) -> None:
        """One round.

        Raises:
            RuntimeError: The world was never reset.
        """
        if not self.robots:
            raise RuntimeError("advance() before reset()")
        anchor_x, anchor_y = cable_anchor(self.arenas)
        _advance(
            *(self._robots, self._foods, self._tracks, self._detections, self._walls, self._corners),
            *(anchor_x, anchor_y, self._constants),
        )

    def poses(self) -> tuple[Pose, ...]:
        """The true poses of the robots."""
        return tuple(Pose(*(float(robot[name]) for name in ("x", "y", "heading"))) for robot in self._robots)

    def food_places(self) -> tuple[FoodPlace, ...]:
        """The true places of the food."""
        lifted = {int(robot["held"]) for robot in self._robots if robot["arm"] < ARM_ON_FLOOR}
        return tuple(
            FoodPlace(float(food["x"]), float(food["y"]), k in lifted) for k, food in enumerate(self._foods)
        )

    def held(self, robot: int = 0) -> int:
        """Number of the food object in the gripper of a robot, -1 without."""
        return int(self._robots[robot]["held"])

    def place(self, robot: int, pose: Pose) -> None:
        """Put a robot down elsewhere, at rest, with the food that it holds.

        Raises:
            ValueError: The place is not on the free floor, or taken.
        """
        record, held = self._robots[robot], self.held(robot)
        check_robot(self.arenas[0], pose)
        others = tuple(other for i, other in enumerate(self.poses()) if i != robot)
        foods = tuple(
            Point(x, y) for k, (x, y, lifted) in enumerate(self.food_places()) if k != held and not lifted
        )
        check_apart(Layout((*others, pose), foods))
        record["x"], record["y"], record["heading"] = pose
        record["cos"], record["sin"] = cos, sin = math.cos(pose.heading), math.sin(pose.heading)
        record["last_forward"] = record["last_turn"] = 0.0
        if held >= 0:
            ahead, aside, food = record["grip_x"], record["grip_y"], self._foods[held]
            food["x"], food["y"] = pose.x + ahead * cos - aside * sin, pose.y + ahead * sin + aside * cos

    def stop(self) -> None:
        """Stop the wheels of all robots."""
        for robot in self.robots:
            robot.stop()

    def close(self) -> None:
        """Stop the robots."""
        for robot in self.robots:
            robot.close()


@entry
def _begin(robots: Any, foods: Any, tracks: Any, poses: Any, constants: Any) -> None:
    for i in range(len(robots)):
        put_down(robots[i], poses[i, 0], poses[i, 1], poses[i, 2], constants[0])
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
