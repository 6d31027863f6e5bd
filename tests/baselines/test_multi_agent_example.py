"""`examples/multi_agent.py` in small: both agents learn from their own rewards."""

import re
from pathlib import Path

import pytest
import torch

from khepera_forage.task.states import Behaviour
from tests.examples.running import module_of, run_example


def test_pairs_finish_sooner_after_a_short_training(tmp_path: Path) -> None:
    printed = run_example("multi_agent", tmp_path, "--rounds", "20000", "--evaluations", "8")
    found = re.findall(
        r"^(?:before|after) +8 episodes: food teacher_0 (\d), learner_0 (\d); (\d) complete, (\d+) rounds",
        printed,
        flags=re.MULTILINE,
    )
    before, after = [[int(number) for number in numbers] for numbers in found]
    assert after[3] < before[3] - 50
    assert all(number <= 8 for number in (*before[:3], *after[:3]))


def test_decision_holds_and_rewards_add_up(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(str(Path(__file__).parents[2] / "examples"))  # it imports ppo.py beside it
    example = module_of("multi_agent")
    env = example.paired_corridors()
    env.reset(seed=3)
    actions = torch.tensor([int(Behaviour.SEARCH_FOR_FOOD), int(Behaviour.WAIT)])
    shown, rewards, cut, infos = example.decide(env, actions)
    assert {infos[agent]["steps"] for agent in example.AGENTS} == {example.SETTINGS.hold}
    assert rewards.tolist() == pytest.approx([-example.SETTINGS.hold / example.LIMIT] * 2)
    assert not cut
    assert shown.shape == (2, 9)
    for _ in range(example.LIMIT // example.SETTINGS.hold - 1):
        _, _, cut, _ = example.decide(env, torch.tensor([int(Behaviour.WAIT)] * 2))
    assert cut, "a pair that stands still is cut short by the time limit"
    assert not env.agents
    env.close()
