"""`CompiledWorld`: one robot, its food and a camera on compiled bodies, as a `World`."""

import math
from typing import Any

import numpy as np

from khepera_forage.compilation.trigonometry import cosine_sine
from khepera_forage.noise import Noise, checked_noise
from khepera_forage.robots.khepera import ARM_ON_FLOOR, FOOD_RADIUS, Motors, Senses, applicable
from khepera_forage.sim.arena import Arena, Point, Pose
from khepera_forage.sim.compiled.bodies import Bodies, empty_bodies
from khepera_forage.sim.compiled.numbers import MOST_FOODS
from khepera_forage.sim.compiled.parameters import Parameters, parameters_of
from khepera_forage.sim.compiled.start import stand_in_blocks
from khepera_forage.sim.compiled.stepping import advance_all
from khepera_forage.sim.layout_checks import arena_of, check_apart, check_robot, check_seen, check_starts
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
    """The robot of a `CompiledWorld`.

    Args:
        record: A `robot_dtype` record of one lane.
    """

    def __init__(self, record: Any) -> None:
        self._record = record

    def sense(self) -> Senses:
        """What the robot senses since the last round."""
        record = self._record
        return Senses(
            tuple(record["proximity"][:, 0].astype(np.int64).tolist()),
            int(record["pulses_left"][0]),
            int(record["pulses_right"][0]),
            int(record["arm_reading"][0]),
            int(record["jaw_reading"][0]),
            int(record["object_presence"][0]),
        )

    def drive(self, motors: Motors) -> Motors:
        """Command motors from the next round on; returns the command as applied."""
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
    """The camera of a `CompiledWorld`: the marker's region has label 0, food follows.

    Args:
        holes: Holes of the marker.
    """

    def __init__(self, holes: int) -> None:
        self._holes = holes
        self._record: Any = None
        self._tracks: Any = None

    def reset(self, record: Any, tracks: Any) -> None:
        """Show other records.

        Args:
            record: A `robot_dtype` record of one lane.
            tracks: The food's tracks, `track_dtype`.
        """
        self._record, self._tracks = record, tracks

    def look(self) -> Scene:
        """The regions of the last frame; none before the first."""
        if self._record is None:
            return Scene(())
        regions = [self._marker()]
        for label, x, y, _, found, _ in sorted(self._tracks.tolist()):
            if label >= 0:
                edge = not in_picture(x, y, FOOD_RADIUS_PX, FOOD_RADIUS_PX)
                regions.append(
                    Region(label + 1, x, y, 0, 0, found, edge, x, y + FOOD_RADIUS_PX, *FOOD_FEATURES)
                )
        return Scene(tuple(regions))

    def _marker(self) -> Region:
        record, holes = self._record, self._holes
        x, y = float(record["marker_x"][0]), float(record["marker_y"][0])
        heading, found = int(record["marker_heading"][0]), bool(record["marker_found"][0])
        turned = math.radians(heading)
        half_width, half_height, first = marker_outline(math.cos(turned), math.sin(turned))
        edge = not in_picture(x, y, half_width, half_height)
        return Region(
            0, x, y, holes, heading, found, edge, x + first, y + half_height, *MARKER_FEATURES[holes]
        )


class CompiledWorld:
    """One Khepera, food and an overhead camera above one arena, on the compiled bodies.

    Bodies and camera behave like those of `PymunkWorld`, with the same noise; `contact` says how contacts differ.

    Args:
        arena: The enclosure.
        noise: By default `Noise.laboratory()`.
        holes: Holes of the robot's marker, 1 or 2.
        timing: Duration of a round, and speeds of arm and jaw.

    Raises:
        ValueError: Another number of holes, or an arena that the camera does not see.
    """

    def __init__(self, arena: Arena, noise: Noise | str | None = None, *, holes: int, timing: Timing) -> None:
        if holes not in (1, 2):
            raise ValueError(f"holes is {holes!r}; allowed: 1 or 2")
        check_seen([arena])
        self.arenas = (arena,)
        self.markers = (holes,)
        self.noise = checked_noise(noise)
        self._timing = timing
        self.round_duration = self._timing.round_duration
        self.robots: tuple[CompiledKhepera, ...] = ()
        self.camera = CompiledCamera(holes)
        self._bodies = empty_bodies(1, 0, lanes=1)

    def reset(self, rng: np.random.Generator, layout: Layout) -> None:
        """Put everything in its place.

        Args:
            rng: Spawned into the generator of this world's random numbers.
            layout: One start, and at most 16 food objects.

        Raises:
            ValueError: Another number of starts or food objects, or something that does not stand on the free floor.
        """
        arena, foods = self.arenas[0], len(layout.foods)
        check_starts(layout, 1)
        if foods > MOST_FOODS:
            raise ValueError(f"{foods} food objects; allowed: at most {MOST_FOODS} in a compiled world")
        check_robot(arena, layout.starts[0])
        for food in layout.foods:
            arena_of(self.arenas, "food", food, FOOD_RADIUS)
        check_apart(layout)
        bodies = empty_bodies(1, foods, lanes=1)
        parameters = parameters_of(arena, foods, self.noise, holes=self.markers[0], timing=self._timing)
        self.show(bodies, parameters)
        bodies.robots["key"] = rng.spawn(1)[0].integers(2**64, dtype=np.uint64)
        stand_in_blocks(bodies, parameters, np.array(layout.starts))
        for k, food in enumerate(layout.foods):
            bodies.foods[0, k]["x"], bodies.foods[0, k]["y"] = food
        self.advance()  # Nothing moves: this takes the first frame.

    def show(self, bodies: Bodies, parameters: Parameters) -> None:
        """Be the world of these records, which others may change.

        Args:
            bodies: The records of one block with one lane.
            parameters: Theirs, of the same arena, noise, marker and timing.
        """
        self._bodies, self._parameters = bodies, parameters
        self.robots = (CompiledKhepera(bodies.robots[0]),)
        self.camera.reset(bodies.robots[0], bodies.tracks[0, 0])

    def advance(self) -> None:
        """One round.

        Raises:
            RuntimeError: The world was never reset.
        """
        if not self.robots:
            raise RuntimeError("advance() before reset()")
        advance_all(self._bodies, self._parameters)

    def poses(self) -> tuple[Pose, ...]:
        """The true pose of the robot."""
        record = self._bodies.robots[0]
        return (Pose(*(float(record[name][0]) for name in ("x", "y", "heading"))),)

    def food_places(self) -> tuple[FoodPlace, ...]:
        """The true places of the food."""
        record, foods = self._bodies.robots[0], self._bodies.foods[0]
        held = int(record["held"][0]) if record["arm"][0] < ARM_ON_FLOOR else -1
        return tuple(
            FoodPlace(float(food["x"][0]), float(food["y"][0]), k == held) for k, food in enumerate(foods)
        )

    def held(self) -> int:
        """Number of the food object in the gripper, -1 without."""
        return int(self._bodies.robots[0]["held"][0])

    def place(self, robot: int, pose: Pose) -> None:
        """Put the robot down elsewhere, at rest, with the food that it holds.

        Raises:
            ValueError: The place is not on the free floor.
        """
        record, held = self._bodies.robots[robot], self.held()
        check_robot(self.arenas[0], pose)
        foods = tuple(Point(x, y) for k, (x, y, _) in enumerate(self.food_places()) if k != held)
        check_apart(Layout((pose,), foods))
        record["x"], record["y"], record["heading"] = pose
        record["cos"], record["sin"] = cos, sin = cosine_sine(pose.heading)
        record["last_forward"] = record["last_turn"] = 0.0
        if held >= 0:
            ahead, aside, food = record["grip_x"], record["grip_y"], self._bodies.foods[0, held]
            food["x"], food["y"] = pose.x + ahead * cos - aside * sin, pose.y + ahead * sin + aside * cos

    def stop(self) -> None:
        """Stop the robot's wheels."""
        for robot in self.robots:
            robot.stop()

    def close(self) -> None:
        """Stop the robot."""
        for robot in self.robots:
            robot.close()
