"""Recalls in kernels: the imitators, the counts and the rows are those of Python."""

from types import SimpleNamespace
from typing import Any

import numba
import numpy as np
import pytest
from scipy import stats

from khepera_forage.counter_rng import DRAW_POLICY, DRAWS, key_of, random_bits, upper
from khepera_forage.policies import NearestNeighbourImitator
from khepera_forage.policies.memories import memories_of
from khepera_forage.policies.policy import HEARD
from khepera_forage.rollouts.compiled.recalls import UNIFORM, recall_rows, run_recalls, run_teacher
from khepera_forage.rollouts.compiled.training import train_learners
from khepera_forage.rollouts.recall import recall, recall_env
from khepera_forage.task.decisions import Decisions
from tests.compiled.decisions import DECISIONS
from tests.version_0_1 import V0_1

MIXED = {"pickable": 1, "pushable": 1, "poisonous": 1}
RECTANGLE: dict[str, Any] = {"foods": 2, "limit": 150, "food_types": MIXED}


@pytest.fixture(scope="module")
def experience() -> list[tuple[Any, Any]]:
    """Three memories, of one to three training episodes; one behaviour in ten is replaced."""
    trained, rng = train_learners(3, seed=11, arena="rectangle", food_types=MIXED, episodes=3), np.random.default_rng(0)
    memories = []
    for learner in range(3):
        rows = np.concatenate([trained.vectors_of(learner, episode) for episode in range(learner + 1)])
        heard = np.where(rng.random(len(rows)) < 0.1, rng.integers(0, 10, len(rows)), rows[:, HEARD])
        memories.append((rows[:, :HEARD], heard))
    return memories


class KernelDraws:
    """An imitator that draws the random numbers of the kernel: recall i has those of the environment's seed."""

    def __init__(self, imitator: NearestNeighbourImitator, env: Any, seed: int) -> None:
        self.act, self.imitator, self.env, self.key = imitator.act, imitator, env, key_of(seed)

    def neighbours(self, observation: Any) -> Any:
        found = self.imitator.neighbours(observation)
        number = int(self.env.world.robots[0].record["round"])
        chance = upper(random_bits(self.key, number * DRAWS + DRAW_POLICY))
        rng: Any = SimpleNamespace(random=lambda: chance)
        return SimpleNamespace(tie=found.tie, conflict=found.conflict, draw=lambda _: found.draw(rng))


@pytest.mark.parametrize(
    "decisions", [Decisions(), Decisions(close_to_food=40), DECISIONS[2]], ids=("default", "changed", "readings")
)
def test_rows_of_kernels_are_those_of_recalls_step_by_step(experience: Any, decisions: Decisions) -> None:
    seeds, which = list(range(4, 34)), np.arange(30) % 3
    kernel = run_recalls("rectangle", memories_of(experience), which, 4, decisions=decisions, **RECTANGLE)
    env = recall_env("rectangle", decisions=decisions, backend="compiled", **RECTANGLE)
    arithmetic = decisions.distance_arithmetic
    imitators = [NearestNeighbourImitator(env.diagonal, arithmetic=arithmetic).fit(*part) for part in experience]
    rows = [recall(env, KernelDraws(imitators[i], env, seed), seed) for i, seed in zip(which, seeds, strict=True)]
    names = ("replication", "episodes", "file_id", "recall", "learner", "noise", "experience_size", "limit")
    about = {name: getattr(rows[0], name) for name in names}
    assert recall_rows(kernel, env.arena, {"seed": seeds}, decisions, **about) == rows
    for name in ("orient_without_food", "ties", "conflicts"):
        assert getattr(kernel, name).any(), name
    assert kernel.delivered.any() or decisions == DECISIONS[2], "not every reading lets an imitator forage"


def test_a_recall_does_not_depend_on_the_other_recalls(experience: Any) -> None:
    """Neither their number, nor the threads, nor the other imitators and the order of their memories matter."""
    which = np.arange(300) % 5 - 2
    whole = run_recalls("rectangle", memories_of(experience), which, 3, **RECTANGLE)
    threads = numba.get_num_threads()
    numba.set_num_threads(1)
    others = [run_recalls("rectangle", memories_of(experience), which, 3, **RECTANGLE)]
    numba.set_num_threads(threads)
    turned = np.where(which >= 0, 2 - which, which)
    others.append(run_recalls("rectangle", memories_of(experience[::-1]), turned[:170], 3, **RECTANGLE))
    for other in others:
        for a, b in zip(whole, other, strict=True):
            assert (a[: len(b)] == b).all()


def test_teacher_is_always_right_and_chance_one_time_in_ten() -> None:
    teacher = run_teacher("corridor", 300, 2)
    assert (teacher.correct == teacher.steps).all()
    assert (teacher.rounds_by_state.sum(axis=1) == teacher.steps).all()
    chance = run_recalls("corridor", None, np.full(300, UNIFORM), 2)
    assert (chance.start == teacher.start).all()
    right, steps = int(chance.correct.sum()), int(chance.steps.sum())
    assert stats.binomtest(right, steps, 0.1).pvalue > 1e-3
    assert not chance.ties.any()
    in_0_1 = run_teacher("corridor", 4000, 7, decisions=V0_1)
    assert in_0_1.delivered.mean() > 0.998
    assert in_0_1.score.mean() > 99.9


@pytest.mark.parametrize(
    ("which", "message"),
    [
        ([0, 1], r"memory_of_episode has 1; allowed: -3 \(teacher without orienting\), -2 \(uniform\)"),
        ([-4], "memory_of_episode has -4"),
        ([0.5], r"memory_of_episode is \[0.5\]"),
        ([], r"memory_of_episode is \[\]"),
    ],
)
def test_bad_policies_are_quoted(which: Any, message: str) -> None:
    memories = memories_of([([(0, 50, 0, 215, 40)], [0])])
    with pytest.raises(ValueError, match=message):
        run_recalls("corridor", memories, which)
