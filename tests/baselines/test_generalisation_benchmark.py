"""`benchmarks/generalisation.py` with the reinforcement learners: lines beside those of the imitators."""

from dataclasses import replace
from pathlib import Path

import gymnasium as gym
import numpy as np
import pytest
from arena_generalisation.contestants import Contestant, recalled
from arena_generalisation.learner_replication import LearnerReplication
from arena_generalisation.recall_arenas import named_arenas
from arena_generalisation.reinforcement import ModelClassifier, reinforcement_learners, varied_envs
from arena_generalisation.rows import ArenaRecalls
from arena_generalisation.size import Size
from arena_generalisation.trainings import CORRIDOR, VARIED, training_arenas

from khepera_forage.policies.learners import FromSteps
from khepera_forage.rollouts.recall import recall
from khepera_forage.rollouts.reinforcement import Trained, reinforce
from tests.benchmarks.running import is_picture, quick, read

pytest.importorskip("numba")

DIFFICULTIES = ("easy", "medium")
SIZE = Size(2, 1, ("corridor", "mixed_foods"), DIFFICULTIES, 300, 120)
SMALL = {"PPO": {"n_steps": 16, "batch_size": 32}, "DQN": {"learning_starts": 20}}
LEARNERS = reinforcement_learners()


def small(name: str) -> FromSteps:
    """A learner for a short training."""
    learner = LEARNERS[name]
    return replace(learner, worlds=6, settings={**learner.settings, **SMALL[learner.algorithm]})


def rows_of(name: str, number: int = 0) -> list[ArenaRecalls]:
    return LearnerReplication(0, number, SIZE, name, small(name)).run()


def varied(name: str) -> Trained:
    learner, arenas = small(name), training_arenas(0, DIFFICULTIES)
    (trained,) = reinforce(learner, [300], 0, varied_envs(arenas), learner.worlds)
    return trained


def test_only_learners_on_behaviours_take_part() -> None:
    assert {"ppo", "dqn"} <= set(LEARNERS)
    assert not any(learner.wheels for learner in LEARNERS.values())


@pytest.mark.parametrize("name", ["ppo", "dqn"])
def test_learner_forages_in_every_arena_after_both_trainings(name: str) -> None:
    rows = rows_of(name)
    assert {row.learner for row in rows} == {name}
    assert len({row.arena for row in rows}) == 4
    for training in (CORRIDOR, VARIED):
        own = [row for row in rows if row.training == training]
        assert [row.group for row in own] == ["thesis", "named", *DIFFICULTIES]
        assert [row.recalls for row in own] == [2] * 4
        assert all(0 < row.steps <= 240 and row.delivered <= row.foods for row in own)
    assert rows_of(name) == rows, "the same seed, the same rows"
    others = rows_of(name, number=1)
    assert [row.arena for row in others if row.group in DIFFICULTIES] != [
        row.arena for row in rows if row.group in DIFFICULTIES
    ]


@pytest.mark.parametrize("name", ["ppo", "dqn"])
def test_training_in_varied_arenas_takes_as_many_steps(name: str) -> None:
    (corridor,) = reinforce(small(name), [300], 0)
    assert varied(name).steps == corridor.steps >= 300


@pytest.mark.parametrize("sample", [False, True])
def test_batch_of_recalls_is_what_the_policy_does_alone(sample: bool) -> None:
    """Behaviours of DQN are certain. Those of PPO are drawn: here with probabilities that make them certain, too."""
    policy = varied("ppo" if sample else "dqn").policy
    assert policy.hold == 5
    if sample:
        with_bias = policy.model.policy.action_net.bias  # type: ignore[attr-defined]
        with_bias.data[3] += 100.0
    (arena,) = named_arenas(["corridor"])
    seeds, limit = [3, 1, 4], 60
    contestant = Contestant("dqn", VARIED, ModelClassifier(policy), policy.sample, hold=policy.hold)
    rng = np.random.default_rng(0)
    (batch,), table = recalled([arena.limited(limit)], [contestant], seeds, rng)
    env = gym.make("khepera_forage/Corridor-v1", limit=limit, backend="compiled")
    rows = [recall(env, policy, seed) for seed in seeds]
    assert batch.score.tolist() == pytest.approx([row.score for row in rows])
    assert batch.steps.tolist() == [row.steps for row in rows]
    assert batch.delivered.tolist() == [row.delivered for row in rows]
    *_, times = table.visited(0)
    assert times.sum() == sum(-(-row.steps // policy.hold) for row in rows), "a decision every five rounds"


def test_benchmark_has_lines_of_reinforcement_learners(tmp_path: Path) -> None:
    out = tmp_path / "generalisation"
    quick("generalisation", out, "--jobs", "1", notes=tmp_path / "pictures")
    for name in ("table_arenas.csv", "table_difficulty.csv"):
        lines = [(row["learner"], row["trained in"]) for row in read(out / name)]
        for learner in LEARNERS.values():
            assert [(learner.title, CORRIDOR), (learner.title, VARIED)] == [
                line for line in lines if line[0] == learner.title
            ]
    foods: dict[str, set[str]] = {}
    for row in read(out / "recalls.csv"):
        foods.setdefault(row["arena"], set()).add(row["foods"])
    assert all(len(found) == 1 for found in foods.values()), "the same food as for all other learners"
    page = (out / "generalisation.md").read_text(encoding="utf-8")
    assert "trained once in the corridor for 1,000 steps," in page
    assert "left out:" not in page
    faults = (tmp_path / "pictures").read_text(encoding="utf-8").splitlines()
    assert [line for line in faults if not line.endswith("\t")] == []
    assert is_picture(out / "generalisation_difficulty.png")
