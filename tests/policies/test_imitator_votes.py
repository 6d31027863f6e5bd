"""The votes of the imitator, against section 4.6.1 in fractions, on experience of every shape."""

from collections import Counter
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from khepera_forage.policies import NearestNeighbourImitator, Neighbours, distance
from khepera_forage.task.states import Behaviour, StateVector

CORRIDOR, RECTANGLE = 138, 177
RAISED = [215, 216, 219, 235, 255]

# Few and close values, so that ties, duplicates and conflicts abound; and now and then any values at all.
CLOSE = st.builds(
    StateVector,
    st.integers(0, 1),
    st.integers(0, 6),
    st.integers(0, 3),
    st.sampled_from(RAISED),
    st.integers(0, 6),
)
ANY = st.builds(
    StateVector,
    st.integers(0, 1),
    st.integers(0, 177),
    st.integers(0, 3),
    st.integers(215, 255),
    st.integers(0, 177),
)
VECTORS = st.one_of(CLOSE, CLOSE, ANY)
BEHAVIOURS = st.integers(0, 9)
EXPERIENCE = st.lists(st.tuples(VECTORS, BEHAVIOURS), min_size=1, max_size=40)
DIAGONALS = st.sampled_from([1, 5, CORRIDOR, RECTANGLE, 10**12])
THRESHOLDS = st.sampled_from([0.0, 0.001, 0.1, 0.3, 1 / 3, 1.0, 5.0, 1e300])


def expected_neighbours(
    experience: list[tuple[StateVector, int]], query: StateVector, diagonal: int, threshold: float = 0.0
) -> Neighbours:
    """Section 4.6.1 in fractions, one vector at a time."""
    away = []
    for vector, behaviour in experience:
        apart = Fraction(0)
        apart += vector[0] != query[0]
        apart += vector[2] != query[2]
        apart += abs(Fraction(vector[3] - query[3], 55))
        apart += abs(Fraction(vector[1] - query[1], diagonal))
        apart += abs(Fraction(vector[4] - query[4], diagonal))
        away.append((apart, behaviour))
    least = min(apart for apart, _ in away)
    reach = least + Fraction(repr(threshold))
    chosen = Counter(Behaviour(behaviour) for apart, behaviour in away if apart <= reach)
    behaviours, counts = zip(*sorted(chosen.items()), strict=True)
    return Neighbours(behaviours, counts, chosen.total(), float(least))


def imitator_of(
    experience: list[tuple[StateVector, int]], diagonal: int = CORRIDOR, threshold: float = 0.0
) -> NearestNeighbourImitator:
    vectors, behaviours = zip(*experience, strict=True)
    return NearestNeighbourImitator(diagonal, threshold, "exact").fit(np.array(vectors), np.array(behaviours))


@settings(max_examples=300, deadline=None)
@given(EXPERIENCE, st.lists(VECTORS, min_size=1, max_size=5), DIAGONALS, THRESHOLDS)
@example(
    # 11 positions of the arm are as far as a fifth of the diagonal: equal in fractions, not in floats.
    [(StateVector(0, 30, 0, 226, 40), 1), (StateVector(0, 31, 0, 215, 40), 2)],
    [StateVector(0, 30, 0, 215, 40)],
    5,
    0.0,
)
@example([(StateVector(0, 0, 0, 215, d), d) for d in range(5)], [StateVector(0, 0, 0, 215, 0)], 10, 0.3)
def test_neighbours_equal_section_4_6_1(
    experience: list[tuple[StateVector, int]], queries: list[StateVector], diagonal: int, threshold: float
) -> None:
    imitator = imitator_of(experience, diagonal, threshold)
    levels = imitator.predict_proba(queries)
    for query, level, label in zip(queries, levels, imitator.predict(queries), strict=True):
        expected = expected_neighbours(experience, query, diagonal, threshold)
        assert imitator.neighbours(query) == expected
        assert imitator.neighbours(query) == expected  # from the cache
        shares = {behaviour: count / expected.tied for behaviour, count in expected.votes}
        assert imitator.confidence_levels(query) == shares
        assert dict(zip(imitator.classes_[level > 0], level[level > 0], strict=True)) == shares
        assert label == max(shares, key=lambda behaviour: (shares[behaviour], -behaviour))
        assert imitator.neighbours(query).tie == (expected.tied > 1)
        assert imitator.neighbours(query).conflict == (len(expected.votes) > 1)


@settings(deadline=None)
@given(EXPERIENCE, st.lists(VECTORS, min_size=1, max_size=5), THRESHOLDS)
def test_diagonal_and_threshold_can_change_after_fit(
    experience: list[tuple[StateVector, int]], queries: list[StateVector], threshold: float
) -> None:
    imitator = imitator_of(experience)
    for diagonal, limit in [(CORRIDOR, 0.0), (RECTANGLE, 0.0), (RECTANGLE, threshold), (CORRIDOR, threshold)]:
        imitator.set_params(diagonal=diagonal, threshold=limit)
        for query in queries:
            assert imitator.neighbours(query) == expected_neighbours(experience, query, diagonal, limit)


@settings(deadline=None)
@given(EXPERIENCE, st.lists(VECTORS, min_size=1, max_size=5), st.data())
def test_partial_fit_equals_fit_on_all_of_it(
    experience: list[tuple[StateVector, int]], queries: list[StateVector], data: st.DataObject
) -> None:
    shuffled = data.draw(st.permutations(experience))
    cuts = sorted(data.draw(st.sets(st.integers(1, len(shuffled)), max_size=4)) | {len(shuffled)})
    imitator = NearestNeighbourImitator(arithmetic="exact")
    for start, stop in zip([0, *cuts], cuts, strict=False):
        vectors, behaviours = zip(*shuffled[start:stop], strict=True)
        imitator.partial_fit(np.array(vectors), np.array(behaviours))
        for query in queries:  # the cache must be emptied by what is learned
            assert imitator.neighbours(query) == expected_neighbours(shuffled[:stop], query, CORRIDOR)
    once = imitator_of(experience)
    np.testing.assert_array_equal(imitator.classes_, once.classes_)
    np.testing.assert_array_equal(imitator.predict_proba(queries), once.predict_proba(queries))


@settings(deadline=None)
@given(EXPERIENCE, st.lists(VECTORS, min_size=1, max_size=5))
def test_fit_forgets_earlier_experience(
    experience: list[tuple[StateVector, int]], queries: list[StateVector]
) -> None:
    imitator = imitator_of([(query, 9) for query in queries])
    for query in queries:
        imitator.neighbours(query)
    vectors, behaviours = zip(*experience, strict=True)
    imitator.fit(vectors, behaviours)
    for query in queries:
        assert imitator.neighbours(query) == expected_neighbours(experience, query, CORRIDOR)


def test_halves_of_pixels_are_compared_in_floats() -> None:
    rows = np.array([[0, 30, 0, 215, 40], [0, 33, 0, 215, 40], [1, 30, 0, 215, 40]])
    imitator = NearestNeighbourImitator(arithmetic="exact").fit(rows, [0, 1, 3])
    assert imitator.predict(rows + np.array([0, 0.5, 0, 0, 0])).tolist() == [0, 1, 3]
    assert imitator.predict(rows + np.array([0, 2.5, 0, 0, 0])).tolist() == [1, 1, 3]
    assert imitator.predict_proba([[0, 31.5, 0, 215, 40]]).tolist() == [[0.5, 0.5, 0]]
    imitator.partial_fit([[0, 33, 0, 215, 40], [0, 33, 0, 215, 40]], [0, 0])
    assert imitator.predict_proba([[0, 31.5, 0, 215, 40]]).tolist() == [[0.75, 0.25, 0]]
    imitator.partial_fit([[0, 31.5, 0, 215, 40]], [5])
    assert imitator.predict(rows).tolist() == [0, 0, 3]
    assert imitator.predict([[0, 31.5, 0, 215, 40]]).tolist() == [5]
    imitator.partial_fit([[0, 31.5, 0, 215, 40]], [7])
    assert imitator.confidence_levels((0, 30, 0, 215, 40)) == {0: 1.0}
    assert imitator.predict_proba([[0, 31.5, 0, 215, 40]]).tolist() == [[0, 0, 0, 0.5, 0.5]]


@pytest.mark.parametrize("far", [2**40, 2**45])
def test_numbers_far_beyond_any_arena_are_compared(far: int) -> None:
    imitator = NearestNeighbourImitator(arithmetic="exact").fit(
        [[0, 30, 0, 215, 40], [0, 60, 0, 215, 40]], [0, 1]
    )
    assert imitator.neighbours((0, 60, 0, 215, far)).votes == ((1, 1),)
    assert imitator.neighbours((0, 60, 0, 215, far)).distance == pytest.approx(far / CORRIDOR)
    imitator.partial_fit([[0, 30, 0, 215, far]], [7])
    assert imitator.predict([[0, 30, 0, 215, far], [0, 31, 0, 215, 41], [0, 59, 0, 215, 41]]).tolist() == [
        7,
        0,
        1,
    ]


def test_distance_equals_section_4_6_1() -> None:
    near = StateVector(0, 100, 0, 255, 20)
    far = StateVector(1, 31, 1, 215, 89)
    assert distance(near, far, CORRIDOR) == 2 + Fraction(40, 55) + Fraction(69, 138) + Fraction(69, 138)
    # Less than 5 however far apart, "due to the ArmsHeight difference".
    assert distance(StateVector(0, 0, 0, 215, 0), StateVector(1, 138, 3, 255, 138), CORRIDOR) < 5
