"""The environment checker of stable-baselines3."""

import gymnasium as gym
import pytest
from stable_baselines3.common.env_checker import check_env

import khepera_forage  # noqa: F401 (registers)


@pytest.mark.parametrize("name", ["Corridor", "Rectangle", "CorridorWheels", "RectangleWheels"])
def test_environments_pass_check_env(name: str) -> None:
    env = gym.make(f"khepera_forage/{name}-v1", render_mode="rgb_array")
    check_env(env.unwrapped, warn=True)
    env.close()
