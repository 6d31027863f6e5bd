"""Claims about learning and time: each can be supported, not supported or undecided."""

import numpy as np
import pytest

from khepera_forage.rollouts.rows import RANDOM, TEACHER
from khepera_forage.thesis.claims import Verdict
from khepera_forage.thesis.design import LABORATORY, NO_LOSSES
from tests.thesis.claim_rows import (
    NOT,
    REPLICATIONS,
    SUPPORTED,
    UNDECIDED,
    Level,
    alternating,
    always,
    attempts_per_file,
    claim_from,
    recalls_with_scores,
    recalls_with_success,
)
from tests.thesis.synthetic import failed, recall


@pytest.mark.parametrize("arena", ["corridor", "rectangle"])
@pytest.mark.parametrize(
    ("ten", "verdict"), [(always(70), SUPPORTED), (always(30), NOT), (alternating(30, 70), UNDECIDED)]
)
def test_claim_that_more_episodes_improve(arena: str, ten: Level, verdict: Verdict) -> None:
    claim = claim_from(f"improves {arena}", recalls_with_scores(arena, {1: alternating(45, 55), 10: ten}))
    assert claim.verdict is verdict
    assert arena in claim.name


@pytest.mark.parametrize("arena", ["corridor", "rectangle"])
@pytest.mark.parametrize(
    ("levels", "verdict"),
    [
        ((always(40), always(60), alternating(61, 62), always(65)), SUPPORTED),
        ((always(40), always(41), alternating(42, 43), always(90)), NOT),
        ((alternating(20, 60), always(45), always(45), always(50)), UNDECIDED),
    ],
)
def test_claim_that_the_gain_shrinks(arena: str, levels: tuple[Level, ...], verdict: Verdict) -> None:
    rows = recalls_with_scores(arena, dict(zip((1, 3, 5, 10), levels, strict=True)))
    assert claim_from(f"shrinks {arena}", rows).verdict is verdict


@pytest.mark.parametrize(
    ("learner", "chance", "verdict"),
    [
        (always(0.6), always(0.1), SUPPORTED),
        (always(0.1), always(0.3), NOT),
        (alternating(0.1, 0.3), always(0.2), UNDECIDED),
    ],
)
def test_claim_that_the_learner_generalises(learner: Level, chance: Level, verdict: Verdict) -> None:
    rows = recalls_with_success(40, learner, arena="rectangle") + recalls_with_success(
        40, chance, arena="rectangle", learner=RANDOM
    )
    assert claim_from("generalises", rows).verdict is verdict


def test_claim_of_generalising_without_a_random_policy_is_undecided() -> None:
    claim = claim_from("generalises", recalls_with_success(40, always(0.6), arena="rectangle"))
    assert claim.verdict is UNDECIDED
    assert claim.effect == "-"


@pytest.mark.parametrize(
    ("corridor", "verdict"),
    [
        (alternating(60, 64), SUPPORTED),
        (always(80), NOT),
        (always(30), NOT),
        (alternating(60, 80), UNDECIDED),
    ],
)
def test_claim_that_the_arenas_are_comparable(corridor: Level, verdict: Verdict) -> None:
    rows = recalls_with_scores("corridor", {10: corridor}) + recalls_with_scores(
        "rectangle", {10: alternating(59, 61)}
    )
    assert claim_from("comparable", rows).verdict is verdict


@pytest.mark.parametrize(
    ("laboratory", "verdict"), [(always(3), SUPPORTED), (always(1), NOT), (alternating(1, 3), UNDECIDED)]
)
def test_claim_that_losses_cost_attempts(laboratory: Level, verdict: Verdict) -> None:
    rows = attempts_per_file(LABORATORY, laboratory) + attempts_per_file(NO_LOSSES, always(2))
    claim = claim_from("losses", trainings=rows)
    assert claim.verdict is verdict
    assert claim.value == pytest.approx(np.mean([laboratory(i) for i in range(REPLICATIONS)]) - 2)


@pytest.mark.parametrize(
    ("attempts", "verdict"), [(always(1), SUPPORTED), (always(3), NOT), (alternating(1, 3), UNDECIDED)]
)
def test_claim_that_episodes_are_often_complete_without_losses(attempts: Level, verdict: Verdict) -> None:
    rows = attempts_per_file(NO_LOSSES, attempts) + attempts_per_file(LABORATORY, always(5))
    assert claim_from("frequent", trainings=rows).verdict is verdict


@pytest.mark.parametrize(("arena", "limit"), [("corridor", 500), ("rectangle", 700)])
@pytest.mark.parametrize(
    ("over", "verdict"),
    [(always(0), SUPPORTED), (always(400), NOT), (lambda replication: replication == 1, UNDECIDED)],
)
def test_claim_that_the_limit_is_enough(arena: str, limit: int, over: Level, verdict: Verdict) -> None:
    """Undecided if one forage of eight took a step more than the limit: the quantile depends on the resample."""
    steps = [limit + int(over(i)) for i in range(REPLICATIONS)]
    rows = [
        recall(arena=arena, learner=TEACHER, episodes=0, replication=i, steps=s, correct=s, limit=3000)
        for i, s in enumerate(steps)
    ]
    assert claim_from(f"limit {arena}", teachers=rows).verdict is verdict


def test_claim_of_the_limit_is_not_supported_if_the_teacher_fails() -> None:
    rows = [failed(learner=TEACHER, episodes=0, replication=i, steps=400, limit=400) for i in range(5)]
    claim = claim_from("limit corridor", teachers=rows)
    assert claim.verdict is NOT
    assert claim.effect == "∞ [∞, ∞] steps"
