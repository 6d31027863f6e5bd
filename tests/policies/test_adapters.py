"""One line makes a forager of whatever decides."""

import pickle
from typing import Any

import numpy as np
import pytest
from sklearn.naive_bayes import GaussianNB
from sklearn.svm import LinearSVC

from khepera_forage.policies import (
    AgentPolicy,
    ClassifierPolicy,
    ModelPolicy,
    NearestNeighbourImitator,
    Teacher,
    as_policy,
)
from khepera_forage.policies.adapters import Model
from khepera_forage.task.states import Behaviour

X = np.array([[0, 90, 0, 215, 60], [0, 50, 0, 215, 18], [1, 48, 0, 255, 14], [1, 48, 1, 215, 14]] * 3)
Y = np.array([0, 2, 3, 7] * 3)


class Agent:
    """Has no use for a generator."""

    def act(self, observation: Any) -> np.int64:
        return np.int64(observation[0] + 6)


class Trained:
    """As models of stable-baselines3 are."""

    def predict(
        self, observation: Any, state: Any = None, episode_start: Any = None, deterministic: bool = False
    ) -> tuple[Any, None]:
        return np.array(4 if deterministic else 5), None


def test_what_each_becomes() -> None:
    teacher, imitator = Teacher(), NearestNeighbourImitator().fit(X, Y)
    assert as_policy(teacher) is teacher
    assert as_policy(imitator) is imitator, "it draws by itself"
    assert type(as_policy(GaussianNB().fit(X, Y))) is ClassifierPolicy
    assert type(as_policy(Trained())) is ModelPolicy
    assert type(as_policy(Agent())) is AgentPolicy


def test_and_what_it_then_does() -> None:
    rng = np.random.default_rng(0)
    assert as_policy(Agent()).act(X[2], rng) is Behaviour.GO_HOME
    assert as_policy(Trained()).act(X[2], rng) is Behaviour.PICK_UP_FOOD
    assert as_policy(GaussianNB().fit(X, Y)).act(X[2], rng) is Behaviour.EXPLORE_FOOD


@pytest.mark.parametrize(
    "learner", [Teacher, GaussianNB, 7, None, LinearSVC().fit(X, Y), lambda observation: 3]
)
def test_what_is_no_learner(learner: Any) -> None:
    with pytest.raises(TypeError, match=r"learner is .*; allowed: an instance with act\(observation\), "):
        as_policy(learner)


def test_an_action_that_is_no_behaviour() -> None:
    with pytest.raises(ValueError, match="11 is not a valid Behaviour"):
        as_policy(Agent()).act([5], None)


class Counting(GaussianNB):  # type: ignore[misc]  # scikit-learn is untyped
    """Counts how often it is asked."""

    asked = 0

    def predict_proba(self, rows: Any) -> Any:
        self.asked += 1
        return super().predict_proba(rows)


def test_what_is_remembered_is_what_would_be_said() -> None:
    classifier = Counting().fit(X, Y)
    forgetful, remembering = ClassifierPolicy(classifier), ClassifierPolicy(classifier, remember=True)
    rng, other = np.random.default_rng(1), np.random.default_rng(1)
    assert [forgetful.act(row, rng) for row in X] == [remembering.act(row, other) for row in X]
    assert classifier.asked == len(X) + 4
    twin = pickle.loads(pickle.dumps(remembering))
    assert twin.act(X[0], np.random.default_rng(0)) == remembering.act(X[0], np.random.default_rng(0))


def test_a_memory_that_is_full_starts_over(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("khepera_forage.policies.adapters.MEMO_SIZE", 2)
    policy = ClassifierPolicy(GaussianNB().fit(X, Y), remember=True)
    decisions = [policy.act(row, np.random.default_rng(0)) for row in X]
    assert decisions[:4] == decisions[4:8]
    assert len(policy._memo) <= 2


def test_protocols_are_what_they_say() -> None:
    model: Model = Trained()
    assert ModelPolicy(model).act(X[0]) is Behaviour.PICK_UP_FOOD
