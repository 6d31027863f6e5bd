"""Simulated bodies: the `World` of pymunk."""

import math
from collections.abc import Sequence

import numpy as np
import pymunk

from khepera_forage.noise import Noise, checked_noise
from khepera_forage.robots.khepera import FOOD_RADIUS, RADIUS
from khepera_forage.robots.parameters import RobotParameters
from khepera_forage.sim.arena import Arena, Point, Pose
from khepera_forage.sim.layout_checks import (
    arena_of,
    cable_anchor,
    check_apart,
    check_robot,
    check_starts,
    check_world,
)
from khepera_forage.sim.pymunk import collision_filters as layers
from khepera_forage.sim.pymunk.food import PymunkFood
from khepera_forage.sim.pymunk.khepera import PymunkKhepera
from khepera_forage.sim.pymunk.noise_blocks import Draws
from khepera_forage.sim.world import FINE_TRAVEL, SUBSTEPS, FoodPlace, Layout, Timing
from khepera_forage.vision.simulated_camera import OverheadCamera, Truth


class PymunkWorld:
    """Kheperas, food and an overhead camera above one or more enclosures.

    Args:
        arenas: The enclosures, in one frame of millimetres.
        markers: Number of holes of each robot's marker, 1 or 2; one robot each.
        noise: The laboratory's troubles.
        robot_parameters: Deviations of each robot; none by default.
        timing: How long a round lasts, and how fast arm and jaw move.

    Raises:
        ValueError: No arena, no robot, a marker with another number of holes, or not one `RobotParameters` per robot.
    """

    def __init__(
        self,
        arenas: Sequence[Arena],
        markers: Sequence[int],
        noise: Noise | str | None = None,
        robot_parameters: Sequence[RobotParameters] | None = None,
        *,
        timing: Timing,
    ) -> None:
        check_world(arenas, markers)
        if robot_parameters is not None and len(robot_parameters) != len(markers):
            raise ValueError(
                f"{len(robot_parameters)} robot_parameters given; allowed: {len(markers)}, one per robot"
            )
        self.robot_parameters = (
            (RobotParameters(),) * len(markers) if robot_parameters is None else tuple(robot_parameters)
        )
        self.arenas = tuple(arenas)
        self._timing = timing
        self.round_duration = self._timing.round_duration
        self.noise = checked_noise(noise)
        self.foods: tuple[PymunkFood, ...] = ()
        self.robots: tuple[PymunkKhepera, ...] = ()
        self.markers = tuple(markers)
        self.camera = OverheadCamera(self.truth, self.noise, cable_anchor(arenas))
        self._space = pymunk.Space()

    def reset(self, rng: np.random.Generator, layout: Layout) -> None:
        """Put everything in its place, in a new space (only that is bit-exact per seed).

        Args:
            rng: Spawned into one generator a subsystem, so that one more source does not shift the others.
            layout: As many starts as robots.

        Raises:
            ValueError: A robot or food that does not stand on the free floor of an arena, or stands in another.
        """
        check_starts(layout, len(self.markers))
        homes = [arena_of(self.arenas, "robot", start, RADIUS) for start in layout.starts]
        for home, start in zip(homes, layout.starts, strict=True):
            check_robot(home, start)
        plates = [arena_of(self.arenas, "food", food, FOOD_RADIUS) for food in layout.foods]
        check_apart(layout)
        self._homes = homes
        wheels, sensors = rng.spawn(2)
        bias = self.noise.wheel_bias * wheels.standard_normal((len(homes), 2))
        self._draws = Draws(wheels, sensors)
        space = self._space = pymunk.Space()
        space.collision_bias = 0.7**60
        # Enough for a row of food squeezed against a wall to stay out of it: with ten it gave way by 1.6 mm.
        space.iterations = 40
        # Contacts are not carried over from step to step: their impulses, scaled to a step of another length, would
        # throw a robot that pressed a finger against a wall.
        space.collision_persistence = 1
        walls = [
            pymunk.Segment(space.static_body, (x1, y1), (x2, y2), 0)
            for arena in self.arenas
            for x1, y1, x2, y2 in arena.segments
        ]
        for wall in walls:
            wall.friction = 0.2
            wall.filter = layers.WALL
        space.add(*walls)
        self.foods = tuple(PymunkFood(space, place) for place in layout.foods)
        self.robots = tuple(
            PymunkKhepera(
                space, start, arena.segments, self.noise, (float(b[0]), float(b[1])), parameters, self._timing
            )
            for start, arena, b, parameters in zip(
                layout.starts, homes, bias, self.robot_parameters, strict=True
            )
        )
        for robot, home in zip(self.robots, homes, strict=True):
            robot.foods = [food for food, plate in zip(self.foods, plates, strict=True) if plate is home]
            robot.others = [
                other.body
                for other, its in zip(self.robots, homes, strict=True)
                if its is home and other is not robot
            ]
        self.camera.reset(rng)

    def advance(self) -> None:
        """One round."""
        if not self.robots:
            raise RuntimeError("advance() before reset()")
        robots = self.robots
        substeps = 0
        for robot in robots:
            needed = robot.begin_round(*self._draws.next())
            if needed > substeps:
                substeps = needed
        gliding = 0.0
        for food in self.foods:
            if food.moved > gliding:
                gliding = food.moved
        if gliding:  # Food that was flung meets a wall no faster, step by step, than a robot does.
            substeps = max(substeps, SUBSTEPS, math.ceil(gliding / FINE_TRAVEL))
        if substeps:
            self._step(substeps)
        else:
            for robot in robots:
                robot.glide()
        self.camera.expose()

    def _step(self, substeps: int) -> None:
        """A round of physics."""
        for robot in self.robots:
            robot.engage()
        busy = [robot for robot in self.robots if robot.busy]
        dt = self._timing.round_duration / substeps
        step = self._space.step
        for _ in range(substeps):
            for robot in busy:
                robot.push(dt)
            step(dt)
        for food in self.foods:
            food.end_round()
        for robot in self.robots:
            robot.end_round()

    def poses(self) -> tuple[Pose, ...]:
        """Where the robots truly are."""
        return tuple(robot.pose for robot in self.robots)

    def food_places(self) -> tuple[FoodPlace, ...]:
        """Where the food truly is."""
        return tuple(FoodPlace(*food.place, food.lifted) for food in self.foods)

    def place(self, robot: int, pose: Pose) -> None:
        """Put a robot down elsewhere, with what it holds.

        Raises:
            ValueError: The place is not on the free floor, or taken.
        """
        check_robot(self._homes[robot], pose)
        held = self.robots[robot].gripper.held
        starts = tuple(other.pose for other in self.robots if other is not self.robots[robot])
        foods = tuple(Point(*food.place) for food in self.foods if food is not held and not food.lifted)
        check_apart(Layout((*starts, pose), foods))
        self.robots[robot].put(pose)

    def stop(self) -> None:
        """Stop the wheels of all robots."""
        for robot in self.robots:
            robot.stop()

    def close(self) -> None:
        """Stop the robots."""
        for robot in self.robots:
            robot.close()

    def truth(self) -> Truth:
        """What a camera above this world sees, before any trouble of seeing."""
        # Once a round: loops, because a comprehension is a call, and the constructor of tuples, because a named
        # tuple's own takes twice as long.
        markers, foods = [], []
        for i, robot in enumerate(self.robots):
            x, y, heading = robot.pose
            markers.append((x, y, heading, self.markers[i]))
        for food in self.foods:
            foods.append(food.place)
        return tuple.__new__(Truth, (tuple(markers), tuple(foods)))
