"""Recalls with motor commands as actions."""

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from khepera_forage.envs.wheels_env import WheelsEnv
from khepera_forage.robots.khepera import JAW_OPEN, MAX_SPEED
from khepera_forage.rollouts.recall import WheelsRecall, recall_wheels, recall_wheels_env


class TeachersMotors:
    """Commands the motors of the teacher's behaviours, which it reads from the environment."""

    def __init__(self, env: WheelsEnv) -> None:
        self.env = env

    def act(self, observation: dict[str, Any], rng: np.random.Generator | None = None) -> NDArray[Any]:
        forager = self.env.forager
        motors = forager.motors_for(forager.correct_behaviour)
        jaw = -1.0 if motors.jaw > JAW_OPEN / 2 else 1.0
        return np.array((motors.left / MAX_SPEED, motors.right / MAX_SPEED, (235 - motors.arm) / 20, jaw))


@pytest.mark.parametrize(("arena", "foods"), [("corridor", 1), ("rectangle", 2)])
def test_recall_with_the_teachers_motors_delivers_all_food(arena: str, foods: int) -> None:
    env = recall_wheels_env(arena)
    calls: list[int] = []
    row = recall_wheels(env, TeachersMotors(env), 1, callback=lambda: calls.append(1))
    assert row == WheelsRecall(100.0, row.steps, foods, foods, 0, row.steps)
    assert len(calls) == row.steps + 1 < env.limit
