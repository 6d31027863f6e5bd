"""The variants in which k vectors vote, against fractions."""

from collections import Counter
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from khepera_forage.policies import KNearestImitator, NearestNeighbourImitator, distance
from khepera_forage.policies.features import encoded
from khepera_forage.task.states import StateVector

VECTORS = st.builds(
    StateVector,
    st.integers(0, 1),
    st.integers(0, 8),
    st.integers(0, 3),
    st.sampled_from([215, 216, 226, 255]),
    st.integers(0, 8),
)
EXPERIENCE = st.lists(st.tuples(VECTORS, st.integers(0, 9)), min_size=1, max_size=30)
DIAGONALS = st.sampled_from([1, 5, 138, 177])


def expected_shares(
    experience: list[tuple[StateVector, int]], query: StateVector, k: int, diagonal: int, weighting: str
) -> dict[int, Fraction]:
    """The share of each behaviour, one vector at a time."""
    away = sorted((distance(vector, query, diagonal), heard) for vector, heard in experience)
    reach = away[min(k, len(away)) - 1][0]
    votes: Counter[int] = Counter()
    for apart, heard in away:
        if apart <= reach:
            if weighting == "uniform":
                votes[heard] += 1
            elif away[0][0] == 0:
                votes[heard] += apart == 0
            else:
                votes[heard] += Fraction(1) / apart  # type: ignore[assignment]  # a Counter adds fractions too
    whole = sum(votes.values())
    return {heard: Fraction(count) / whole for heard, count in votes.items() if count}


@given(EXPERIENCE, VECTORS, st.integers(1, 12), DIAGONALS, st.sampled_from(["uniform", "distance"]))
def test_confidence_levels_equal_shares_in_fractions(
    experience: list[tuple[StateVector, int]], query: StateVector, k: int, diagonal: int, weighting: str
) -> None:
    rows, heard = zip(*experience, strict=True)
    learner = KNearestImitator(k, weighting, diagonal).fit(rows, heard)
    levels = learner.predict_proba([query])[0]
    expected = expected_shares(experience, query, k, diagonal, weighting)
    assert set(learner.classes_[levels > 0].tolist()) == set(expected)
    for label, level in zip(learner.classes_.tolist(), levels, strict=True):
        assert level == pytest.approx(float(expected.get(label, 0)), abs=1e-12)


@given(EXPERIENCE, st.lists(VECTORS, min_size=1, max_size=5), DIAGONALS)
def test_one_nearest_equals_the_imitator(
    experience: list[tuple[StateVector, int]], queries: list[StateVector], diagonal: int
) -> None:
    rows, heard = zip(*experience, strict=True)
    one = KNearestImitator(1, diagonal=diagonal).fit(rows, heard)
    imitator = NearestNeighbourImitator(diagonal, arithmetic="exact").fit(rows, heard)
    np.testing.assert_array_equal(one.predict_proba(queries), imitator.predict_proba(queries))


@given(VECTORS, VECTORS, DIAGONALS)
def test_encoded_vectors_have_the_distance_of_section_4_6_1(
    a: StateVector, b: StateVector, diagonal: int
) -> None:
    first, second = encoded([a, b], diagonal)
    assert np.abs(first - second).sum() == pytest.approx(float(distance(a, b, diagonal)), abs=1e-9)


@pytest.mark.parametrize("k", [0, -1, 2.0, True, None])
def test_k_out_of_range_is_refused(k: Any) -> None:
    with pytest.raises(ValueError, match=f"k is {k!r}; allowed: an integer, at least 1"):
        KNearestImitator(k=k).fit([[0, 1, 0, 215, 1]], [0])


def test_unknown_weighting_and_diagonal_are_refused() -> None:
    with pytest.raises(ValueError, match="weighting is 'votes'; allowed: uniform, distance"):
        KNearestImitator(weighting="votes").fit([[0, 1, 0, 215, 1]], [0])
    with pytest.raises(ValueError, match="diagonal is 0; allowed: an integer above 0"):
        KNearestImitator(diagonal=0).fit([[0, 1, 0, 215, 1]], [0])
