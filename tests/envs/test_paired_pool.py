"""Paired training in several arenas, given as `Arena` objects or by name."""

from pathlib import Path

import pytest

from khepera_forage.envs import paired_arenas_v1
from khepera_forage.envs.arguments import checked_arena
from khepera_forage.envs.training import TrainingEnv
from khepera_forage.experience import Experience
from khepera_forage.rollouts.training import IncompleteTrainingError, train
from khepera_forage.sim.arena import Arena
from khepera_forage.task.decisions import Decisions
from tests.arenas import HALL

NAMES: list[Arena | str] = ["corridor", HALL, "rectangle"]


def test_names_and_arenas_make_the_same_pool() -> None:
    decisions = Decisions(home_to_wall=100.0)
    arenas = [checked_arena(given, decisions) for given in NAMES]
    one, other = TrainingEnv(arena=NAMES, decisions=decisions), TrainingEnv(arena=arenas, decisions=decisions)
    seen = set()
    for seed in range(8):
        one.reset(seed=seed)
        other.reset(seed=seed)
        assert one.arenas == other.arenas
        assert one.arena_of(seed) == one.arenas[0]
        assert one.observe("learner_0").tolist() == other.observe("learner_0").tolist()
        seen.add(one.arenas[0].name)
    assert seen == {"corridor", "hall", "rectangle"}
    assert one.observation_space("teacher_0").high[1] == one.observation_space("learner_0").high[4] == 177


def test_experience_names_the_arena_of_its_attempt(tmp_path: Path) -> None:
    env, names = TrainingEnv(arena=NAMES), set()
    for seed in range(4):
        path = tmp_path / f"g{seed}.csv"
        try:
            experience, _ = train(env, seed, path=path, attempts=3)
        except IncompleteTrainingError:
            continue
        assert Experience.load(path) == experience
        assert experience.seed is not None
        assert experience.arena == env.arena_of(experience.seed).name == env.arenas[0].name
        names.add(experience.arena)
    assert len(names) > 1


def test_several_arenas_need_a_number_of_rounds() -> None:
    env = paired_arenas_v1.raw_env(arena=["t_maze", "doors"], max_cycles=2500)
    assert env.metadata["name"] == "paired_arenas_v1"
    env.reset(seed=0)
    assert env.arenas[0].name in ("t_maze", "doors")
    with pytest.raises(ValueError, match="max_cycles is None; allowed with several arenas: a whole number"):
        paired_arenas_v1.raw_env(arena=["t_maze", "doors"])
