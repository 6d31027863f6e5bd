"""Bare pymunk: the same bodies without the rest of the package, as a lower bound on the cost of a step.

A robot (disc, palm, two fingers) drives circles inside the four walls of the corridor; a food disc lies there, held
by the two joints of its floor friction. The robot's velocities are set before every pymunk step of 20 ms.
"""

import math
from collections.abc import Callable
from time import perf_counter

import pymunk

from khepera_forage.envs.arguments import checked_arena
from khepera_forage.robots.khepera import (
    FINGER_THICKNESS,
    FINGER_TIP,
    FOOD_RADIUS,
    JAW_OPEN,
    JAW_ROOT,
    MASS,
    RADIUS,
    half_gap,
)
from khepera_forage.robots.proximity import REACH
from khepera_forage.sim.arenas.thesis import CORRIDOR
from khepera_forage.sim.pymunk.bodies import FLOOR_FRICTION, FOOD_MASS
from khepera_forage.task.decisions import Decisions
from timing.measures import Job, Measure, Values

ARENA = checked_arena(CORRIDOR, Decisions.v0_1())
PHYSICS_STEP = 0.02
SUBSTEPS = 5
RAYS = 8
_SPEED, _TURN = 60.0, 2.0
"""mm/s and rad/s: a circle of 30 mm radius."""

SECTION = "Bare pymunk"
NOTE = (
    "The same bodies without the rest of the package: robot, gripper, walls, food with its floor joints. The shares "
    "are those of one pymunk step with eight rays, measured with the clock read around each part, in a separate run."
)
ROUND = Measure(
    SECTION,
    "five pymunk steps, then eight rays: a round of 0.1 s",
    "rounds/s",
    "velocities set before each pymunk step of 20 ms; rays are segment queries",
)
STEP = Measure(
    SECTION, "one pymunk step, then eight rays", "steps/s", "velocities set; 20 ms; segment queries"
)
SHARES = tuple(Measure(SECTION, f"share of the {part}", "%") for part in ("simulation", "setters", "rays"))


class _Bare:
    """The space, and the three things done to it."""

    def __init__(self) -> None:
        space = self.space = pymunk.Space()
        for x1, y1, x2, y2 in ARENA.segments:
            space.add(pymunk.Segment(space.static_body, (x1, y1), (x2, y2), 0))
        robot = self.robot = pymunk.Body(MASS, MASS * RADIUS**2 / 2)
        robot.position = (150.0, 85.0)
        thin = FINGER_THICKNESS / 2
        wide = half_gap(JAW_OPEN) + thin
        ends = [((JAW_ROOT - thin, -wide), (JAW_ROOT - thin, wide))]
        ends += [((JAW_ROOT, y), (FINGER_TIP - thin, y)) for y in (wide, -wide)]
        shapes = [pymunk.Circle(robot, RADIUS), *(pymunk.Segment(robot, a, b, thin) for a, b in ends)]
        self._others = pymunk.ShapeFilter(group=1)  # rays start inside the robot, and must not end there
        for shape in shapes:
            shape.filter = self._others
        space.add(robot, *shapes)
        food = pymunk.Body(FOOD_MASS, pymunk.moment_for_circle(FOOD_MASS, 0, FOOD_RADIUS))
        food.position = ARENA.foods[0]
        slide = pymunk.PivotJoint(space.static_body, food, (0, 0), (0, 0))
        spin = pymunk.GearJoint(space.static_body, food, 0, 1)
        slide.max_bias = spin.max_bias = 0
        slide.max_force, spin.max_force = FLOOR_FRICTION, FLOOR_FRICTION * FOOD_RADIUS * 2 / 3
        space.add(food, pymunk.Circle(food, FOOD_RADIUS), slide, spin)
        angles = [2 * math.pi * i / RAYS for i in range(RAYS)]
        self._rays = [(REACH * math.cos(angle), REACH * math.sin(angle)) for angle in angles]

    def drive(self) -> None:
        """Set the robot's velocities: the setters."""
        robot = self.robot
        angle = robot.angle
        robot.velocity = _SPEED * math.cos(angle), _SPEED * math.sin(angle)
        robot.angular_velocity = _TURN

    def step(self) -> None:
        """The pymunk step."""
        self.space.step(PHYSICS_STEP)

    def cast(self) -> None:
        """The rays."""
        x, y = self.robot.position
        query = self.space.segment_query_first
        for dx, dy in self._rays:
            query((x, y), (x + dx, y + dy), 1.0, self._others)


def job(rounds: int) -> Job:
    """Measure `rounds` rounds, and as many pymunk steps with rays, twice."""

    def run() -> Values:
        bare = _Bare()

        def a_round() -> None:
            for _ in range(SUBSTEPS):
                bare.drive()
                bare.step()
            bare.cast()

        def a_step() -> None:
            bare.drive()
            bare.step()
            bare.cast()

        values = {ROUND: _rate(a_round, rounds), STEP: _rate(a_step, rounds)}
        values.update(zip(SHARES, _shares(bare, rounds), strict=True))
        return values

    return run


def _rate(work: Callable[[], None], count: int) -> float:
    start = perf_counter()
    for _ in range(count):
        work()
    return count / (perf_counter() - start)


def _shares(bare: _Bare, steps: int) -> list[float]:
    simulation = setters = rays = 0.0
    for _ in range(steps):
        begun = perf_counter()
        bare.drive()
        driven = perf_counter()
        bare.step()
        stepped = perf_counter()
        bare.cast()
        rays += perf_counter() - stepped
        simulation += stepped - driven
        setters += driven - begun
    return [100 * part / (simulation + setters + rays) for part in (simulation, setters, rays)]
