"""What all policies have in common, and how behaviours are drawn."""

import math
import pickle
from collections import Counter
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from sklearn.naive_bayes import GaussianNB
from sklearn.tree import DecisionTreeClassifier

from khepera_forage.policies import (
    ClassifierPolicy,
    Listener,
    ModelPolicy,
    NearestNeighbourImitator,
    Policy,
    Teacher,
    UniformPolicy,
)
from khepera_forage.task.states import Behaviour, StateVector

QUERY = StateVector(0, 50, 0, 215, 18)
# The example of section 4.6.2: of five equally near vectors, four say x and one says y.
X = np.array(
    [[0, 50, 0, 215, 20]] * 2 + [[0, 50, 0, 215, 16]] * 2 + [[0, 52, 0, 215, 18], [0, 90, 0, 215, 60]]
)
Y = np.array([2, 2, 2, 2, 1, 0])


class Constant:
    """Stands for a model of stable-baselines3, which returns an array and a state."""

    def predict(self, observation: Any, *, deterministic: bool) -> tuple[NDArray[np.int64], None]:
        return np.array(Behaviour.GO_HOME if deterministic else Behaviour.AVOID_HOME), None


POLICIES: dict[str, Policy] = {
    "teacher": Teacher(18),
    "imitator": NearestNeighbourImitator().fit(X, Y),
    "classifier": ClassifierPolicy(GaussianNB().fit(X, Y)),
    "best of classifier": ClassifierPolicy(DecisionTreeClassifier(random_state=1).fit(X, Y), sample=False),
    "model": ModelPolicy(Constant()),
    "uniform": UniformPolicy(),
    "listener": Listener(),
}


@pytest.mark.parametrize("name", POLICIES)
def test_same_generator_gives_the_same_decisions(name: str) -> None:
    policy = POLICIES[name]
    observation: NDArray[np.int32] = np.array([*QUERY, Behaviour.GO_HOME, 0], np.int32)
    before = observation.copy()
    first, second = np.random.default_rng(5), np.random.default_rng(5)
    decisions = [policy.act(observation, first) for _ in range(20)]
    assert decisions == [policy.act(observation, second) for _ in range(20)]
    assert set(decisions) <= set(range(11))
    np.testing.assert_array_equal(observation, before)
    twin = pickle.loads(pickle.dumps(policy))
    third = np.random.default_rng(5)
    assert decisions == [twin.act(observation, third) for _ in range(20)]


@pytest.mark.parametrize("name", ["imitator", "classifier", "uniform"])
@pytest.mark.parametrize("rng", [None, 7, np.random.RandomState(7)])
def test_drawing_without_a_generator_is_refused(name: str, rng: Any) -> None:
    with pytest.raises(TypeError, match=r"rng is .*; allowed: a numpy\.random\.Generator"):
        POLICIES[name].act(QUERY, rng)


def check_frequencies(counts: Counter[int], levels: dict[Behaviour, float], draws: int) -> None:
    assert set(counts) == set(levels)
    for behaviour, level in levels.items():
        # Five standard deviations of the binomial distribution.
        bound = 5 * math.sqrt(draws * level * (1 - level)) + 1e-9
        assert abs(counts[behaviour] - draws * level) <= bound


def test_behaviours_are_drawn_with_their_confidence_levels() -> None:
    imitator = NearestNeighbourImitator().fit(X, Y)
    assert imitator.confidence_levels(QUERY) == {Behaviour.ORIENT_WITH_FOOD: 0.8, Behaviour.MOVE_SLOWLY: 0.2}
    rng = np.random.default_rng(11)
    counts = Counter(int(imitator.act(QUERY, rng)) for _ in range(20_000))
    check_frequencies(counts, imitator.confidence_levels(QUERY), 20_000)
