"""Recalls in kernels: the imitators, the counts and the rows are those of Python."""

from typing import Any

import numba
import numpy as np
import pytest
from scipy import stats

from khepera_forage.counter_rng import DRAW_POLICY, DRAWS, random_bits, upper
from khepera_forage.envs.compiled.vector_env import BehavioursVectorEnv
from khepera_forage.policies import NearestNeighbourImitator
from khepera_forage.policies.memories import memories_of
from khepera_forage.rollouts.compiled.recalls import TEACHER, UNIFORM, run_recalls, run_teacher
from khepera_forage.task.decisions import Decisions
from khepera_forage.task.states import Behaviour
from tests.compiled.decisions import DECISIONS
from tests.version_0_1 import V0_1

MIXED = {"pickable": 1, "pushable": 1, "poisonous": 1}
RECTANGLE: dict[str, Any] = {"foods": 2, "limit": 150, "food_types": MIXED}


class FixedNumber:
    """A generator whose next number is known."""

    def __init__(self, chance: float) -> None:
        self.chance = chance

    def random(self) -> float:
        return self.chance


def _teacher_records(food_types: Any) -> tuple[Any, Any]:
    """State vectors, shape (rounds, 8, 5), and the teacher's behaviours in the rectangle, shape (rounds, 8)."""
    env: Any = BehavioursVectorEnv(8, "rectangle", 2, 300, food_types=food_types)
    observation, infos = env.reset(seed=11)
    vectors, behaviours = [], []
    for _ in range(250):
        vectors.append(_state_vectors(observation))
        behaviours.append(infos["correct_behaviour"])
        observation, _, _, _, infos = env.step(behaviours[-1])
    return np.array(vectors), np.array(behaviours)


@pytest.fixture(scope="module")
def experience() -> list[tuple[Any, Any]]:
    """Three memories of one to three forages of the teacher; one behaviour in ten is replaced."""
    vectors, heard = _teacher_records(MIXED)
    rng = np.random.default_rng(0)
    heard = np.where(rng.random(heard.shape) < 0.1, rng.integers(0, 10, heard.shape), heard)
    worlds = ([0], [1, 2], [3, 4, 5])
    return [(vectors[:, some].reshape(-1, 5), heard[:, some].ravel()) for some in worlds]


def _state_vectors(observation: Any) -> Any:
    names = ("object_presence", "robot_home_distance", "food_type", "arms_height", "robot_food_distance")
    return np.column_stack([np.asarray(observation[name]).ravel() for name in names])


@pytest.mark.parametrize(
    "decisions", [Decisions(), Decisions(close_to_food=40), DECISIONS[2]], ids=("default", "changed", "readings")
)
def test_a_recall_is_that_of_the_imitator_step_by_step(experience: Any, decisions: Decisions) -> None:
    """The environment stepped from Python, the imitator drawing with the kernel's numbers: the same counts."""
    worlds, seed = 30, 4
    which = np.arange(worlds) % 3
    kernel = run_recalls("rectangle", memories_of(experience), which, seed, decisions=decisions, **RECTANGLE)
    env: Any = BehavioursVectorEnv(worlds, "rectangle", decisions=decisions, **RECTANGLE)
    observation, infos = env.reset(seed=seed)
    batch = env.batch
    arithmetic = decisions.distance_arithmetic
    imitators = [
        NearestNeighbourImitator(env.get_attr("diagonal")[0], arithmetic=arithmetic).fit(*part) for part in experience
    ]
    over = np.zeros(worlds, np.bool_)
    rounds, wrong = np.zeros((2, worlds, 10), np.int64)
    without_food, ties, conflicts = np.zeros((3, worlds), np.int64)
    while not over.all():
        robots = batch.worlds.robots[:, 0]
        chances = [
            upper(random_bits(key, number * DRAWS + DRAW_POLICY))
            for key, number in zip(robots["key"].tolist(), robots["round"].tolist(), strict=True)
        ]
        actions = np.zeros(worlds, np.int64)
        rows = _state_vectors(observation)
        for i in np.flatnonzero(~over).tolist():
            neighbours = imitators[which[i]].neighbours(rows[i])
            rng: Any = FixedNumber(chances[i])
            actions[i] = neighbours.draw(rng)
            right = infos["correct_behaviour"][i]
            rounds[i, right] += 1
            ties[i] += neighbours.tie
            conflicts[i] += neighbours.conflict
            if actions[i] != right:
                wrong[i, right] += 1
                far = batch.foragers.vector.robot_food_distance[i] > decisions.close_to_food
                without_food[i] += actions[i] == Behaviour.ORIENT_WITH_FOOD and far
        observation, _, terminated, truncated, infos = env.step(actions)
        for i in np.flatnonzero((terminated | truncated) & ~over).tolist():
            over[i] = True
            for name in ("score", "penalty", "steps", "correct", "delivered", "poison_home"):
                assert infos[name][i] == getattr(kernel, name)[i], name
    assert (rounds == kernel.rounds_by_state).all()
    assert (wrong == kernel.wrong_by_state).all()
    for name, counts in (("orient_without_food", without_food), ("ties", ties), ("conflicts", conflicts)):
        assert (counts == getattr(kernel, name)).all(), name
        assert counts.any(), name
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
    assert not teacher.wrong_by_state.any()
    assert (teacher.rounds_by_state.sum(axis=1) == teacher.steps).all()
    same = run_recalls("corridor", None, np.full(300, TEACHER), 2)
    for a, b in zip(teacher, same, strict=True):
        assert (a == b).all()
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
