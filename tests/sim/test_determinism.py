"""Same generator state, layout and commands: the same world, bit for bit, in this process and in another."""

import copy
import hashlib
import pickle
from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest

from khepera_forage.noise import Noise
from khepera_forage.robots.khepera import Motors
from khepera_forage.sim.arena import Arena, Point, Pose, copies
from khepera_forage.sim.pymunk.world import PymunkWorld
from khepera_forage.sim.world import Layout
from tests.sim.worlds import ELL
from tests.version_0_1 import CORRIDOR, RECTANGLE, TIMING

ROUNDS = 150
LAYOUTS = {
    "corridor": ((CORRIDOR,), Layout((CORRIDOR.start,), CORRIDOR.foods)),
    "rectangle": ((RECTANGLE,), Layout((RECTANGLE.start,), RECTANGLE.foods)),
    "ell": ((ELL,), Layout((ELL.start,), ELL.foods)),
    "pair": (
        copies(CORRIDOR, 2),
        Layout((CORRIDOR.start, CORRIDOR.start._replace(y=415)), (Point(370, 115), Point(370, 415))),
    ),
}


def world_for(name: str, noise: Noise | None = None) -> PymunkWorld:
    arenas: tuple[Arena, ...] = LAYOUTS[name][0]
    return PymunkWorld(arenas, tuple(2 - i for i in range(len(arenas))), noise, timing=TIMING)


def rounds(world: PymunkWorld, name: str, seed: int, count: int = ROUNDS) -> Iterator[str]:
    """Everything that a world reports after each round, to the last bit."""
    world.reset(np.random.default_rng(seed), LAYOUTS[name][1])
    commands = np.random.default_rng(seed + 1000)
    for i in range(count):
        if i % 6 == 0:
            for robot in world.robots:
                left, right = commands.integers(-20, 21, 2).tolist()
                arm, jaw = int(commands.choice([215, 255])), int(commands.choice([0, 200]))
                robot.drive(Motors(left, right, arm, jaw))
        world.advance()
        senses = [robot.sense() for robot in world.robots]
        yield repr((senses, world.camera.look(), world.poses(), world.food_places()))


def digest(name: str, seed: int) -> str:
    return hashlib.sha256("\n".join(rounds(world_for(name), name, seed)).encode()).hexdigest()


@pytest.mark.parametrize("name", LAYOUTS)
def test_same_seed_gives_the_same_world_and_another_seed_another(name: str) -> None:
    assert digest(name, 5) == digest(name, 5)
    assert digest(name, 5) != digest(name, 6)


def test_noise_sources_are_independent() -> None:
    """Camera and sensors of a standing robot report the same whether wheels slip or not."""
    layout = LAYOUTS["rectangle"][1]
    seen = []
    for slip in (0.0, 0.05):
        world = world_for("rectangle", replace(Noise.laboratory(), wheel_slip=slip, wheel_bias=slip))
        world.reset(np.random.default_rng(8), layout)
        for _ in range(60):
            world.advance()
        seen.append((world.robots[0].sense(), world.camera.look()))
    assert seen[0] == seen[1]


def test_wheel_bias_does_not_depend_on_the_amount_of_food() -> None:
    """Bias is drawn before anything that depends on the number of food objects."""
    ends = []
    for foods in ((), (Point(600, 60),), (Point(600, 60), Point(600, 540))):
        world = world_for("rectangle", replace(Noise.none(), wheel_bias=0.05))
        world.reset(np.random.default_rng(8), Layout((Pose(90, 300, 0),), foods))
        world.robots[0].drive(Motors(10, 10, 215, 200))
        for _ in range(20):
            world.advance()
        ends.append(world.poses()[0])
    assert ends[0] == ends[1] == ends[2]
    assert abs(ends[0].heading) > 1e-4


def test_a_copy_continues_like_its_original_to_the_last_bit() -> None:
    """In the middle of pushes, grips and collisions."""
    commands = np.random.default_rng(1)
    world = world_for("rectangle")
    world.reset(np.random.default_rng(0), LAYOUTS["rectangle"][1])
    for _ in range(40):
        ends = set()
        for one in (copy.deepcopy(world), pickle.loads(pickle.dumps(world)), world):
            given = np.random.default_rng(2)
            for _ in range(12):
                left, right = given.integers(-20, 21, 2).tolist()
                one.robots[0].drive(Motors(left, right, int(given.choice([215, 255])), 0))
                one.advance()
            ends.add(repr((one.robots[0].sense(), one.camera.look(), one.poses(), one.food_places())))
        assert len(ends) == 1
        left, right = commands.integers(-5, 21, 2).tolist()
        world.robots[0].drive(Motors(left, right, 255, int(commands.choice([0, 200]))))
        for _ in range(5):
            world.advance()
