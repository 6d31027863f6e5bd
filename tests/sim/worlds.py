"""Worlds for tests: a wide floor, no noise, food out of the way."""

import math
from collections.abc import Callable
from importlib.util import find_spec
from typing import Any

import numpy as np
import pytest

from khepera_forage.noise import Noise
from khepera_forage.robots.khepera import ARM_DOWN, ARM_RAISED, JAW_CLOSED, JAW_OPEN, Motors, Senses
from khepera_forage.sim.arena import Arena, Point, Pose
from khepera_forage.sim.arenas.named import box
from khepera_forage.sim.pymunk.world import PymunkWorld
from khepera_forage.sim.world import FoodPlace, Layout, Timing
from tests.version_0_1 import TIMING

NONE = Noise.none()
Kind = Callable[..., Any]
KINDS: list[Kind] = [PymunkWorld]
if find_spec("numba"):
    from khepera_forage.sim.compiled.world import CompiledWorld

    KINDS.append(CompiledWorld)
of_both_kinds = pytest.mark.parametrize("kind", KINDS)


FIELD = Arena("field", box(0, 0, 2000, 2000), Point(1800, 1800), 100, Pose(1000, 1000, 0), (Point(100, 100),))
"""So wide that a robot hits nothing by chance."""


def make_world(
    start: Pose,
    *foods: tuple[float, float],
    arena: Arena = FIELD,
    noise: Noise = NONE,
    seed: int = 0,
    kind: Kind = PymunkWorld,
    timing: Timing = TIMING,
    **more: Any,
) -> Any:
    """A world with one robot, after its reset."""
    world = kind([arena], (2,), noise, timing=timing, **more)
    world.reset(np.random.default_rng(seed), Layout((start,), tuple(Point(*food) for food in foods)))
    return world


def run(
    world: Any, rounds: int, left: float = 0, right: float = 0, arm: int = ARM_RAISED, jaw: int = JAW_OPEN
) -> Senses:
    """Rounds under one command to the first robot; returns what it senses then."""
    for _ in range(rounds):
        world.robots[0].drive(Motors(left, right, arm, jaw))
        world.advance()
    senses: Senses = world.robots[0].sense()
    return senses


def holding(
    start: Pose = FIELD.start,
    *others: tuple[float, float],
    arena: Arena = FIELD,
    kind: Kind = PymunkWorld,
    ahead: float = 57.0,
) -> Any:
    """A robot that holds food number 0 in its raised gripper, so far ahead of its middle."""
    food = start.x + ahead * math.cos(start.heading), start.y + ahead * math.sin(start.heading)
    world = make_world(start, food, *others, arena=arena, kind=kind)
    run(world, 12, arm=ARM_DOWN)
    run(world, 8, arm=ARM_DOWN, jaw=JAW_CLOSED)
    run(world, 12, arm=ARM_RAISED, jaw=JAW_CLOSED)
    assert world.food_places()[0].lifted
    return world


def apart(a: Pose | FoodPlace | Point, b: Pose | FoodPlace | Point) -> float:
    return math.dist(a[:2], b[:2])
