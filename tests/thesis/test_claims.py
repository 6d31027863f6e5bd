"""The thesis's claims: each can be supported, not supported or undecided; and the rules of the verdicts."""

from collections.abc import Callable, Iterator, Sequence
from functools import partial
from itertools import product
from typing import Any

import numpy as np
import pytest

from khepera_forage.estimates import UNKNOWN, Estimate
from khepera_forage.rollouts.rows import RANDOM, TEACHER, RecallRow, TrainingRow
from khepera_forage.task.decisions import DEFAULT_DECISIONS, Decisions, decisions_text
from khepera_forage.task.states import State
from khepera_forage.thesis.claims import (
    Claim,
    Rule,
    Verdict,
    above,
    at_most,
    beyond,
    claims,
    gather,
    percent,
    percent_change,
    points,
    within,
)
from khepera_forage.thesis.design import LABORATORY, NO_LOSSES, training_distance
from tests.thesis.synthetic import counts, failed, recall, training

REPLICATIONS = 8
NAMES = (
    *("improves corridor", "improves rectangle", "shrinks corridor", "shrinks rectangle", "generalises"),
    *("comparable", "areas corridor", "areas rectangle", "around corridor", "around rectangle"),
    *("orient without food corridor", "orient without food rectangle", "failures", "rest", "losses"),
    *("frequent", "limit corridor", "limit rectangle"),
)
"""Names of the claims in the order of the report."""
Level = Callable[[int], float]
"""A number for each replication."""
SUPPORTED, NOT, UNDECIDED = Verdict.SUPPORTED, Verdict.NOT_SUPPORTED, Verdict.UNDECIDED


def always(value: float) -> Level:
    return lambda replication: value


def alternating(low: float, high: float) -> Level:
    """`low` in even replications and `high` in odd ones."""
    return lambda replication: (low, high)[replication % 2]


def claim_from(name: str, recalls: Sequence[RecallRow] = (), trainings: Sequence[TrainingRow] = ()) -> Claim:
    return claims(gather(recalls, trainings, np.random.default_rng(3), 400))[NAMES.index(name)]


def recalls_with_scores(arena: str, levels: dict[int, Level]) -> list[RecallRow]:
    """One recall with this score for each replication and cell."""
    return [
        recall(arena=arena, replication=i, episodes=episodes, steps=100, correct=int(level(i)))
        for episodes, level in levels.items()
        for i in range(REPLICATIONS)
    ]


def recalls_with_success(distance: float, level: Level, each: int = 10, **changes: Any) -> list[RecallRow]:
    """Recalls with food at this distance from home; this share of them deliver it."""
    return [
        (recall if number < each * level(i) else failed)(
            replication=i, recall=number, food_x=(-distance,), **changes
        )
        for i, number in product(range(REPLICATIONS), range(each))
    ]


def attempts_per_file(noise: str, level: Level) -> list[TrainingRow]:
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


def generalises(learner: Level, chance: Level | None = None) -> list[RecallRow]:
    rows = recalls_with_success(40, learner, arena="rectangle")
    return rows + (recalls_with_success(40, chance, arena="rectangle", learner=RANDOM) if chance else [])


def sides(arena: str, near: Level, far: Level) -> list[RecallRow]:
    """Recalls with food nearer to home than in training, and further away."""
    return recalls_with_success(25, near, arena=arena) + recalls_with_success(70, far, arena=arena)


def both_sides(corridor: tuple[float, float], rectangle: tuple[float, float]) -> list[RecallRow]:
    return sides("corridor", *map(always, corridor)) + sides("rectangle", *map(always, rectangle))


def around(arena: str, decisions: Decisions, there: Level) -> list[RecallRow]:
    """Food at the training distance, and where success has a chance of one half."""
    distance = training_distance(decisions)
    more: dict[str, Any] = {"arena": arena, "decisions": decisions_text(decisions)}
    rows = recalls_with_success(distance + 5.9, there, **more)
    for elsewhere in (distance - 6.1, distance + 6.1):
        rows += recalls_with_success(elsewhere, always(0.5), **more)
    return rows


def orients(arena: str, share: Level) -> list[RecallRow]:
    return [
        recall(arena=arena, replication=i, recall=number, orient_without_food=3 * (number < 10 * share(i)))
        for i, number in product(range(REPLICATIONS), range(10))
    ]


def missed(share: Level) -> list[RecallRow]:
    """This share of the failures had most wrong rounds next to food; deliveries do not count."""
    often, seldom = (counts({State.NEXT_TO_FOOD: n, State.SEARCH: 200 - n}) for n in (150, 50))
    return [
        failed(replication=i, recall=number, wrong_by_state=often if number < 10 * share(i) else seldom)
        for i, number in product(range(REPLICATIONS), range(10))
    ] + [recall(replication=i, recall=10 + i) for i in range(REPLICATIONS)]


def wrong_after_orient(wrong: Level) -> list[RecallRow]:
    """So many of 100 rounds with food in hand are wrong; wrong rounds of SEARCH do not count."""
    return [
        recall(
            replication=i,
            correct=150 - int(wrong(i)),
            wrong_by_state=counts({State.FOOD_IN_HAND: int(wrong(i)), State.SEARCH: 50}),
            rounds_by_state=counts({State.FOOD_IN_HAND: 100, State.SEARCH: 100}),
        )
        for i in range(REPLICATIONS)
    ]


def forages(arena: str, limit: int, over: Level) -> list[RecallRow]:
    steps = [limit + int(over(i)) for i in range(REPLICATIONS)]
    return [
        recall(arena=arena, learner=TEACHER, episodes=0, replication=i, steps=s, correct=s, limit=3000)
        for i, s in enumerate(steps)
    ]


Case = tuple[str, dict[str, Callable[[], Sequence[Any]]], Verdict]


def graded(claim: str, rows: Callable[[Level], Any], *levels: Level, kind: str = "recalls") -> Iterator[Case]:
    """Levels that support a claim, contradict it, and leave it undecided."""
    for level, verdict in zip(levels, (SUPPORTED, NOT, UNDECIDED), strict=True):
        yield claim, {kind: partial(rows, level)}, verdict


def cases() -> Iterator[Case]:
    for arena, limit in (("corridor", 500), ("rectangle", 700)):

        def scores(ten: Level, arena: str = arena) -> list[RecallRow]:
            return recalls_with_scores(arena, {1: alternating(45, 55), 10: ten})

        yield from graded(f"improves {arena}", scores, always(70), always(30), alternating(30, 70))
        for levels, verdict in (
            ((always(40), always(60), alternating(61, 62), always(65)), SUPPORTED),
            ((always(40), always(41), alternating(42, 43), always(90)), NOT),
            ((alternating(20, 60), always(45), always(45), always(50)), UNDECIDED),
        ):
            found = dict(zip((1, 3, 5, 10), levels, strict=True))
            yield f"shrinks {arena}", {"recalls": partial(recalls_with_scores, arena, found)}, verdict
        for decisions in (DEFAULT_DECISIONS, Decisions(food_to_home=220)):
            there = partial(around, arena, decisions)
            yield from graded(f"around {arena}", there, always(0.9), always(0.1), alternating(0.1, 0.9))
        orienting = partial(orients, arena)
        shares = always(0.5), always(0.0), alternating(0.0, 0.3)
        yield from graded(f"orient without food {arena}", orienting, *shares)
        # One forage of eight a step too long: the quantile depends on the resample.
        over: tuple[Level, ...] = (always(0), always(400), lambda replication: replication == 1)
        yield from graded(f"limit {arena}", partial(forages, arena, limit), *over)
    for learner, chance, verdict in (
        (always(0.6), always(0.1), SUPPORTED),
        (always(0.1), always(0.3), NOT),
        (alternating(0.1, 0.3), always(0.2), UNDECIDED),
        (always(0.6), None, UNDECIDED),
    ):
        yield "generalises", {"recalls": partial(generalises, learner, chance)}, verdict
    for corridor, verdict in (
        (alternating(60, 64), SUPPORTED),
        (always(80), NOT),
        (always(30), NOT),
        (alternating(60, 80), UNDECIDED),
    ):

        def arenas(corridor: Level = corridor) -> list[RecallRow]:
            rectangle = recalls_with_scores("rectangle", {10: alternating(59, 61)})
            return recalls_with_scores("corridor", {10: corridor}) + rectangle

        yield "comparable", {"recalls": arenas}, verdict
    for near, far, verdict in (
        (always(0.9), always(0.2), SUPPORTED),
        (always(0.2), always(0.9), SUPPORTED),
        (always(0.5), always(0.5), NOT),
        (alternating(0.2, 1.0), always(0.5), UNDECIDED),
    ):
        yield "areas corridor", {"recalls": partial(sides, "corridor", near, far)}, verdict
    # The rectangle follows the direction of the corridor.
    for best, verdict in (((0.8, 0.3), SUPPORTED), ((0.3, 0.8), NOT), ((0.5, 0.5), NOT)):
        yield "areas rectangle", {"recalls": partial(both_sides, (0.9, 0.2), best)}, verdict
        yield "areas rectangle", {"recalls": partial(both_sides, (0.2, 0.9), (best[1], best[0]))}, verdict
    yield from graded("failures", missed, always(0.8), always(0.2), alternating(0.2, 0.8))
    yield from graded("rest", wrong_after_orient, always(2), always(30), alternating(2, 18))

    def losses(laboratory: Level) -> list[TrainingRow]:
        return attempts_per_file(LABORATORY, laboratory) + attempts_per_file(NO_LOSSES, always(2))

    def without(attempts: Level) -> list[TrainingRow]:
        return attempts_per_file(NO_LOSSES, attempts) + attempts_per_file(LABORATORY, always(5))

    yield from graded("losses", losses, always(3), always(1), alternating(1, 3), kind="trainings")
    yield from graded("frequent", without, always(1), always(3), alternating(1, 3), kind="trainings")


@pytest.mark.parametrize(("name", "rows", "verdict"), list(cases()))
def test_claim_has_its_verdict(
    name: str, rows: dict[str, Callable[[], Sequence[Any]]], verdict: Verdict
) -> None:
    assert claim_from(name, **{kind: make() for kind, make in rows.items()}).verdict is verdict


def test_effects_are_in_the_units_of_the_claims() -> None:
    rows = recalls_with_scores("corridor", {1: always(40), 10: always(70)})
    single = claim_from("improves corridor", [row for row in rows if row.replication == 0])
    assert (single.effect, single.verdict) == ("+30.0 points", UNDECIDED)
    assert claim_from("generalises", generalises(always(0.6))).effect == "-"
    lost = [failed(learner=TEACHER, episodes=0, replication=i, steps=400, limit=400) for i in range(5)]
    limit = claim_from("limit corridor", lost)
    assert (limit.effect, limit.verdict) == ("∞ [∞, ∞] steps", NOT)


def test_claims_without_rows_are_undecided() -> None:
    judged = claims(gather([], [], np.random.default_rng(1)))
    assert {claim.verdict for claim in judged} == {UNDECIDED}
    assert {claim.effect for claim in judged} == {"-"}
    assert len({claim.name for claim in judged}) == len(judged) == len(NAMES)
    assert all("nan" not in claim.sentence for claim in judged)


def test_claims_from_two_noise_conditions_are_an_error() -> None:
    rows = [recall(), recall(noise="none", recall=1)]
    with pytest.raises(ValueError, match=r"noise conditions \['laboratory', 'none'\]; allowed: one"):
        gather(rows, [], np.random.default_rng(1))


@pytest.mark.parametrize(
    ("rule", "estimate", "verdict"),
    [
        (above(0.5), Estimate(0.6, 0.51, 0.7), SUPPORTED),
        (above(0.5), Estimate(0.6, 0.5, 0.7), UNDECIDED),
        (above(0.5), Estimate(0.4, 0.3, 0.49), NOT),
        (above(0), Estimate(0, 0, 0), NOT),
        (at_most(500.0), Estimate(480.0, 470.0, 500.0), SUPPORTED),
        (at_most(500.0), Estimate(520.0, 501.0, 600.0), NOT),
        (within(10.0), Estimate(0.0, -9.0, 9.0), SUPPORTED),
        (within(10.0), Estimate(0.0, -11.0, 9.0), UNDECIDED),
        (within(10.0), Estimate(-20.0, -30.0, -11.0), NOT),
        (beyond(0.1), Estimate(-0.3, -0.5, -0.11), SUPPORTED),
        (beyond(0.1), Estimate(0.0, -0.05, 0.05), NOT),
        (beyond(0.1), Estimate(0.0, -0.5, 0.5), UNDECIDED),
        *((rule, UNKNOWN, UNDECIDED) for rule in (above(0), at_most(0), within(1), beyond(1))),
    ],
)
def test_rule_gives_its_verdict(rule: Rule, estimate: Estimate, verdict: Verdict) -> None:
    assert rule.judge(estimate) is verdict


def test_rules_and_effects_have_a_text() -> None:
    assert above(0.5).words(percent) == "supported above 50 %, not supported below"
    assert (
        within(10.0).words(points) == "supported between -10.0 points and +10.0 points, not supported beyond"
    )
    assert percent_change.estimate(Estimate(0.125, -0.02, 0.3)) == "+12 [-2, +30] points"
    assert points.estimate(Estimate(0.0, float("nan"), float("nan"))) == "0 points"
