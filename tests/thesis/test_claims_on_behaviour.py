"""Claims about the learner's behaviour: each can be supported, not supported or undecided."""

from itertools import product

import pytest

from khepera_forage.rollouts.rows import RecallRow
from khepera_forage.task.decisions import DEFAULT_DECISIONS, Decisions, decisions_text
from khepera_forage.task.states import State
from khepera_forage.thesis.claims import Verdict
from khepera_forage.thesis.design import training_distance
from tests.thesis.claim_rows import (
    NOT,
    REPLICATIONS,
    SUPPORTED,
    UNDECIDED,
    Level,
    alternating,
    always,
    claim_from,
    recalls_with_success,
)
from tests.thesis.synthetic import counts, failed, recall


def sides(arena: str, near: Level, far: Level) -> list[RecallRow]:
    """Recalls with food nearer to home than in training, and further away."""
    return recalls_with_success(25, near, arena=arena) + recalls_with_success(70, far, arena=arena)


@pytest.mark.parametrize(
    ("near", "far", "verdict"),
    [
        (always(0.9), always(0.2), SUPPORTED),
        (always(0.2), always(0.9), SUPPORTED),
        (always(0.5), always(0.5), NOT),
        (alternating(0.2, 1.0), always(0.5), UNDECIDED),
    ],
)
def test_claim_that_success_depends_on_the_area(near: Level, far: Level, verdict: Verdict) -> None:
    assert claim_from("areas corridor", sides("corridor", near, far)).verdict is verdict


@pytest.mark.parametrize("corridor", [(0.9, 0.2), (0.2, 0.9)])
@pytest.mark.parametrize(
    ("there", "verdict"), [((0.8, 0.3), SUPPORTED), ((0.3, 0.8), NOT), ((0.5, 0.5), NOT)]
)
def test_success_depends_on_the_area_in_the_rectangle_in_the_direction_of_the_corridor(
    corridor: tuple[float, float], there: tuple[float, float], verdict: Verdict
) -> None:
    near, far = there if corridor[0] > corridor[1] else there[::-1]
    rows = sides("corridor", *map(always, corridor)) + sides("rectangle", always(near), always(far))
    assert claim_from("areas rectangle", rows).verdict is verdict


@pytest.mark.parametrize("arena", ["corridor", "rectangle"])
@pytest.mark.parametrize(
    ("there", "verdict"), [(always(0.9), SUPPORTED), (always(0.1), NOT), (alternating(0.1, 0.9), UNDECIDED)]
)
def test_claim_that_success_is_best_at_the_training_distance(
    arena: str, there: Level, verdict: Verdict
) -> None:
    for decisions in (DEFAULT_DECISIONS, Decisions(food_to_home=220)):
        training, text = training_distance(decisions), decisions_text(decisions)
        rows = recalls_with_success(training + 5.9, there, arena=arena, decisions=text)
        for elsewhere in (training - 6.1, training + 6.1):
            rows += recalls_with_success(elsewhere, always(0.5), arena=arena, decisions=text)
        assert claim_from(f"around {arena}", rows).verdict is verdict


@pytest.mark.parametrize("arena", ["corridor", "rectangle"])
@pytest.mark.parametrize(
    ("share", "verdict"), [(always(0.5), SUPPORTED), (always(0.0), NOT), (alternating(0.0, 0.3), UNDECIDED)]
)
def test_claim_that_orient_is_executed_without_food(arena: str, share: Level, verdict: Verdict) -> None:
    rows = [
        recall(arena=arena, replication=i, recall=number, orient_without_food=3 * (number < 10 * share(i)))
        for i, number in product(range(REPLICATIONS), range(10))
    ]
    assert claim_from(f"orient without food {arena}", rows).verdict is verdict


@pytest.mark.parametrize(
    ("share", "verdict"), [(always(0.8), SUPPORTED), (always(0.2), NOT), (alternating(0.2, 0.8), UNDECIDED)]
)
def test_claim_that_failures_are_missed_orients(share: Level, verdict: Verdict) -> None:
    rows = [
        failed(
            replication=i,
            recall=number,
            wrong_by_state=counts(
                {State.NEXT_TO_FOOD: 150, State.SEARCH: 50}
                if number < 10 * share(i)
                else {State.NEXT_TO_FOOD: 50, State.SEARCH: 150}
            ),
        )
        for i, number in product(range(REPLICATIONS), range(10))
    ]
    deliveries = [recall(replication=i, recall=10 + i) for i in range(REPLICATIONS)]
    assert claim_from("failures", rows + deliveries).verdict is verdict


@pytest.mark.parametrize(
    ("wrong", "verdict"), [(always(2), SUPPORTED), (always(30), NOT), (alternating(2, 18), UNDECIDED)]
)
def test_claim_that_all_is_correct_after_orient(wrong: Level, verdict: Verdict) -> None:
    """`wrong` of 100 rounds with food in hand are wrong; wrong rounds of SEARCH do not count."""
    rows = [
        recall(
            replication=i,
            correct=150 - int(wrong(i)),
            wrong_by_state=counts({State.FOOD_IN_HAND: int(wrong(i)), State.SEARCH: 50}),
            rounds_by_state=counts({State.FOOD_IN_HAND: 100, State.SEARCH: 100}),
        )
        for i in range(REPLICATIONS)
    ]
    assert claim_from("rest", rows).verdict is verdict
