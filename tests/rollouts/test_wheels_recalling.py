"""One recall with motors commanded: the row says what the environment said."""

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from khepera_forage.envs.wheels_env import WheelsEnv
from khepera_forage.robots.khepera import JAW_OPEN, MAX_SPEED
from khepera_forage.rollouts.wheels_recall import WheelsRecall, recall_wheels, recall_wheels_env


class Puppet:
    """Commands what the teacher's behaviours would, out of the very environment it forages in."""

    def __init__(self, env: WheelsEnv) -> None:
        self.env = env

    def act(self, observation: dict[str, Any], rng: np.random.Generator | None = None) -> NDArray[Any]:
        forager = self.env.forager
        motors = forager.motors_for(forager.correct_behaviour)
        jaw = -1.0 if motors.jaw > JAW_OPEN / 2 else 1.0
        return np.array((motors.left / MAX_SPEED, motors.right / MAX_SPEED, (235 - motors.arm) / 20, jaw))


class Chance:
    """Commands whatever it draws."""

    def act(self, observation: dict[str, Any], rng: np.random.Generator | None = None) -> NDArray[Any]:
        assert rng is not None
        return rng.uniform(-1.0, 1.0, 4)


@pytest.mark.parametrize(("arena", "foods"), [("corridor", 1), ("rectangle", 2)])
def test_who_does_what_the_teacher_would_delivers(arena: str, foods: int) -> None:
    env = recall_wheels_env(arena)
    seen: list[int] = []
    row = recall_wheels(env, Puppet(env), 1, watch=lambda: seen.append(1))
    assert row == WheelsRecall(100.0, row.steps, foods, foods, 0, row.steps)
    assert len(seen) == row.steps + 1 < env.limit


def test_same_seed_same_row() -> None:
    env = recall_wheels_env("corridor", limit=80)
    rows = [recall_wheels(env, Chance(), seed) for seed in (3, 4, 3)]
    assert rows[0] == rows[2]
    assert rows[0].steps == 80
    assert rows[0].delivered == 0
    assert rows[0].score == pytest.approx(100 * rows[0].correct / 80 - 20)
