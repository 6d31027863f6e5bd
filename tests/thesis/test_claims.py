"""All claims together, and the rules of their verdicts."""

import numpy as np
import pytest

from khepera_forage.estimates import UNKNOWN, Estimate
from khepera_forage.thesis.claims import Verdict, claims
from khepera_forage.thesis.claims.claim import (
    Rule,
    above,
    at_most,
    beyond,
    percent,
    percent_change,
    points,
    within,
)
from tests.thesis.claim_rows import NOT, NUMBER, SUPPORTED, UNDECIDED, always, claim_from, recalls_with_scores
from tests.thesis.synthetic import recall


def test_claims_without_rows_are_undecided() -> None:
    judged = claims([], [], [], np.random.default_rng(1))
    assert {claim.verdict for claim in judged} == {UNDECIDED}
    assert {claim.effect for claim in judged} == {"-"}
    assert len({claim.name for claim in judged}) == len(judged) == len(NUMBER)
    assert all("nan" not in claim.sentence for claim in judged)


def test_claims_from_one_replication_have_an_effect_and_are_undecided() -> None:
    rows = [
        row
        for row in recalls_with_scores("corridor", {1: always(40), 10: always(70)})
        if row.replication == 0
    ]
    claim = claim_from("improves corridor", rows)
    assert claim.effect == "+30.0 points"
    assert claim.verdict is UNDECIDED


def test_claims_from_two_noise_conditions_are_an_error() -> None:
    rows = [recall(), recall(noise="none", recall=1)]
    with pytest.raises(ValueError, match=r"noise conditions \['laboratory', 'none'\]; allowed: one"):
        claims(rows, [], [], np.random.default_rng(1))


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
