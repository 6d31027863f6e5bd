"""`examples/ppo.py` in small: it learns, and its files hold what it learned."""

import re
from pathlib import Path

import numpy as np
import pytest
import torch

from tests.benchmarks.running import is_picture, read
from tests.examples.running import module_of, refused, run_example


def test_ppo_forages_better_than_chance_after_a_short_training(tmp_path: Path) -> None:
    """Chance, held for five rounds, delivers in 13 % of the episodes."""
    small = ("--seed", "2", "--rounds", "200000", "--num-envs", "16", "--minibatch-size", "256")
    printed = run_example("ppo", tmp_path, *small, "--evaluations", "30", "--out", "out")
    found = re.findall(r"^(compiled|pymunk) +30 episodes: (\d+) of 30", printed, flags=re.MULTILINE)
    assert [backend for backend, _ in found] == ["compiled", "pymunk"]
    assert all(int(delivered) >= 24 for _, delivered in found)
    curve = read(tmp_path / "out" / "learning_curve.csv")
    assert int(curve[-1]["rounds"]) >= 200_000
    shares = [float(point["food_delivered"]) for point in curve if point["food_delivered"] != "nan"]
    assert shares[-1] > shares[0] + 0.3
    assert is_picture(tmp_path / "out" / "learning_curve.png")
    ppo = module_of("ppo")
    agent = ppo.load(tmp_path / "out" / "ppo.pt")
    again = ppo.evaluate(agent, ppo.parse(["--seed", "2", "--evaluations", "30"]), "pymunk")
    assert again.delivered == int(found[1][1]), "the checkpoint forages as the trained network did"


def test_advantages_stop_at_the_end_of_an_episode() -> None:
    """By hand, with gamma = lambda = 0.5: the second decision ends an episode, whose successor is not counted."""
    ppo = module_of("ppo")
    arguments = ppo.parse(["--gamma", "0.5", "--gae-lambda", "0.5"])
    column = [torch.tensor([[one] for one in numbers]) for numbers in ([1.0, 2, 4], [0.0, 1, 0], [1.0, 1, 1])]
    advantages = ppo.estimate(*column, torch.tensor([8.0]), arguments)
    # Backwards: 4 + 0.5 * 8 - 1 = 7; 2 - 1 = 1; 1 + 0.5 * 1 - 1 + 0.25 * 1 = 0.75.
    np.testing.assert_allclose(advantages.squeeze(1).numpy(), [0.75, 1.0, 7.0])


def test_time_limit_adds_the_value_of_the_last_observation() -> None:
    ppo = module_of("ppo")
    agent = ppo.Agent()
    last = {"object_presence": 0, "robot_home_distance": [60], "food_type": 0}
    last |= {"arms_height": [215], "robot_food_distance": [20]}
    info = {"final_obs": np.array([None, last], dtype=object)}
    values = ppo.final_values(agent, info, np.array([False, True]))
    assert values[0] == 0.0
    assert values[1] == pytest.approx(agent.values(ppo.features_of(last)).item())
    assert not ppo.final_values(agent, {}, np.array([False, False])).any()


@pytest.mark.parametrize(("example", "option"), [("ppo", "--num-envs"), ("multi_agent", "--rounds")])
def test_wrong_number_is_refused_in_one_line(example: str, option: str, tmp_path: Path) -> None:
    message = f"{option}: '0'; allowed: a whole number of at least 1"
    assert message in refused(example, tmp_path, option, "0")
