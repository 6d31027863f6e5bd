"""Memories in arrays give the same votes and draws as the imitator in Python; no numba is needed."""

from collections import Counter
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from khepera_forage.policies import NearestNeighbourImitator
from khepera_forage.policies.memories import (
    BEHAVIOURS,
    memories_of,
)
from khepera_forage.policies.votes import draw_label, nearest_votes
from khepera_forage.task.states import StateVector

_vector = st.tuples(
    st.integers(0, 1),
    st.integers(0, 12) | st.integers(0, 177),
    st.integers(0, 3),
    st.sampled_from((215, 219, 220, 255)),
    st.integers(0, 12) | st.integers(0, 177),
)
_experience = st.lists(st.tuples(_vector, st.integers(0, 9)), min_size=1, max_size=40)
_uniform = st.floats(0, 1, exclude_max=True)


class FixedGenerator:
    """A generator that gives always the same number."""

    def __init__(self, chance: float) -> None:
        self.chance = chance

    def random(self) -> float:
        return self.chance


@settings(max_examples=100, deadline=None)
@given(
    st.lists(_experience, min_size=1, max_size=3),
    st.lists(_vector, min_size=1, max_size=8),
    st.sampled_from((138, 177, 1, 7)),
    _uniform,
)
def test_votes_and_draws_equal_the_imitators(
    experiences: Any, queries: Any, diagonal: int, chance: float
) -> None:
    parts = [([v for v, _ in e], [b for _, b in e]) for e in experiences]
    memories = memories_of(parts)
    votes = np.zeros(BEHAVIOURS, np.int64)
    for number, part in enumerate(parts):
        imitator = NearestNeighbourImitator(diagonal).fit(*part)
        for query in [*queries, part[0][0]]:
            neighbours = imitator.neighbours(StateVector(*query))
            votes[:] = 0
            nearest, total = nearest_votes(memories, number, query, diagonal, votes)
            assert nearest / (55 * diagonal) == neighbours.distance
            assert total == neighbours.tied == votes.sum()
            assert {b: n for b, n in enumerate(votes.tolist()) if n} == dict(neighbours.votes)
            rng: Any = FixedGenerator(chance)
            assert draw_label(votes, total, chance) == neighbours.draw(rng)


@pytest.mark.parametrize(
    ("experiences", "message"),
    [
        ([], "0 experiences; allowed: 1 to"),
        ([([], [])], r"experience 0 has vectors of shape \(0,\)"),
        (
            [([(0, 1, 0, 215, 1)], [0]), ([(0, 1, 0, 215)], [0])],
            r"experience 1 has vectors of shape \(1, 4\)",
        ),
        ([([(0, 1, 0, 215, 1)], [0, 1])], r"behaviours of shape \(2,\)"),
        ([([(0, 1, 0, 215, 1.5)], [0])], "experience is of type float64"),
        ([([(0, 1, 0, 215, 8192)], [0])], "robot_food_distance is 8192; allowed: 0 to 8191"),
        ([([(0, -1, 0, 215, 1)], [0])], "robot_home_distance is -1"),
        ([([(0, 1, 4, 215, 1)], [0])], "food_type is 4"),
        ([([(0, 1, 0, 215, 1)], [10])], "behaviour is 10; allowed: 0 to 9"),
    ],
)
def test_bad_experience_is_refused_with_its_value(experiences: Any, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        memories_of(experiences)


def _sum_of_floats(a: StateVector, b: StateVector, diagonal: int, kind: Any) -> Any:
    """The distance of 4.6.1, term by term."""
    total = kind(0)
    total += kind(a.object_presence != b.object_presence)
    total += kind(a.food_type != b.food_type)
    total += kind(abs(a.arms_height - b.arms_height)) / kind(55)
    total += kind(abs(a.robot_food_distance - b.robot_food_distance)) / kind(diagonal)
    total += kind(abs(a.robot_home_distance - b.robot_home_distance)) / kind(diagonal)
    return total


@pytest.mark.parametrize(
    ("arithmetic", "kind"), [("32-bit floats", np.float32), ("64-bit floats", np.float64)]
)
@settings(max_examples=100, deadline=None)
@given(
    experience=_experience,
    queries=st.lists(_vector, min_size=1, max_size=8),
    diagonal=st.sampled_from((138, 177, 7)),
)
def test_votes_in_floats_are_those_of_the_least_sum(
    arithmetic: str, kind: Any, experience: Any, queries: Any, diagonal: int
) -> None:
    vectors, heard = [StateVector(*v) for v, _ in experience], [b for _, b in experience]
    imitator = NearestNeighbourImitator(diagonal, arithmetic=arithmetic).fit(vectors, heard)
    for query in map(StateVector._make, queries):
        sums = [_sum_of_floats(query, vector, diagonal, kind) for vector in vectors]
        expected = Counter(label for label, total in zip(heard, sums, strict=True) if total == min(sums))
        assert dict(imitator.neighbours(query).votes) == dict(expected)


def test_floats_split_exact_ties() -> None:
    """Equal exact distances, from terms in another order of size."""
    query, vectors = StateVector(0, 60, 0, 215, 60), [(0, 60, 0, 215, 67), (0, 63, 0, 215, 64)]
    votes = []
    for arithmetic in ("exact", "32-bit floats", "64-bit floats"):
        imitator = NearestNeighbourImitator(138, arithmetic=arithmetic).fit(vectors, [0, 1])
        votes.append(imitator.neighbours(query).tied)
    assert votes[0] == 2
    assert min(votes[1:]) == 1


def test_wrong_arithmetic_is_an_error() -> None:
    with pytest.raises(
        ValueError, match=r"arithmetic is '16-bit'; allowed: 'exact', '32-bit floats', '64-bit"
    ):
        NearestNeighbourImitator(arithmetic="16-bit").fit([(0, 1, 0, 215, 2)], [0])
    with pytest.raises(ValueError, match=r"threshold is 0\.1 with 32-bit floats; allowed: 0, or exact"):
        NearestNeighbourImitator(threshold=0.1, arithmetic="32-bit floats").fit([(0, 1, 0, 215, 2)], [0])
