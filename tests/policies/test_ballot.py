"""The vote as plain arithmetic says exactly what the imitator says; no numba is needed."""

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from khepera_forage.policies import NearestNeighbourImitator
from khepera_forage.policies.ballot import BEHAVIOURS, draw, vote
from khepera_forage.policies.ballot_box import memories_of
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


class Given:
    """A generator whose next number is known."""

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
def test_votes_and_draws_are_the_imitators(
    experiences: Any, queries: Any, diagonal: int, chance: float
) -> None:
    parts = [([v for v, _ in e], [b for _, b in e]) for e in experiences]
    memories = memories_of(parts)
    counts = np.zeros(BEHAVIOURS, np.int64)
    for number, part in enumerate(parts):
        imitator = NearestNeighbourImitator(diagonal).fit(*part)
        for query in [*queries, part[0][0]]:
            neighbours = imitator.neighbours(StateVector(*query))
            total = vote(memories, number, query, diagonal, counts)
            assert total == neighbours.tied == counts.sum()
            assert {b: n for b, n in enumerate(counts.tolist()) if n} == dict(neighbours.votes)
            rng: Any = Given(chance)
            assert draw(counts, total, chance) == neighbours.draw(rng)


def test_equal_vectors_are_merged_and_counted() -> None:
    same, other = (0, 50, 0, 215, 40), (1, 50, 0, 255, 2)
    memories = memories_of([([same, other, same, same], [0, 3, 1, 0]), ([other], [4])])
    assert len(memories.home) == 4
    assert sorted(memories.times.tolist()) == [1, 1, 1, 2]
    counts = np.zeros(BEHAVIOURS, np.int64)
    assert vote(memories, 0, same, 138, counts) == 3
    assert counts.tolist() == [2, 1, 0, 0, 0, 0, 0, 0, 0, 0]
    assert vote(memories, 1, same, 138, counts) == 1
    assert counts[4] == 1


def test_one_memory_is_the_same_among_many() -> None:
    rng = np.random.default_rng(0)
    parts = [(rng.integers(0, (2, 40, 4, 256, 40), (n, 5)), rng.integers(0, 10, n)) for n in (300, 1, 80)]
    many = memories_of(parts)
    alone = memories_of(parts[2:])
    first = many.vectors[many.planes[2]]
    for name in ("home", "food", "behaviour", "times"):
        assert (getattr(many, name)[first:] == getattr(alone, name)).all()
    assert (many.keys[many.planes[2] :] == alone.keys).all()


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
def test_bad_experience_is_quoted(experiences: Any, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        memories_of(experiences)
