"""The imitator and its variants: votes against section 4.6.1 in fractions, on experience of every shape."""

import copy
import itertools
import math
import pickle
from collections import Counter
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from sklearn.exceptions import NotFittedError

from khepera_forage.policies import (
    GrowingMemory,
    KNearestImitator,
    NearestNeighbourImitator,
    Neighbours,
    WeightedImitator,
    distance,
)
from khepera_forage.policies.features import encoded
from khepera_forage.policies.memories import memories_of, nearest_votes
from khepera_forage.policies.policy import draw_label
from khepera_forage.task.decisions import FIELDS
from khepera_forage.task.states import NUM_BEHAVIOURS, Behaviour, StateVector

Experienced = list[tuple[StateVector, int]]
CORRIDOR, RECTANGLE = 138, 177
PIXELS = st.integers(0, 6) | st.integers(0, 177)
ARMS = st.sampled_from([215, 216, 219, 235, 255]) | st.integers(215, 255)
# Mostly few and close values, so that ties, duplicates and conflicts abound.
VECTORS = st.builds(StateVector, st.integers(0, 1), PIXELS, st.integers(0, 3), ARMS, PIXELS)
EXPERIENCE = st.lists(st.tuples(VECTORS, st.integers(0, 9)), min_size=1, max_size=40)
QUERIES = st.lists(VECTORS, min_size=1, max_size=5)
DIAGONALS = st.sampled_from([1, 5, CORRIDOR, RECTANGLE, 10**12])
THRESHOLDS = st.sampled_from([0.0, 0.001, 0.1, 0.3, 1 / 3, 1.0, 5.0, 1e300])


NUMBERS: dict[str, Any] = {"exact": Fraction, "32-bit floats": np.float32, "64-bit floats": np.float64}
"""Arithmetics: the last two are those of the thesis's time."""


def apart(one: Any, other: Any, diagonal: int, number: Any = Fraction) -> Any:
    """Section 4.6.1, term by term."""
    away = number(int(one[0] != other[0]) + int(one[2] != other[2]))
    for column, span in ((3, 55), (4, diagonal), (1, diagonal)):
        away += number(abs(int(one[column]) - int(other[column]))) / number(span)
    return away


def expected_neighbours(
    experience: Experienced, query: StateVector, diagonal: int, threshold: float = 0.0, number: Any = Fraction
) -> Neighbours:
    """One vector at a time."""
    away = [(apart(vector, query, diagonal, number), behaviour) for vector, behaviour in experience]
    least = min(away)[0]
    reach = least + number(repr(threshold))
    chosen = Counter(Behaviour(behaviour) for far, behaviour in away if far <= reach)
    behaviours, counts = zip(*sorted(chosen.items()), strict=True)
    return Neighbours(behaviours, counts, chosen.total(), float(least))


def imitator_of(experience: Experienced, diagonal: int = CORRIDOR) -> NearestNeighbourImitator:
    vectors, behaviours = zip(*experience, strict=True)
    return NearestNeighbourImitator(diagonal, arithmetic="exact").fit(np.array(vectors), np.array(behaviours))


ROUNDED = [(StateVector(0, 83, 0, 255, 82), 0), (StateVector(0, 89, 0, 255, 76), 1)]
"""Equally far from the query below, but in floats only if the terms are added in another order."""


@settings(max_examples=200)
@given(EXPERIENCE, QUERIES, DIAGONALS, THRESHOLDS, st.sampled_from([*NUMBERS]))
@example(
    # 11 positions of the arm are as far as a fifth of the diagonal: equal in fractions, not in floats.
    [(StateVector(0, 30, 0, 226, 40), 1), (StateVector(0, 31, 0, 215, 40), 2)],
    [StateVector(0, 30, 0, 215, 40)],
    5,
    0.0,
    "exact",
)
@example([(StateVector(0, 0, 0, 215, d), d) for d in range(5)], [StateVector(0, 0, 0, 215, 0)], 10, 0.3, "exact")
@example(ROUNDED, [StateVector(0, 60, 0, 215, 60)], CORRIDOR, 0.0, "32-bit floats")
@example(ROUNDED, [StateVector(0, 60, 0, 215, 60)], CORRIDOR, 0.0, "64-bit floats")
def test_neighbours_equal_section_4_6_1(
    experience: Experienced, queries: list[StateVector], diagonal: int, threshold: float, arithmetic: str
) -> None:
    imitator = imitator_of(experience)
    for query in queries:
        assert imitator.neighbours(query) == expected_neighbours(experience, query, CORRIDOR)
    threshold = threshold if arithmetic == "exact" else 0.0
    imitator.set_params(diagonal=diagonal, threshold=threshold, arithmetic=arithmetic)
    levels = imitator.predict_proba(queries)
    np.testing.assert_array_equal(imitator.predict_proba(np.array(queries, float)), levels)
    for query, level, label in zip(queries, levels, imitator.predict(queries), strict=True):
        expected = expected_neighbours(experience, query, diagonal, threshold, NUMBERS[arithmetic])
        found = imitator.neighbours(query)
        assert found == imitator.neighbours(query)  # from the cache
        assert found[:3] == expected[:3]
        assert found.distance == pytest.approx(expected.distance, rel=1e-6)
        shares = {behaviour: count / expected.tied for behaviour, count in expected.votes}
        assert imitator.confidence_levels(query) == shares
        assert dict(zip(imitator.classes_[level > 0], level[level > 0], strict=True)) == shares
        assert label == max(shares, key=lambda behaviour: (shares[behaviour], -behaviour))
        assert (found.tie, found.conflict) == (expected.tied > 1, len(expected.votes) > 1)


@given(EXPERIENCE, EXPERIENCE, QUERIES, st.sets(st.integers(1, 39), max_size=3))
def test_learning_on_and_fitting_again_change_the_votes(
    earlier: Experienced, experience: Experienced, queries: list[StateVector], cuts: set[int]
) -> None:
    imitator = imitator_of(earlier)
    ends = [*sorted(cut for cut in cuts if cut < len(experience)), len(experience)]
    for start, stop in zip([0, *ends], ends, strict=False):
        vectors, behaviours = zip(*experience[start:stop], strict=True)
        (imitator.partial_fit if start else imitator.fit)(np.array(vectors), np.array(behaviours))
        for query in queries:  # what is learned empties the cache
            assert imitator.neighbours(query) == expected_neighbours(experience[:stop], query, CORRIDOR)


def test_halves_of_pixels_are_compared_too() -> None:
    rows = np.array([[0, 30.5, 0, 215, 40], [0, 31, 0, 215, 40]])
    imitator = NearestNeighbourImitator(arithmetic="exact").fit(rows, [0, 1])
    assert imitator.predict([[0, 30.7, 0, 215, 40], [0, 30.8, 0, 215, 40]]).tolist() == [0, 1]


# ---------------------------------------------------------------- memories in arrays, for kernels


@settings(max_examples=60)
@given(
    seed=st.integers(0, 2**32),
    counts=st.lists(st.integers(1, 40) | st.integers(1, 1_000), min_size=1, max_size=3),
    spread=st.sampled_from([3, 5, 30, 139, 2_000]),
    arms=st.sampled_from([[215], [215, 255], [215, 219, 223, 240, 255], list(range(215, 256))]),
    diagonal=st.sampled_from([1, 7, 11, 55, CORRIDOR, RECTANGLE]),
    arithmetic=st.sampled_from(FIELDS["distance_arithmetic"].choices),
)
def test_memories_in_arrays_have_the_votes_and_draws_of_the_imitators(
    seed: int, counts: list[int], spread: int, arms: list[int], diagonal: int, arithmetic: str
) -> None:
    rng = np.random.default_rng(seed)
    experiences = []
    for count in counts:
        rows = np.column_stack([rng.integers(0, high, count) for high in (2, spread, 4, 1, spread)])
        rows[:, 3] = rng.choice(arms, count)
        experiences.append((rows, rng.integers(0, 10, count)))
    memories, as_number = memories_of(experiences), FIELDS["distance_arithmetic"].as_number(arithmetic)
    for number, (rows, heard) in enumerate(experiences):
        imitator = NearestNeighbourImitator(diagonal, arithmetic=arithmetic).fit(rows, heard)
        for query in (rows[:10] + rng.integers(0, 2, (len(rows[:10]), 5)) * (0, 3, 0, 0, 2)).tolist():
            votes, neighbours = np.zeros(NUM_BEHAVIOURS, np.int64), imitator.neighbours(query)
            nearest, total = nearest_votes(memories, number, query, diagonal, votes, as_number)
            assert nearest / (55 * diagonal) == neighbours.distance
            assert total == neighbours.tied == votes.sum()
            assert {b: n for b, n in enumerate(votes.tolist()) if n} == dict(neighbours.votes)
            chance = np.random.default_rng(seed).random()
            assert draw_label(votes, total, chance) == neighbours.draw(np.random.default_rng(seed))


VECTOR = (0, 1, 0, 215, 1)


@pytest.mark.parametrize(
    ("experiences", "message"),
    [
        ([], "0 experiences; allowed: 1 to"),
        ([([], [])], r"experience 0 has vectors of shape \(0,\)"),
        ([([VECTOR], [0]), ([VECTOR[:4]], [0])], r"experience 1 has vectors of shape \(1, 4\)"),
        ([([(0, 1, 0, 215, 1.5)], [0])], "experience is of type float64"),
        ([([(0, 1, 0, 215, 8192)], [0])], "robot_food_distance is 8192; allowed: 0 to 8191"),
        ([([VECTOR], [10])], "behaviour is 10; allowed: 0 to 9"),
    ],
)
def test_bad_experience_is_refused_with_its_value(experiences: Any, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        memories_of(experiences)


# ---------------------------------------------------------------- k vectors vote


@given(EXPERIENCE, VECTORS, st.integers(1, 12), DIAGONALS, st.sampled_from(["uniform", "distance"]))
def test_confidence_levels_of_k_vectors_equal_shares_in_fractions(
    experience: Experienced, query: StateVector, k: int, diagonal: int, weighting: str
) -> None:
    rows, heard = zip(*experience, strict=True)
    learner = KNearestImitator(k, weighting, diagonal).fit(rows, heard)
    levels = learner.predict_proba([query])[0]
    away = sorted((apart(vector, query, diagonal), label) for vector, label in experience)
    votes: dict[int, Fraction] = {}
    for far, label in away:
        if far <= away[min(k, len(away)) - 1][0]:
            nearest = away[0][0] == 0
            weight = Fraction(1) if weighting == "uniform" else Fraction(far == 0) if nearest else 1 / far
            votes[label] = votes.get(label, Fraction(0)) + weight
    for label, level in zip(learner.classes_.tolist(), levels, strict=True):
        expected = votes.get(label, Fraction(0)) / sum(votes.values())
        assert level == pytest.approx(float(expected), abs=1e-12)
    if k == 1 and weighting == "uniform":
        np.testing.assert_array_equal(levels, imitator_of(experience, diagonal).predict_proba([query])[0])
        weighted = WeightedImitator(diagonal, weights=(3,) * 5).fit(rows, heard)
        np.testing.assert_array_equal(levels, weighted.predict_proba([query])[0])
        assert not hasattr(weighted, "error_"), "nothing was searched"
    first, second = encoded([query, rows[0]], diagonal)
    assert distance(query, rows[0], diagonal) == apart(query, rows[0], diagonal)
    assert np.abs(first - second).sum() == pytest.approx(float(distance(query, rows[0], diagonal)), abs=1e-9)


# ---------------------------------------------------------------- labels, rows and copies

X = np.array([[0, 90, 0, 215, 60], [0, 50, 0, 215, 18], [1, 48, 0, 255, 14], [1, 48, 1, 215, 14]])
Y = np.array([0, 2, 3, 7])


def test_act_refuses_experience_of_other_kinds_and_none() -> None:
    rng = np.random.default_rng()
    with pytest.raises(NotFittedError):
        NearestNeighbourImitator().act(X[0], rng)
    imitator = NearestNeighbourImitator().fit(X[:, :3], Y)
    np.testing.assert_array_equal(imitator.predict(X[:, :3]), Y)
    with pytest.raises(ValueError, match="learned from rows of 3 columns; allowed: 5"):
        imitator.act(X[0], rng)
    for labels in (["a", "b", "c", "d"], [0, 2, 3, 11]):
        imitator.fit(X, labels)
        assert imitator.predict(X).tolist() == labels
        with pytest.raises(ValueError, match=r"labels learned are .*; allowed: behaviours, 0 to 10"):
            imitator.act(X[0], rng)


def test_labels_outside_classes_are_refused() -> None:
    imitator = NearestNeighbourImitator()
    with pytest.raises(ValueError, match=r"labels are \[0, 2, 3, 7\]; allowed: those among classes, \[0, 2\]"):
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


def test_behaviours_are_drawn_with_their_confidence_levels() -> None:
    """The example of section 4.6.2: of five equally near vectors, four say x and one says y."""
    query, near = StateVector(0, 50, 0, 215, 18), [(0, 50, 0, 215, food) for food in (20, 20, 16, 16)]
    imitator = NearestNeighbourImitator().fit([*near, (0, 52, 0, 215, 18), (0, 90, 0, 215, 60)], [2, 2, 2, 2, 1, 0])
    levels = imitator.confidence_levels(query)
    assert levels == {Behaviour.ORIENT_WITH_FOOD: 0.8, Behaviour.MOVE_SLOWLY: 0.2}
    rng = np.random.default_rng(11)
    counts = Counter(imitator.act(query, rng) for _ in range(20_000))
    assert counts.keys() == levels.keys()
    # Five standard deviations of the binomial distribution.
    assert abs(counts[Behaviour.MOVE_SLOWLY] - 4_000) < 5 * (20_000 * 0.2 * 0.8) ** 0.5


# ---------------------------------------------------------------- attribute weights learned from experience

Data = tuple[NDArray[np.int64], NDArray[np.int64]]


def misleading(seed: int, count: int = 200) -> Data:
    """Only the food distance decides the behaviour; the home distance is noise with four times the range."""
    rng = np.random.default_rng(seed)
    food = rng.integers(0, 30, count)
    rows = np.column_stack([np.zeros(count), rng.integers(0, 120, count), np.zeros(count), np.full(count, 215), food])
    return rows.astype(np.int64), np.where(food <= 15, 2, 0)


def left_out(data: Data, weights: tuple[int, ...], groups: NDArray[np.int64]) -> float:
    """The leave-one-out error, one vector at a time: the share of votes for another behaviour."""
    wrong = []
    for row, heard, group in zip(*data, groups, strict=True):
        others = groups != group
        if others.any():
            rest = WeightedImitator(weights=weights).fit(data[0][others], data[1][others])
            levels = dict(zip(rest.classes_.tolist(), rest.predict_proba([row])[0], strict=True))
            wrong.append(1 - levels.get(int(heard), 0.0))
    return float(np.mean(wrong))


def test_error_equals_leave_one_out_error() -> None:
    data = misleading(2, 40)
    for groups in (np.arange(40), np.arange(40) // 8):
        learned = WeightedImitator(choices=(0, 1, 4), random_state=0).fit(*data, groups=groups)
        assert learned.plain_error_ == pytest.approx(left_out(data, (1,) * 5, groups))
        assert learned.error_ == pytest.approx(left_out(data, learned.weights_, groups))
        for column, choice in itertools.product(range(5), (0, 1, 4)):  # no single change improves it
            tried = (*learned.weights_[:column], choice, *learned.weights_[column + 1 :])
            if any(tried):
                assert left_out(data, tried, groups) >= learned.error_ - 1e-9


# ---------------------------------------------------------------- growing memory (section 2.3)

HERE, THERE = [0, 90, 0, 215, 60], [0, 30, 0, 215, 18]


def test_node_grows_at_a_new_stimulus() -> None:
    memory = GrowingMemory(reach=0.02)
    memory.fit([HERE, [0, 91, 0, 215, 61], THERE, HERE], [0, 0, 2, 0])  # 2 of 138 is within reach
    assert len(memory.nodes_) == 2
    assert memory.votes_.tolist() == [[3, 0], [0, 1]]
    assert memory.predict([HERE, THERE]).tolist() == [0, 2]
    assert len(GrowingMemory(reach=0.01).fit([HERE, [0, 91, 0, 215, 61]], [0, 0]).nodes_) == 2


def test_rare_node_is_forgotten_in_time_and_frequent_node_later() -> None:
    settings: dict[str, Any] = {"habituation": 0.3, "recovery": 0.01, "forgetting": 0.95}
    lasts = math.ceil(math.log(0.3 / 0.05) / -math.log(1 - 0.01))
    rare = GrowingMemory(**settings).fit([HERE] + [THERE] * (lasts - 1), [0] + [2] * (lasts - 1))
    assert rare.predict([HERE]).tolist() == [0]
    rare.partial_fit([THERE], [2])
    assert len(rare.nodes_) == 1
    assert rare.predict([HERE]).tolist() == [2], "the remaining node is nearest"
    frequent = GrowingMemory(**settings).fit([HERE] * 20 + [THERE] * (lasts + 20), [0] * 20 + [2] * (lasts + 20))
    assert frequent.predict([HERE]).tolist() == [0]


def test_partial_fit_equals_fit() -> None:
    rng = np.random.default_rng(0)
    rows = np.column_stack([np.zeros(300), rng.integers(0, 40, 300), np.zeros(300), np.full(300, 215), np.zeros(300)])
    heard = rng.integers(0, 4, 300)
    whole = GrowingMemory(recovery=0.05).fit(rows, heard)
    parts = GrowingMemory(recovery=0.05).partial_fit(rows[:10], heard[:10])
    pickle.loads(pickle.dumps(parts)).partial_fit(rows[10:], heard[10:])  # a copy learns independently
    parts.partial_fit(rows[10:], heard[10:])
    np.testing.assert_array_equal(whole.nodes_, parts.nodes_)
    np.testing.assert_array_equal(whole.predict_proba(rows), parts.predict_proba(rows))
    assert len(whole.nodes_) < 40
