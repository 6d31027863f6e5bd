"""The imitator as a classifier: parameters, labels, copies."""

import copy
import pickle
from typing import Any

import numpy as np
import pytest
from sklearn.exceptions import NotFittedError

from khepera_forage.policies import NearestNeighbourImitator
from khepera_forage.task.states import Behaviour

X = np.array([[0, 90, 0, 215, 60], [0, 50, 0, 215, 18], [1, 48, 0, 255, 14], [1, 48, 1, 215, 14]])
Y = np.array([0, 2, 3, 7])


@pytest.mark.parametrize("diagonal", [0, -138, 138.0, 137.9, "138", True])
def test_diagonal_out_of_range_is_refused(diagonal: Any) -> None:
    with pytest.raises(ValueError, match=f"diagonal is {diagonal!r}; allowed: an integer above 0, in pixels"):
        NearestNeighbourImitator(diagonal=diagonal).fit(X, Y)


@pytest.mark.parametrize("threshold", [-0.1, float("inf"), float("nan"), "0.1", None])
def test_threshold_out_of_range_is_refused(threshold: Any) -> None:
    with pytest.raises(ValueError, match=f"threshold is {threshold!r}; allowed: a finite number, at least 0"):
        NearestNeighbourImitator(threshold=threshold).fit(X, Y)


def test_imitator_without_experience_raises() -> None:
    with pytest.raises(NotFittedError):
        NearestNeighbourImitator().act(X[0], np.random.default_rng())
    with pytest.raises(NotFittedError):
        NearestNeighbourImitator().neighbours(X[0])


def test_act_refuses_rows_that_are_no_state_vectors() -> None:
    imitator = NearestNeighbourImitator().fit(X[:, :3], Y)
    np.testing.assert_array_equal(imitator.predict(X[:, :3]), Y)
    with pytest.raises(ValueError, match="learned from rows of 3 columns; allowed: 5"):
        imitator.act(X[0], np.random.default_rng())


@pytest.mark.parametrize("labels", [["a", "b", "c", "d"], [0, 2, 3, 11]])
def test_act_refuses_labels_that_are_no_behaviours(labels: list[Any]) -> None:
    imitator = NearestNeighbourImitator().fit(X, labels)
    assert imitator.predict(X).tolist() == labels
    with pytest.raises(ValueError, match=r"labels learned are .*; allowed: behaviours, 0 to 10"):
        imitator.act(X[0], np.random.default_rng())


def test_labels_outside_classes_are_refused() -> None:
    imitator = NearestNeighbourImitator()
    with pytest.raises(
        ValueError, match=r"labels are \[0, 2, 3, 7\]; allowed: those among classes, \[0, 2\]"
    ):
        imitator.partial_fit(X, Y, classes=[0, 2])
    imitator.partial_fit(X[:1], Y[:1], classes=range(10))
    assert imitator.classes_.tolist() == list(range(10))
    assert imitator.predict_proba(X[:1]).tolist() == [[1.0] + [0.0] * 9]


@pytest.mark.parametrize("again", [lambda i: pickle.loads(pickle.dumps(i)), copy.deepcopy])
def test_copy_learns_independently(again: Any) -> None:
    imitator = NearestNeighbourImitator().fit(X, Y)
    imitator.act(X[0], np.random.default_rng())
    twin = again(imitator)
    twin.partial_fit(np.repeat(X[:1], 4, axis=0), [7] * 4)  # neither a new row nor a new class
    assert twin.neighbours(X[0]).votes == ((Behaviour.SEARCH_FOR_FOOD, 1), (Behaviour.GO_HOME, 4))
    twin.partial_fit([[0, 90, 0, 215, 61]], [5])
    assert twin.neighbours((0, 90, 0, 215, 62)).votes == ((Behaviour.PUSH_FOOD, 1),)
    assert imitator.neighbours(X[0]).votes == ((Behaviour.SEARCH_FOR_FOOD, 1),)
