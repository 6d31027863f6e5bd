"""The imitator over many vectors: every tie, against brute force in whole numbers, and what one more costs."""

import pickle
from collections import Counter
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from khepera_forage.policies import NearestNeighbourImitator
from khepera_forage.policies.merging import FEW, merged
from khepera_forage.policies.plane import Plane
from khepera_forage.policies.votes import PixelVotes
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


def brute(
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
def test_every_query_is_answered_as_by_brute_force(
    seed: int, count: int, spread: int, arms: list[int], diagonal: int, threshold: str
) -> None:
    rng = np.random.default_rng(seed)
    rows, heard = vectors(rng, count, spread, arms), rng.integers(0, 10, count)
    imitator = NearestNeighbourImitator(diagonal, float(threshold)).fit(rows, heard)
    queries = np.concatenate((vectors(rng, 15, spread + 20, list(range(210, 260))), rows[:5]))
    for query in queries:
        votes, least = brute(rows, heard, query, diagonal, Fraction(threshold))
        found = imitator.neighbours(query)
        assert dict(found.votes) == {Behaviour(label): count for label, count in votes.items()}
        assert found.tied == votes.total()
        assert found.distance == least


def test_ties_are_common_in_what_was_just_tested() -> None:
    """Otherwise the test above would say little."""
    rng = np.random.default_rng(0)
    rows, heard = vectors(rng, 3_000, 30, [215, 255]), rng.integers(0, 10, 3_000)
    imitator = NearestNeighbourImitator().fit(rows, heard)
    found = [imitator.neighbours(query) for query in vectors(rng, 500, 50, [215, 255])]
    assert sum(neighbours.tie for neighbours in found) > 100
    assert sum(neighbours.conflict for neighbours in found) > 100


def test_learning_one_by_one_is_learning_at_once() -> None:
    rng = np.random.default_rng(1)
    rows, heard = vectors(rng, 400, 40, [215, 219, 255]), rng.integers(0, 10, 400)
    grown = NearestNeighbourImitator()
    for row, label in zip(rows, heard, strict=True):
        grown.partial_fit(row[None], [label])
    whole = NearestNeighbourImitator().fit(rows, heard)
    queries = vectors(rng, 200, 60, [215, 217, 255])
    assert [grown.neighbours(query) for query in queries] == [whole.neighbours(query) for query in queries]
    again = pickle.loads(pickle.dumps(grown))
    assert [again.neighbours(query) for query in queries] == [whole.neighbours(query) for query in queries]


def test_one_more_vector_touches_one_group_and_rebuilds_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    rng = np.random.default_rng(2)
    rows, heard = vectors(rng, 5_000, 139, list(range(215, 256))), rng.integers(0, 9, 5_000)
    imitator = NearestNeighbourImitator().fit(rows, heard)
    imitator.neighbours(rows[0])
    index = imitator._index
    assert isinstance(index, PixelVotes)
    groups = dict(index._groups)
    added: list[Plane] = []
    add = Plane.add

    def noted(plane: Plane, *point: int) -> None:
        added.append(plane)
        add(plane, *point)

    monkeypatch.setattr(Plane, "add", noted)
    imitator.partial_fit([[1, 70, 1, 215, 20]], [9])  # a class that was not there
    assert len(added) == 1
    assert index is imitator._index
    assert index._groups.keys() == groups.keys()
    assert all(index._groups[kind] is group for kind, group in groups.items())
    assert imitator.neighbours((1, 70, 1, 215, 20)).confidence_levels()[Behaviour.RELEASE_FOOD] > 0


@settings(max_examples=40)
@given(
    st.integers(0, 2**32),
    st.sampled_from([0, 1, FEW, FEW + 1, 2_000]),
    st.sampled_from(["int", "far", "float"]),
)
def test_merging_counts_every_row(seed: int, count: int, kind: str) -> None:
    rng = np.random.default_rng(seed)
    rows: NDArray[Any] = vectors(rng, count, 6, [215, 255])
    if kind == "far":
        rows[rows[:, 1] == 3, 1] = 2**39
        rows[:, 4] *= -(2**38)
    if kind == "float":
        rows = rows / 4
    codes = rng.integers(0, 3, count)
    counted: Counter[tuple[Any, ...]] = Counter()
    for row, code, times in merged(rows, codes):
        counted[*row, code] += times
    assert counted == Counter((*row, code) for row, code in zip(rows.tolist(), codes.tolist(), strict=True))
    if count > FEW:
        assert len(list(merged(rows, codes))) == len(counted), "each once"
