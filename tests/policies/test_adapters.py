"""Learners of all kinds become policies in one line."""

from typing import Any

import numpy as np
import pytest
from sklearn.naive_bayes import GaussianNB
from sklearn.svm import LinearSVC

from khepera_forage.policies import (
    AgentPolicy,
    ClassifierPolicy,
    ContiguousLabels,
    ModelPolicy,
    NearestNeighbourImitator,
    Teacher,
    as_policy,
)
from khepera_forage.task.states import Behaviour

X = np.array([[0, 90, 0, 215, 60], [0, 50, 0, 215, 18], [1, 48, 0, 255, 14], [1, 48, 1, 215, 14]] * 3)
Y = np.array([0, 2, 3, 7] * 3)


class Agent:
    """Takes no generator."""

    def act(self, observation: Any) -> np.int64:
        return np.int64(observation[0] + 6)


class Trained:
    """Has the interface of a stable-baselines3 model."""

    def predict(
        self, observation: Any, state: Any = None, episode_start: Any = None, deterministic: bool = False
    ) -> tuple[Any, None]:
        return np.array(4 if deterministic else 5), None


def test_learners_become_the_policy_of_their_kind() -> None:
    teacher, imitator = Teacher(), NearestNeighbourImitator().fit(X, Y)
    assert as_policy(teacher) is teacher
    assert as_policy(imitator) is imitator, "the imitator is a policy already"
    assert type(as_policy(GaussianNB().fit(X, Y))) is ClassifierPolicy
    assert type(as_policy(Trained())) is ModelPolicy
    assert type(as_policy(Agent())) is AgentPolicy


@pytest.mark.parametrize(
    "learner", [Teacher, GaussianNB, 7, None, LinearSVC().fit(X, Y), lambda observation: 3]
)
def test_objects_that_cannot_decide_are_refused(learner: Any) -> None:
    with pytest.raises(TypeError, match=r"learner is .*; allowed: an instance with act\(observation\), "):
        as_policy(learner)


def test_actions_that_are_no_behaviour_are_refused() -> None:
    with pytest.raises(
        ValueError, match=r"action of Agent is np.int64\(11\); allowed: a whole number from 0 to 10"
    ):
        as_policy(Agent()).act([5], None)


class Answer:
    """Gives one answer."""

    def __init__(self, answer: Any) -> None:
        self.answer = answer

    def act(self, observation: Any) -> Any:
        return self.answer


@pytest.mark.parametrize("answer", [2.5, np.float64(2.0), np.array([0.1, 0.9]), "2", True, None, -1])
def test_actions_that_are_no_whole_number_are_refused(answer: Any) -> None:
    with pytest.raises(ValueError, match=r"action of Answer is .*; allowed: a whole number from 0 to 10"):
        as_policy(Answer(answer)).act(X[0], None)


@pytest.mark.parametrize("answer", [2, np.int8(2), np.array(2), np.array([2]), np.array([[2]])])
def test_one_whole_number_in_any_form_is_a_behaviour(answer: Any) -> None:
    assert as_policy(Answer(answer)).act(X[0], None) is Behaviour.ORIENT_WITH_FOOD


class Probabilities:
    """A classifier with given probabilities."""

    classes_ = np.array([0, 2, 3])

    def __init__(self, *levels: float) -> None:
        self.levels = levels

    def predict_proba(self, rows: Any) -> Any:
        return np.array([self.levels] * len(rows))


@pytest.mark.parametrize(
    "levels", [(np.nan, 0.5, 0.5), (0.5, 0.5, 0.5), (-0.5, 1.0, 0.5), (0.5, 0.5), (0.0, 0.0, 0.0)]
)
def test_numbers_that_are_no_probabilities_are_refused(levels: tuple[float, ...]) -> None:
    policy = as_policy(Probabilities(*levels))
    with pytest.raises(
        ValueError, match=r"Probabilities predicts the probabilities .* of the classes .*; allowed"
    ):
        policy.act(X[0], np.random.default_rng(0))


def test_classifier_without_classes_or_with_other_columns_is_refused() -> None:
    with pytest.raises(ValueError, match="GaussianNB has no classes_; allowed: a fitted classifier"):
        as_policy(GaussianNB())
    with pytest.raises(ValueError, match="GaussianNB was fitted on 4 columns; allowed: 5"):
        as_policy(GaussianNB().fit(X[:, :4], Y))


class OnlyContiguous(GaussianNB):  # type: ignore[misc]  # scikit-learn is untyped
    """Refuses labels with gaps, as XGBoost does."""

    def fit(self, rows: Any, labels: Any) -> Any:
        if not np.array_equal(np.unique(labels), np.arange(len(np.unique(labels)))):
            raise ValueError("invalid classes")
        return super().fit(rows, labels)


def test_labels_with_gaps_are_learned_by_classifiers_that_know_none() -> None:
    with pytest.raises(ValueError, match="invalid classes"):
        OnlyContiguous().fit(X, Y)
    wrapped, plain = ContiguousLabels(OnlyContiguous()).fit(X, Y), GaussianNB().fit(X, Y)
    assert wrapped.classes_.tolist() == [0, 2, 3, 7]
    np.testing.assert_array_equal(wrapped.predict_proba(X), plain.predict_proba(X))
    np.testing.assert_array_equal(wrapped.predict(X), Y)
    rng, other = np.random.default_rng(1), np.random.default_rng(1)
    assert [as_policy(wrapped).act(row, rng) for row in X] == [as_policy(plain).act(row, other) for row in X]
    with pytest.raises(ValueError, match="ContiguousLabels was fitted on 4 columns"):
        as_policy(ContiguousLabels(OnlyContiguous()).fit(X[:, :4], Y))
