"""The imitator over many vectors: every tie, against brute force in whole numbers."""

from collections import Counter
from fractions import Fraction

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from khepera_forage.policies import NearestNeighbourImitator
from khepera_forage.task.states import Behaviour

Rows = NDArray[np.int64]


def vectors(rng: np.random.Generator, count: int, spread: int, arms: list[int]) -> Rows:
    """State vectors of any kind: crowded with a small spread, far apart with a large one."""
    rows = np.empty((count, 5), np.int64)
    rows[:, 0] = rng.integers(0, 2, count)
    rows[:, 2] = rng.integers(0, 4, count)
    rows[:, 3] = rng.choice(arms, count)
    rows[:, [1, 4]] = rng.integers(0, spread, (count, 2))
    return rows


def brute_force(
    rows: Rows, heard: Rows, query: Rows, diagonal: int, threshold: Fraction
) -> tuple[Counter[int], float]:
    """Section 4.6.1 over all vectors, in whole units of 1 / (55 * diagonal)."""
    unit = 55 * diagonal
    away = (
        unit * ((rows[:, 0] != query[0]) * 1 + (rows[:, 2] != query[2]) * 1)
        + diagonal * np.abs(rows[:, 3] - query[3])
        + 55 * (np.abs(rows[:, 1] - query[1]) + np.abs(rows[:, 4] - query[4]))
    )
    least = int(away.min())
    chosen = away <= least + int(threshold * unit)
    return Counter(heard[chosen].tolist()), least / unit


@settings(max_examples=60)
@given(
    st.integers(0, 2**32),
    st.integers(1, 3_000),
    st.sampled_from([5, 30, 139, 2_000]),
    st.sampled_from([[215], [215, 255], [215, 219, 223, 240, 255], list(range(215, 256))]),
    st.sampled_from([1, 11, 55, 138, 177]),
    st.sampled_from(["0", "0.01", "0.3"]),
)
def test_neighbours_equal_brute_force(
    seed: int, count: int, spread: int, arms: list[int], diagonal: int, threshold: str
) -> None:
    rng = np.random.default_rng(seed)
    rows, heard = vectors(rng, count, spread, arms), rng.integers(0, 10, count)
    imitator = NearestNeighbourImitator(diagonal, float(threshold), "exact").fit(rows, heard)
    queries = np.concatenate((vectors(rng, 15, spread + 20, list(range(210, 260))), rows[:5]))
    for query in queries:
        votes, least = brute_force(rows, heard, query, diagonal, Fraction(threshold))
        found = imitator.neighbours(query)
        assert dict(found.votes) == {Behaviour(label): count for label, count in votes.items()}
        assert found.tied == votes.total()
        assert found.distance == least


@settings(max_examples=20, deadline=None)
@given(st.integers(0, 2**32), st.sampled_from([1, 2_000]), st.sampled_from([8, 139]))
def test_vectors_added_later_equal_vectors_fitted_at_once(seed: int, count: int, spread: int) -> None:
    rng = np.random.default_rng(seed)
    rows, heard = vectors(rng, 300 + count, spread, [215, 219, 255]), rng.integers(0, 10, 300 + count)
    grown = (
        NearestNeighbourImitator(arithmetic="exact")
        .fit(rows[:300], heard[:300])
        .partial_fit(rows[300:], heard[300:])
    )
    whole = NearestNeighbourImitator(arithmetic="exact").fit(rows, heard)
    queries = vectors(rng, 50, spread + 20, [215, 217, 255])
    assert [grown.neighbours(query) for query in queries] == [whole.neighbours(query) for query in queries]
