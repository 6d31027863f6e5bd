"""The claims of the thesis, each with a measured effect, its interval and a verdict.

They are about learning (5.4, 5.5), where the learner succeeds (5.4.1.2), and time (5.3.1, 5.4).
"""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from enum import StrEnum
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from khepera_forage.estimates import RESAMPLES, Estimate, Sample, bootstrap_quantile, combined, pick
from khepera_forage.rollouts.rows import IMITATOR, RANDOM, TEACHER, RecallRow, TrainingRow, common_decisions
from khepera_forage.sim.arenas.thesis import CORRIDOR, THESIS_ARENAS
from khepera_forage.task.decisions import DEFAULT_DECISIONS, Decisions
from khepera_forage.task.states import State
from khepera_forage.thesis import appendix_a
from khepera_forage.thesis.design import LABORATORY, LIMITS, NO_LOSSES, training_distance


@dataclass(frozen=True, slots=True)
class Unit:
    """A unit of measurement; numbers are multiplied by `scale`, and written in the format `form`."""

    suffix: str
    form: str = ".0f"
    scale: float = 1.0

    def __call__(self, value: float) -> str:
        """A number with its unit; a dash for nan."""
        return self.estimate(Estimate(value))

    def estimate(self, estimate: Estimate) -> str:
        """A value with its interval in brackets, if it has one."""
        value, low, high = map(self._number, estimate)
        limits = "" if low == "-" else f" [{low}, {high}]"
        return value if value == "-" else f"{value}{limits} {self.suffix}"

    def _number(self, value: float) -> str:
        if math.isnan(value):
            return "-"
        if value == 0:
            return "0"
        return f"{self.scale * value:{self.form}}" if math.isfinite(value) else "∞"


points = Unit("points", "+.1f")
"""Percentage points of the score."""
percent = Unit("%", scale=100.0)
"""A share, in percent."""
percent_change = Unit("points", "+.0f", 100.0)
"""A difference of two shares, in percentage points."""
_fine, _fine_percent = Unit("%", ".4g"), Unit("%", ".1f", 100.0)


class Verdict(StrEnum):
    """The result of measuring a claim."""

    SUPPORTED = "supported"
    NOT_SUPPORTED = "not supported"
    UNDECIDED = "undecided"


class Rule(NamedTuple):
    """Gives the verdict on an estimate.

    A claim is supported if the whole interval fulfils the rule, and not supported if none of it does. An estimate
    without interval, or with one that reaches across the threshold, is undecided.

    Attributes:
        kind: `above` or `at most` a threshold; `within` a margin around 0.
    """

    kind: str
    threshold: float

    def words(self, show: Unit) -> str:
        """The rule in words, with numbers in a unit."""
        end, other = show(self.threshold), show(-self.threshold)
        return {
            "above": f"supported above {end}, not supported below",
            "at most": f"supported up to {end}, not supported above",
            "within": f"supported between {other} and {end}, not supported beyond",
        }[self.kind]

    def judge(self, estimate: Estimate) -> Verdict:
        """The verdict; comparisons with nan are false."""
        (_, low, high), end = estimate, self.threshold
        supported, not_supported = {
            "above": (low > end, high <= end),
            "at most": (high <= end, low > end),
            "within": (-end < low and high < end, low > end or high < -end),
        }[self.kind]
        if supported:
            return Verdict.SUPPORTED
        return Verdict.NOT_SUPPORTED if not_supported else Verdict.UNDECIDED


above, at_most, within = (partial(Rule, kind) for kind in ("above", "at most", "within"))


class Claim(NamedTuple):
    """One claim of the thesis, measured.

    Attributes:
        estimate: The measured effect with its 95 % interval; nan if there are no rows for it.
        thesis: The same effect in the thesis: its figure, or its words.
        sentence: The measurement in words, with its figures.
    """

    name: str
    thesis_section: str
    estimate: Estimate
    rule: Rule
    unit: Unit
    thesis: str = ""
    sentence: str = ""

    @property
    def effect(self) -> str:
        """The estimate with its unit and interval."""
        return self.unit.estimate(self.estimate)

    @property
    def verdict(self) -> Verdict:
        """Supported, not supported or undecided."""
        return self.rule.judge(self.estimate)


@dataclass(frozen=True)
class Evidence:
    """The rows of a reproduction.

    Attributes:
        recalls: Recalls of the imitator, under one noise condition.
        chance: Recalls of a policy that draws every behaviour uniformly; may be empty.
        trainings: Attempts at training episodes, under any noise conditions.
        teachers: Forages of the teacher alone, with a time limit well above the thesis's.
        rng: Draws the resamples of each interval.
    """

    recalls: Sequence[RecallRow]
    chance: Sequence[RecallRow]
    trainings: Sequence[TrainingRow]
    teachers: Sequence[RecallRow]
    rng: np.random.Generator
    resamples: int = RESAMPLES
    decisions: Decisions = DEFAULT_DECISIONS

    def mean(self, sample: Sample[Any]) -> Estimate:
        """The mean or share of a sample, with its interval."""
        return combined([(1.0, sample)], self.rng, self.resamples)

    def difference(self, sample: Sample[Any], other: Sample[Any]) -> Estimate:
        """The difference of two means, with resamples of the same replications for both."""
        return combined([(1.0, sample), (-1.0, other)], self.rng, self.resamples)

    def score(self, arena: str, episodes: int) -> Sample[RecallRow]:
        """The mean score of a cell, in percent."""
        return Sample(pick(self.recalls, arena=arena, episodes=episodes), lambda row: row.score)

    def scores(self, weights: Mapping[tuple[str, int], float]) -> Estimate:
        """A weighted sum of the mean scores of cells (arena, episodes), in percentage points."""
        terms = [(weight, self.score(*cell)) for cell, weight in weights.items()]
        return combined(terms, self.rng, self.resamples)


def gather(
    recalls: Sequence[RecallRow], trainings: Sequence[TrainingRow], rng: np.random.Generator, resamples: int = RESAMPLES
) -> Evidence:
    """The evidence of rows, with the recalls of all policies in one sequence.

    Raises:
        ValueError: The recalls of the imitator have several noise conditions, or the rows several decisions.
    """
    decisions = common_decisions(recalls, trainings)
    imitator, chance, teachers = (pick(recalls, learner=name) for name in (IMITATOR, RANDOM, TEACHER))
    conditions = sorted({row.noise for row in imitator})
    if len(conditions) > 1:
        raise ValueError(f"recalls have noise conditions {conditions}; allowed: one condition at a time")
    return Evidence(imitator, chance, trainings, teachers, rng, resamples, decisions)


def food_share(rows: Sequence[RecallRow], inside: Callable[[float], bool] = lambda distance: True) -> Sample[RecallRow]:
    """The share of food delivered, of the food whose distance from home in pixels is `inside`."""

    def delivered(row: RecallRow) -> float:
        places = zip(row.food_home_distances, row.food_delivered, strict=True)
        return sum(done and inside(distance) for distance, done in places)

    return Sample(rows, delivered, lambda row: sum(map(inside, row.food_home_distances)))


def attempts_per_episode(evidence: Evidence, noise: str) -> Sample[TrainingRow]:
    """Attempts per complete training episode under one noise condition."""
    rows = pick(evidence.trainings, noise=noise)
    return Sample(rows, lambda row: 1.0, lambda row: row.complete)


def steps_needed(row: RecallRow) -> float:
    """Steps until all food was delivered; infinite if that never happened."""
    return math.inf if row.failed else row.steps


SECTION = {"corridor": "5.4.1.2", "rectangle": "5.4.2.2"}
LIMIT_SECTION = {"corridor": "5.4.1.1", "rectangle": "5.4.2.1"}
FIRST = {"corridor": 3, "rectangle": 5}
"""Episodes of the second cell of each arena, which ends the early gain."""
COMPARABLE = 10.0
"""Largest difference in score of comparable arenas; in the thesis the arenas differ by 7 to 9 points."""


def _thesis(arena: str, episodes: int) -> float:
    """The mean of the scores that the thesis prints in the lines of a cell."""
    return appendix_a.mean_score(appendix_a.table_of(arena, episodes))


def _improves(evidence: Evidence, arena: str) -> Claim:
    ten, one = (_fine(evidence.score(arena, episodes).ratio) for episodes in (10, 1))
    return Claim(
        f"More episodes improve the learner ({arena})",
        SECTION[arena],
        evidence.scores({(arena, 10): 1.0, (arena, 1): -1.0}),
        above(0.0),
        points,
        points(_thesis(arena, 10) - _thesis(arena, 1)),
        f"Mean score {ten} after ten training episodes and {one} after one; in the thesis {_fine(_thesis(arena, 10))} "
        f"and {_fine(_thesis(arena, 1))}.",
    )


def _gain_shrinks(evidence: Evidence, arena: str) -> Claim:
    first = FIRST[arena]
    early, late = 1.0 / (first - 1), 1.0 / 5
    weights = {(arena, 1): -early, (arena, first): early}
    weights[arena, 5] = weights.get((arena, 5), 0.0) + late
    weights[arena, 10] = -late
    gains = [
        (evidence.score(arena, after).ratio - evidence.score(arena, before).ratio) / (after - before)
        for before, after in ((1, first), (5, 10))
    ]
    return Claim(
        f"The gain from an episode shrinks ({arena})",
        SECTION[arena],
        evidence.scores(weights),
        above(0.0),
        points,
        points(sum(weight * _thesis(*cell) for cell, weight in weights.items())),
        f"Each episode from 1 to {first} adds {points(gains[0])}, each from 5 to 10 {points(gains[1])}; the effect is "
        "the difference.",
    )


def _generalises(evidence: Evidence) -> Claim:
    learned = food_share(evidence.score("rectangle", 10).rows)
    chance = food_share(pick(evidence.chance, arena="rectangle"))
    table = appendix_a.table_of("rectangle", 10)
    return Claim(
        "The learner generalises: trained in the corridor, it forages in the rectangle",
        "5.4.2, 5.5",
        evidence.difference(learned, chance),
        above(0.0),
        percent_change,
        f"{percent(table.collected / table.available)} of the food, chance not measured",
        f"After ten episodes in the corridor the learner brings home {percent(learned.ratio)} of the food; "
        f"behaviours drawn at random bring home {percent(chance.ratio)}.",
    )


def _comparable(evidence: Evidence) -> Claim:
    corridor, rectangle = (_fine(evidence.score(arena, 10).ratio) for arena in THESIS_ARENAS)
    return Claim(
        "Performance in the rectangle is comparable to the corridor's",
        "5.4.2",
        evidence.scores({("corridor", 10): 1.0, ("rectangle", 10): -1.0}),
        within(COMPARABLE),
        points,
        points(_thesis("corridor", 10) - _thesis("rectangle", 10)),
        f"Mean score after ten episodes: {corridor} in the corridor, {rectangle} in the rectangle.",
    )


AREA_MARGIN = 0.10
"""Largest difference in success between equal areas; the thesis says "most of the times" and "rarely"."""
NEAR_TRAINING = 6.0
"""Pixels on either side of the training distance that count as the same distance: nearly the width of a food object."""
OFTEN = 0.10
"""Share of recalls above which the learner executes a behaviour where it does not belong."""
MOST = 0.5
"""Share of failures above which a reason explains most of them."""
ALL_CORRECT = 0.9
"""Share of correct rounds above which "all the consequent behaviours are correctly executed"."""
AFTER_ORIENT = (State.ORIENTED_WITH_FOOD, State.READY_TO_PICK_UP_FOOD, State.FOOD_IN_HAND, State.AT_HOME_WITH_FOOD)


def _areas(evidence: Evidence, arena: str) -> Claim:
    """Food nearer to home than in training is delivered more often than food further away.

    The thesis calls the two sides area 2 and area 1, but does not say clearly which is which. That the nearer one is
    area 2 is our reading.
    """
    rows, training = pick(evidence.recalls, arena=arena), training_distance(evidence.decisions)
    nearer = food_share(rows, lambda distance: distance < training)
    further = food_share(rows, lambda distance: distance >= training)
    around = food_share(rows, lambda distance: abs(distance - training) <= NEAR_TRAINING)
    return Claim(
        f"Food nearer to home than in training is delivered more often than food further away ({arena})",
        SECTION[arena],
        evidence.difference(nearer, further),
        above(AREA_MARGIN),
        percent_change,
        "most of the times in area 2, rarely in area 1",
        f"Brought home: {_share(nearer)} nearer to home than the {training:.0f} pixels of training, "
        f"{_share(further)} further away; {_share(around)} within {NEAR_TRAINING:.0f} pixels of the training distance.",
    )


def _share(sample: Sample[RecallRow]) -> str:
    return f"{percent(sample.ratio)} of {sum(map(sample.weight, sample.rows)):.0f} food objects"


def _orient_without_food(evidence: Evidence, arena: str) -> Claim:
    rows = pick(evidence.recalls, arena=arena)
    recalls = Sample(rows, lambda row: row.orient_without_food > 0)
    rounds = Sample(rows, lambda row: row.orient_without_food, lambda row: row.steps)
    return Claim(
        f"'Orient with food' is executed where there is no food ({arena})",
        SECTION[arena],
        evidence.mean(recalls),
        above(OFTEN),
        percent,
        "observed in area 2",
        f"In {percent(recalls.ratio)} of {len(rows)} recalls the learner oriented at least once without food within "
        f"the close threshold, in {_fine_percent(rounds.ratio)} of all rounds.",
    )


def _failures_by_orient(evidence: Evidence) -> Claim:
    failed = [row for row in pick(evidence.recalls, arena=CORRIDOR) if row.failed]
    reached = [row for row in failed if row.orient_wanted > 0]
    missed = Sample(reached, lambda row: row.orient_missed, lambda row: row.orient_wanted)
    return Claim(
        "Most failures happen because 'orient with food' was not executed",
        "5.4.1.2",
        evidence.mean(Sample(failed, lambda row: row.failure_mode == State.NEXT_TO_FOOD)),
        above(MOST),
        percent,
        "the reason for the few failures in area 2",
        f"The effect is the share of failed recalls in the corridor, {len(failed)} in total, that had most of their "
        f"wrong rounds next to food. {len(reached)} of them reached food; there they missed {percent(missed.ratio)} "
        "of the rounds in which the teacher would orient.",
    )


def _rest_is_correct(evidence: Evidence) -> Claim:
    correct = Sample(
        pick(evidence.recalls, arena=CORRIDOR),
        lambda row: sum(row.rounds_by_state[s] - row.wrong_by_state[s] for s in AFTER_ORIENT),
        lambda row: sum(row.rounds_by_state[s] for s in AFTER_ORIENT),
    )
    return Claim(
        "After 'orient with food', all consequent behaviours are executed correctly",
        "5.4.1.2",
        evidence.mean(correct),
        above(ALL_CORRECT),
        percent,
        "all",
        "The effect is the share of correct rounds in the corridor in the states "
        f"{', '.join(state.name for state in AFTER_ORIENT)}.",
    )


FREQUENT = 0.5
"""Share of complete attempts above which episodes are achieved "quite frequently"."""
ENOUGH = 0.95
"""Share of the teacher's forages that must end within a sufficient limit."""


def _losses_cost_attempts(evidence: Evidence) -> Claim:
    laboratory, without = (attempts_per_episode(evidence, noise) for noise in (LABORATORY, NO_LOSSES))
    show = Unit("attempts per 100 episodes", ".2f", 100.0)
    return Claim(
        "Tracking losses make more training attempts necessary",
        "5.3.1",
        evidence.difference(laboratory, without),
        above(0.0),
        show,
        'completeness "is mainly affected from the tracking"',
        f"{show(laboratory.ratio)} in the laboratory, {show(without.ratio)} without losses.",
    )


def _frequent_without_losses(evidence: Evidence) -> Claim:
    laboratory, without = (
        Sample(pick(evidence.trainings, noise=noise), lambda row: row.complete) for noise in (LABORATORY, NO_LOSSES)
    )
    return Claim(
        "Without tracking losses complete training episodes are frequent",
        "5.3.1",
        evidence.mean(without),
        above(FREQUENT),
        percent,
        '"achieved quite frequently"',
        f"{percent(without.ratio)} of {len(without.rows)} attempts without tracking losses were complete, "
        f"{percent(laboratory.ratio)} of {len(laboratory.rows)} in the laboratory.",
    )


def _limit_is_enough(evidence: Evidence, arena: str) -> Claim:
    limit = LIMITS[arena]
    rows = pick(evidence.teachers, arena=arena)
    steps = sorted(map(steps_needed, rows))
    median = steps[(len(steps) - 1) // 2] if steps else math.nan
    return Claim(
        f"{limit} steps are enough to forage ({arena})",
        LIMIT_SECTION[arena],
        bootstrap_quantile(rows, steps_needed, ENOUGH, evidence.rng, evidence.resamples),
        at_most(limit),
        Unit("steps"),
        "an estimate; not measured",
        f"The effect is the number of steps in which the teacher completes 95 % of its forages. Of {len(rows)} "
        f"forages, half ended within {Unit('steps')(median)}, and "
        f"{percent(Sample(rows, lambda row: steps_needed(row) <= limit).ratio)} within {limit}.",
    )


def claims(evidence: Evidence) -> list[Claim]:
    """Measure and judge every claim."""
    return [
        *(_improves(evidence, arena) for arena in THESIS_ARENAS),
        *(_gain_shrinks(evidence, arena) for arena in THESIS_ARENAS),
        _generalises(evidence),
        _comparable(evidence),
        *(_areas(evidence, arena) for arena in THESIS_ARENAS),
        *(_orient_without_food(evidence, arena) for arena in THESIS_ARENAS),
        _failures_by_orient(evidence),
        _rest_is_correct(evidence),
        _losses_cost_attempts(evidence),
        _frequent_without_losses(evidence),
        *(_limit_is_enough(evidence, arena) for arena in THESIS_ARENAS),
    ]
