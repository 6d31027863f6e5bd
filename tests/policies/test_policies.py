"""All policies: their contract, the same outcome for the same seed, pickling, and what parameters are allowed."""

import copy
import pickle
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from sklearn.tree import DecisionTreeClassifier
from sklearn.utils.estimator_checks import parametrize_with_checks

from khepera_forage.policies import (
    ClassifierPolicy,
    GrowingMemory,
    KNearestImitator,
    ModelPolicy,
    NearestNeighbourImitator,
    Policy,
    Teacher,
    UniformPolicy,
    WeightedImitator,
    as_policy,
    state_vector_of,
)
from khepera_forage.policies.learners import LEARNERS, OfflineImitation
from khepera_forage.task.decisions import Decisions
from khepera_forage.task.states import Behaviour, StateVector, behaviour_for, classify

IMITATING = {name: learner for name, learner in LEARNERS.items() if isinstance(learner, OfflineImitation)}
VECTOR = (0, 50, 0, 215, 18)


def experience(seed: int, count: int = 300) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """State vectors of a forage and the teacher's behaviour for each."""
    rng = np.random.default_rng(seed)
    held, arms = rng.integers(0, 3, count), rng.choice([215, 235, 255], count)
    homes, foods = rng.integers(5, 100, count), rng.integers(0, 60, count)
    rows = np.column_stack((held > 0, homes, held // 2, arms, foods))
    decisions = Decisions().values()
    return rows, np.array([behaviour_for(classify(state_vector_of(row), 20, decisions)) for row in rows])


class Constant:
    """Stands for a model of stable-baselines3, which returns an array and a state."""

    def predict(self, observation: Any, *, deterministic: bool) -> tuple[NDArray[np.int64], None]:
        return np.array(Behaviour.GO_HOME if deterministic else Behaviour.AVOID_HOME), None


POLICIES: dict[str, Callable[[], Policy]] = {
    **{name: partial(learner.learn, *experience(0), seed=3) for name, learner in IMITATING.items()},
    "teacher": lambda: Teacher(18),
    "best of classifier": lambda: ClassifierPolicy(
        DecisionTreeClassifier(random_state=1).fit(*experience(0)), sample=False
    ),
    "model": lambda: as_policy(Constant()),
    "uniform": UniformPolicy,
}


@pytest.mark.parametrize("name", POLICIES)
def test_same_seed_gives_the_same_behaviours_also_pickled(name: str) -> None:
    rows = experience(1, 60)[0]
    shown: list[Any] = [
        *rows,
        *(StateVector(*row)._asdict() for row in rows),
        *(np.append(row, (10, 0)) for row in rows),
    ]
    before = copy.deepcopy(shown)
    once, decisions = POLICIES[name](), []
    for policy in (once, once, POLICIES[name](), pickle.loads(pickle.dumps(once))):
        rng = np.random.default_rng(5)
        decisions.append([int(policy.act(observation, rng)) for observation in shown])
    assert decisions[1:] == decisions[:1] * 3
    assert all(0 <= decision <= 10 for decision in decisions[0])
    np.testing.assert_equal(shown, before)


@pytest.mark.parametrize("name", IMITATING)
def test_learner_agrees_with_the_teacher(name: str) -> None:
    """Far above chance on new state vectors: the teacher's most frequent behaviour is below a half."""
    policy = IMITATING[name].learn(*experience(0), seed=1, groups=np.arange(300) // 30)
    rows, said = experience(2, 200)
    rng = np.random.default_rng(4)
    agreed = np.mean([policy.act(row, rng) == word for row, word in zip(rows, said, strict=True)])
    assert np.bincount(said).max() / 200 < 0.5
    assert agreed > 0.65


@pytest.mark.parametrize(
    "make", [*map(POLICIES.get, ("imitator", "tree", "uniform")), lambda: ModelPolicy(Constant(), sample=True)]
)
@pytest.mark.parametrize("rng", [None, 7, np.random.RandomState(7)])
def test_drawing_without_a_generator_is_refused(make: Any, rng: Any) -> None:
    with pytest.raises(TypeError, match=r"rng is .*; allowed: a numpy\.random\.Generator"):
        make().act(VECTOR, rng)


@parametrize_with_checks(  # type: ignore[untyped-decorator]
    [
        NearestNeighbourImitator(),
        NearestNeighbourImitator(diagonal=177, arithmetic="32-bit floats"),
        KNearestImitator(k=3, weighting="distance"),
        WeightedImitator(random_state=0),
        GrowingMemory(),
    ]
)
def test_classifiers_pass_check_estimator(estimator: Any, check: Any) -> None:
    check(estimator)


DIAGONALS: tuple[Any, ...] = (0, 138.0, True)
THRESHOLDS: tuple[Any, ...] = (-0.1, float("inf"), float("nan"), None)
SHARES: tuple[tuple[str, Any], ...] = (
    *(("reach", -1), ("reach", float("inf")), ("habituation", 0), ("recovery", 1.1)),
    *(("forgetting", -0.1), ("moving", "1")),
)
FLOATS: dict[str, Any] = {"threshold": 0.1, "arithmetic": "32-bit floats"}
WRONG: list[tuple[Any, dict[str, Any], str]] = [
    *((NearestNeighbourImitator, {"diagonal": d}, f"diagonal is {d!r}; allowed: an integer above 0, in pixels")
      for d in DIAGONALS),
    *((NearestNeighbourImitator, {"threshold": t}, f"threshold is {t!r}; allowed: a finite number, at least 0")
      for t in THRESHOLDS),
    (NearestNeighbourImitator, {"arithmetic": "16-bit"}, "arithmetic is '16-bit'; allowed: 'exact', '32-bit floats', "),
    (NearestNeighbourImitator, FLOATS, r"threshold is 0\.1 with 32-bit floats; allowed: 0, or exact"),
    *((KNearestImitator, {"k": k}, f"k is {k!r}; allowed: an integer, at least 1") for k in (0, 2.0, True)),
    (KNearestImitator, {"weighting": "votes"}, "weighting is 'votes'; allowed: uniform, distance"),
    (WeightedImitator, {"weights": (1, 2)}, r"weights are \(1, 2\); allowed: 5 whole numbers, not all 0"),
    (WeightedImitator, {"weights": (0,) * 5}, r"weights are \(0, 0, 0, 0, 0\); allowed"),
    (WeightedImitator, {"weights": (1, -1, 1, 1, 1)}, "weights are .*; allowed: whole numbers, at least 0"),
    (WeightedImitator, {"choices": (0.5, 1)}, "choices are .*; allowed: whole numbers, at least 0"),
    *((GrowingMemory, {name: value}, f"{name} is {value!r}; allowed") for name, value in SHARES),
]  # fmt: skip


@pytest.mark.parametrize(("classifier", "parameters", "message"), WRONG)
def test_parameters_out_of_range_are_refused(classifier: Any, parameters: dict[str, Any], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        classifier(**parameters).fit([VECTOR, (0, 90, 0, 215, 60)], [2, 0])


def test_teacher_decides_by_the_state_vector_and_waits_for_a_separated_learner() -> None:
    teacher = Teacher(home_radius=20)
    for row, said in zip(*experience(3), strict=True):
        assert teacher.act(row) is teacher.act([*row.tolist(), 3, 0]) is Behaviour(said)
        assert teacher.act([*row.tolist(), 3, 1]) is Behaviour.WAIT


def test_teacher_needs_an_environment_or_the_radius_of_its_home() -> None:
    with pytest.raises(ValueError, match=r"Teacher\(\) knows no environment; allowed: Teacher.of\(env\)"):
        Teacher().act(VECTOR)
    with pytest.raises(ValueError, match="home_radius is 0 pixels; allowed: above 0"):
        Teacher(home_radius=0)
