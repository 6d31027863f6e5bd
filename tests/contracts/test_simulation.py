"""The contracts, for worlds of both backends."""

from itertools import product
from typing import Any

import numpy as np
import pytest

from khepera_forage.envs.behaviours_env import BehavioursEnv
from khepera_forage.robots.khepera import Motors
from tests.arenas import POOL
from tests.contracts.suites import CameraContract, RobotContract, Stage, WorldContract
from tests.version_0_1 import RECTANGLE, V0_1


@pytest.fixture(params=product(["pymunk", "compiled"], [True, False]), ids=str)
def stage(request: pytest.FixtureRequest) -> Stage:
    """A world that was made for this episode, with noise, or one without that has been in another arena before."""
    backend, moved = request.param
    if backend == "compiled":
        pytest.importorskip("numba")
    arena = POOL if moved else RECTANGLE
    noise = "none" if moved else "laboratory"
    env: Any = BehavioursEnv(arena=arena, foods=1, noise=noise, backend=backend, decisions=V0_1)
    for seed in (1, 0):  # episodes in the third and the second arena of the pool
        env.reset(seed=seed, options={"start": (200, 300, 29), "foods": [(500, 150)]})
    assert env.world.arenas[0] == (POOL[1] if moved else RECTANGLE)
    env.world.reset(np.random.default_rng(3), env.layout)
    return Stage(env.world, env.layout, env.world)


class TestSimulatedKhepera(RobotContract):
    pass


class TestOverheadCamera(CameraContract):
    pass


class TestSimulation(WorldContract):
    def test_same_generator_gives_the_same_world_bit_for_bit(self, stage: Stage) -> None:
        runs = []
        for _ in range(2):
            stage.world.reset(np.random.default_rng(9), stage.layout)
            history = []
            for i in range(30):
                motors = Motors(10 - i % 5, 5 + i % 7, 215 if i < 15 else 255, 200 if i % 10 < 5 else 0)
                stage.rounds(1, motors)
                history.append((stage.robot.sense(), stage.camera.look(), stage.world.poses()))
            runs.append(history)
        assert runs[0] == runs[1]
