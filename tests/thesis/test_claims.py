"""Every claim can be supported, not supported or undecided."""

from collections.abc import Callable, Sequence
from itertools import product

import numpy as np
import pytest

from khepera_forage.rollouts.rows import RANDOM, TEACHER, RecallRow, TrainingRow
from khepera_forage.task.states import State
from khepera_forage.thesis.claims import Claim, Verdict, claims
from khepera_forage.thesis.claims.claim import (
    Above,
    AtMost,
    Beyond,
    Rule,
    Within,
    percent,
    percent_change,
    points,
)
from khepera_forage.thesis.design import LABORATORY, NO_LOSSES, TRAINING_DISTANCE
from khepera_forage.thesis.statistics import UNKNOWN, Estimate
from tests.thesis.synthetic import counts, failed, recall, training

REPLICATIONS = 8
NUMBER = {
    "improves corridor": 1,
    "improves rectangle": 2,
    "shrinks corridor": 3,
    "shrinks rectangle": 4,
    "generalises": 5,
    "comparable": 6,
    "areas corridor": 7,
    "areas rectangle": 8,
    "around corridor": 9,
    "around rectangle": 10,
    "orient without food corridor": 11,
    "orient without food rectangle": 12,
    "failures": 13,
    "rest": 14,
    "losses": 15,
    "frequent": 16,
    "limit corridor": 17,
    "limit rectangle": 18,
}
"""Number of each claim in the report."""
Level = Callable[[int], float]
"""A number for each replication."""
SUPPORTED, NOT, UNDECIDED = Verdict.SUPPORTED, Verdict.NOT_SUPPORTED, Verdict.UNDECIDED


def always(value: float) -> Level:
    return lambda replication: value


def alternating(low: float, high: float) -> Level:
    """`low` in even replications and `high` in odd ones."""
    return lambda replication: (low, high)[replication % 2]


def _judge(
    name: str,
    recalls: Sequence[RecallRow] = (),
    trainings: Sequence[TrainingRow] = (),
    teachers: Sequence[RecallRow] = (),
) -> Claim:
    return claims(recalls, trainings, teachers, np.random.default_rng(3), 400)[NUMBER[name] - 1]


def _scores(arena: str, levels: dict[int, Level]) -> list[RecallRow]:
    """One recall with this score for each replication and cell."""
    return [
        recall(arena=arena, replication=i, episodes=episodes, steps=100, correct=int(level(i)))
        for episodes, level in levels.items()
        for i in range(REPLICATIONS)
    ]


def _successes(distance: float, level: Level, each: int = 10, **changes: object) -> list[RecallRow]:
    """Recalls with food at this distance from home; this share of them deliver it."""
    return [
        (recall if number < each * level(i) else failed)(
            replication=i, recall=number, food_x=(-distance,), **changes
        )
        for i, number in product(range(REPLICATIONS), range(each))
    ]


def _attempts(noise: str, level: Level) -> list[TrainingRow]:
    """Episodes that need this many attempts each, three for each replication."""
    return [
        training(
            replication=i,
            file=file,
            attempt=number,
            noise=noise,
            reason="" if number == level(i) else "separated",
        )
        for i, file in product(range(REPLICATIONS), range(1, 4))
        for number in range(1, int(level(i)) + 1)
    ]


@pytest.mark.parametrize("arena", ["corridor", "rectangle"])
@pytest.mark.parametrize(
    ("ten", "verdict"), [(always(70), SUPPORTED), (always(30), NOT), (alternating(30, 70), UNDECIDED)]
)
def test_claim_that_more_episodes_improve(arena: str, ten: Level, verdict: Verdict) -> None:
    claim = _judge(f"improves {arena}", _scores(arena, {1: alternating(45, 55), 10: ten}))
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
    rows = _scores(arena, dict(zip((1, 3, 5, 10), levels, strict=True)))
    assert _judge(f"shrinks {arena}", rows).verdict is verdict


@pytest.mark.parametrize(
    ("learner", "chance", "verdict"),
    [
        (always(0.6), always(0.1), SUPPORTED),
        (always(0.1), always(0.3), NOT),
        (alternating(0.1, 0.3), always(0.2), UNDECIDED),
    ],
)
def test_claim_that_the_learner_generalises(learner: Level, chance: Level, verdict: Verdict) -> None:
    rows = _successes(40, learner, arena="rectangle") + _successes(
        40, chance, arena="rectangle", learner=RANDOM
    )
    assert _judge("generalises", rows).verdict is verdict


def test_claim_of_generalising_without_a_random_policy_is_undecided() -> None:
    claim = _judge("generalises", _successes(40, always(0.6), arena="rectangle"))
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
    rows = _scores("corridor", {10: corridor}) + _scores("rectangle", {10: alternating(59, 61)})
    assert _judge("comparable", rows).verdict is verdict


@pytest.mark.parametrize("arena", ["corridor", "rectangle"])
@pytest.mark.parametrize(
    ("near", "far", "verdict"),
    [
        (always(0.9), always(0.2), SUPPORTED),
        (always(0.2), always(0.9), SUPPORTED),
        (always(0.5), always(0.5), NOT),
        (alternating(0.2, 1.0), always(0.5), UNDECIDED),
    ],
)
def test_claim_that_success_depends_on_the_area(
    arena: str, near: Level, far: Level, verdict: Verdict
) -> None:
    rows = _successes(25, near, arena=arena) + _successes(70, far, arena=arena)
    assert _judge(f"areas {arena}", rows).verdict is verdict


@pytest.mark.parametrize("arena", ["corridor", "rectangle"])
@pytest.mark.parametrize(
    ("there", "verdict"), [(always(0.9), SUPPORTED), (always(0.1), NOT), (alternating(0.1, 0.9), UNDECIDED)]
)
def test_claim_that_success_is_best_at_the_training_distance(
    arena: str, there: Level, verdict: Verdict
) -> None:
    rows = _successes(TRAINING_DISTANCE + 5.9, there, arena=arena)
    for elsewhere in (TRAINING_DISTANCE - 6.1, TRAINING_DISTANCE + 6.1):
        rows += _successes(elsewhere, always(0.5), arena=arena)
    assert _judge(f"around {arena}", rows).verdict is verdict


@pytest.mark.parametrize("arena", ["corridor", "rectangle"])
@pytest.mark.parametrize(
    ("share", "verdict"), [(always(0.5), SUPPORTED), (always(0.0), NOT), (alternating(0.0, 0.3), UNDECIDED)]
)
def test_claim_that_orient_is_executed_without_food(arena: str, share: Level, verdict: Verdict) -> None:
    rows = [
        recall(arena=arena, replication=i, recall=number, orient_without_food=3 * (number < 10 * share(i)))
        for i, number in product(range(REPLICATIONS), range(10))
    ]
    assert _judge(f"orient without food {arena}", rows).verdict is verdict


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
    assert _judge("failures", rows + deliveries).verdict is verdict


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
    assert _judge("rest", rows).verdict is verdict


@pytest.mark.parametrize(
    ("laboratory", "verdict"), [(always(3), SUPPORTED), (always(1), NOT), (alternating(1, 3), UNDECIDED)]
)
def test_claim_that_losses_cost_attempts(laboratory: Level, verdict: Verdict) -> None:
    rows = _attempts(LABORATORY, laboratory) + _attempts(NO_LOSSES, always(2))
    claim = _judge("losses", trainings=rows)
    assert claim.verdict is verdict
    assert claim.value == pytest.approx(np.mean([laboratory(i) for i in range(REPLICATIONS)]) - 2)


@pytest.mark.parametrize(
    ("attempts", "verdict"), [(always(1), SUPPORTED), (always(3), NOT), (alternating(1, 3), UNDECIDED)]
)
def test_claim_that_episodes_are_often_complete_without_losses(attempts: Level, verdict: Verdict) -> None:
    rows = _attempts(NO_LOSSES, attempts) + _attempts(LABORATORY, always(5))
    assert _judge("frequent", trainings=rows).verdict is verdict


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
    assert _judge(f"limit {arena}", teachers=rows).verdict is verdict


def test_claim_of_the_limit_is_not_supported_if_the_teacher_fails() -> None:
    rows = [failed(learner=TEACHER, episodes=0, replication=i, steps=400, limit=400) for i in range(5)]
    claim = _judge("limit corridor", teachers=rows)
    assert claim.verdict is NOT
    assert claim.effect == "∞ [∞, ∞] steps"


def test_claims_without_rows_are_undecided() -> None:
    judged = claims([], [], [], np.random.default_rng(1))
    assert {claim.verdict for claim in judged} == {UNDECIDED}
    assert {claim.effect for claim in judged} == {"-"}
    assert len({claim.name for claim in judged}) == len(judged) == len(NUMBER)
    assert all("nan" not in claim.sentence for claim in judged)


def test_claims_from_one_replication_have_an_effect_and_are_undecided() -> None:
    rows = [row for row in _scores("corridor", {1: always(40), 10: always(70)}) if row.replication == 0]
    claim = _judge("improves corridor", rows)
    assert claim.effect == "+30.0 points"
    assert claim.verdict is UNDECIDED


def test_claims_from_two_noise_conditions_are_an_error() -> None:
    rows = [recall(), recall(noise="none", recall=1)]
    with pytest.raises(ValueError, match=r"noise conditions \['laboratory', 'none'\]; allowed: one"):
        claims(rows, [], [], np.random.default_rng(1))


@pytest.mark.parametrize(
    ("rule", "estimate", "verdict"),
    [
        (Above(0.5), Estimate(0.6, 0.51, 0.7), SUPPORTED),
        (Above(0.5), Estimate(0.6, 0.5, 0.7), UNDECIDED),
        (Above(0.5), Estimate(0.4, 0.3, 0.49), NOT),
        (AtMost(500.0), Estimate(480.0, 470.0, 500.0), SUPPORTED),
        (AtMost(500.0), Estimate(520.0, 501.0, 600.0), NOT),
        (Within(10.0), Estimate(0.0, -9.0, 9.0), SUPPORTED),
        (Within(10.0), Estimate(0.0, -11.0, 9.0), UNDECIDED),
        (Within(10.0), Estimate(-20.0, -30.0, -11.0), NOT),
        (Beyond(0.1), Estimate(-0.3, -0.5, -0.11), SUPPORTED),
        (Beyond(0.1), Estimate(0.0, -0.05, 0.05), NOT),
        (Beyond(0.1), Estimate(0.0, -0.5, 0.5), UNDECIDED),
        *((rule, UNKNOWN, UNDECIDED) for rule in (Above(0), AtMost(0), Within(1), Beyond(1))),
    ],
)
def test_rule_gives_its_verdict(rule: Rule, estimate: Estimate, verdict: Verdict) -> None:
    assert rule.judge(estimate) is verdict


def test_rules_and_effects_have_a_text() -> None:
    assert Above(0.5).text(percent) == "supported above 50 %, not supported below"
    assert (
        Within(10.0).text(points) == "supported between -10.0 points and +10.0 points, not supported beyond"
    )
    assert percent_change.estimate(Estimate(0.125, -0.02, 0.3)) == "+12 [-2, +30] points"
    assert points.estimate(Estimate(0.0, float("nan"), float("nan"))) == "0 points"
