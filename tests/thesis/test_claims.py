"""The thesis's claims: their effects are those of the rows, and the rules give the verdicts."""

import csv
import math
import zipfile
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest

from khepera_forage.estimates import Estimate, pick
from khepera_forage.rollouts.rows import RANDOM, TEACHER, RecallRow, TrainingRow
from khepera_forage.task.decisions import Decisions, decisions_text
from khepera_forage.task.states import State
from khepera_forage.thesis.claims import AFTER_ORIENT, Rule, Verdict, above, at_most, claims, gather, within
from khepera_forage.thesis.design import LABORATORY, NO_LOSSES, THESIS, training_distance
from tests.thesis.conftest import PUBLISHED
from tests.thesis.synthetic import failed, recall

SUPPORTED, NOT, UNDECIDED = Verdict.SUPPORTED, Verdict.NOT_SUPPORTED, Verdict.UNDECIDED
ARENAS = ("corridor", "rectangle")


def rng() -> np.random.Generator:
    return np.random.default_rng(3)


def delivered(rows: Sequence[RecallRow], least: float = 0, most: float = math.inf) -> float:
    """The share of the food between two distances from home that was delivered."""
    done = [
        done
        for row in rows
        for distance, done in zip(row.food_home_distances, row.food_delivered, strict=True)
        if least <= distance < most
    ]
    return float(np.mean(done))


def effects(rows: list[RecallRow], trainings: list[TrainingRow], training: float) -> list[float]:
    """The effect of each claim in the order of the report, computed plainly."""
    own = {arena: pick(rows, arena=arena, learner="imitator") for arena in ARENAS}
    cells = [(cell.arena, cell.episodes) for cell in THESIS]
    score = {(a, n): np.mean([row.score for row in pick(own[a], episodes=n)]) for a, n in cells}
    shrinking = [
        (score[a, n] - score[a, 1]) / (n - 1) - (score[a, 10] - score[a, 5]) / 5
        for a, n in (("corridor", 3), ("rectangle", 5))
    ]
    lost = pick(own["corridor"], failed=True)
    after = [(r.rounds_by_state[s], r.wrong_by_state[s]) for r in own["corridor"] for s in AFTER_ORIENT]
    spent, wrong = np.sum(after, axis=0)
    tries = {noise: pick(trainings, noise=noise) for noise in (LABORATORY, NO_LOSSES)}
    complete = {noise: np.mean([row.complete for row in own]) for noise, own in tries.items()}
    teacher = [pick(rows, arena=arena, learner=TEACHER) for arena in ARENAS]
    steps = [[math.inf if row.failed else row.steps for row in forages] for forages in teacher]
    return [
        *(score[arena, 10] - score[arena, 1] for arena in ARENAS),
        *shrinking,
        delivered(pick(own["rectangle"], episodes=10)) - delivered(pick(rows, arena="rectangle", learner=RANDOM)),
        score["corridor", 10] - score["rectangle", 10],
        *(delivered(own[a], 0, training) - delivered(own[a], training) for a in ARENAS),
        *(np.mean([row.orient_without_food > 0 for row in own[a]]) for a in ARENAS),
        np.mean([row.failure_mode == State.NEXT_TO_FOOD for row in lost]),
        1 - wrong / spent,
        1 / complete[LABORATORY] - 1 / complete[NO_LOSSES],
        complete[NO_LOSSES],
        *(np.quantile(needed, 0.95, method="inverted_cdf") for needed in steps),
    ]


@pytest.mark.parametrize("decisions", [Decisions(), Decisions(food_to_home=220)], ids=["default", "other"])
def test_effects_are_those_of_the_rows(
    decisions: Decisions, recalls: list[RecallRow], trainings: list[TrainingRow]
) -> None:
    text = decisions_text(decisions)
    rows = [replace(row, decisions=text) for row in recalls]
    tries = [replace(row, decisions=text) for row in trainings]
    found = claims(gather(rows, tries, rng(), 200))
    wanted = effects(rows, tries, training_distance(decisions))
    for claim, value in zip(found, wanted, strict=True):
        assert claim.estimate.value == pytest.approx(value), claim.name
        assert claim.estimate.low <= claim.estimate.value <= claim.estimate.high, claim.name


def test_claims_without_rows_are_undecided_and_have_the_published_names_and_rules() -> None:
    found = claims(gather([], [], rng()))
    for claim in found:
        assert (claim.verdict, claim.effect) == (UNDECIDED, "-")
        assert "nan" not in claim.sentence
    with zipfile.ZipFile(PUBLISHED) as archive:
        names, rules = (csv.DictReader(archive.read(f"{of}.csv").decode().splitlines()) for of in ("claims", "rules"))
    assert [claim.name for claim in found] == [row["claim"] for row in names]
    assert [claim.rule.words(claim.unit) for claim in found] == [row["rule"] for row in rules]


def test_effects_are_in_the_units_of_the_claims() -> None:
    rows = [recall(episodes=n, steps=100, correct=score) for n, score in ((1, 40), (10, 70))]
    rows += [failed(episodes=5, replication=i, food_x=(-25.0,)) for i in range(5)]
    rows += [failed(learner=TEACHER, episodes=0, replication=i, steps=400, limit=400) for i in range(5)]
    found = claims(gather(rows, [], rng()))
    assert (found[0].effect, found[0].verdict) == ("+30.0 points", UNDECIDED)
    assert (found[6].effect, found[6].verdict) == ("-100 [-100, -100] points", NOT)
    assert "0 % of 5 food objects nearer to home than the 36 pixels of training, 100 % of 2" in found[6].sentence
    assert (found[-2].effect, found[-2].verdict) == ("∞ [∞, ∞] steps", NOT)


def test_claims_from_two_noise_conditions_are_an_error() -> None:
    rows = [recall(), recall(noise="none", recall=1)]
    with pytest.raises(ValueError, match=r"noise conditions \['laboratory', 'none'\]; allowed: one"):
        gather(rows, [], rng())


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
    ],
)
def test_rule_gives_its_verdict(rule: Rule, estimate: Estimate, verdict: Verdict) -> None:
    assert rule.judge(estimate) is verdict
