"""The claims of the thesis: learning (5.4, 5.5), where the learner succeeds (5.4.1.2), and time (5.3.1, 5.4)."""

import math
from collections.abc import Sequence

import numpy as np

from khepera_forage.estimates import RESAMPLES, bootstrap_quantile
from khepera_forage.rollouts.rows import RecallRow, TrainingRow
from khepera_forage.sim.arenas.thesis import CORRIDOR, THESIS_ARENAS
from khepera_forage.task.states import State
from khepera_forage.thesis import appendix_a
from khepera_forage.thesis.claims.claim import (
    Claim,
    Rule,
    Unit,
    above,
    at_most,
    below,
    beyond,
    judged,
    percent,
    percent_change,
    points,
    within,
)
from khepera_forage.thesis.claims.evidence import (
    NEAR_TRAINING,
    Evidence,
    Sample,
    food_share,
    gather,
    of_arena,
)
from khepera_forage.thesis.design import LABORATORY, NO_LOSSES, THESIS, training_distance

LIMIT_SECTION = {"corridor": "5.4.1.1", "rectangle": "5.4.2.1"}
SECTION = {"corridor": "5.4.1.2", "rectangle": "5.4.2.2"}
FIRST = {"corridor": 3, "rectangle": 5}
"""Episodes of the second cell of each arena, which ends the early gain."""
COMPARABLE = 10.0
"""Largest difference in score of comparable arenas; in the thesis the arenas differ by 7 to 9 points."""
_fine = Unit("%", ".4g")


def improves(evidence: Evidence, arena: str) -> Claim:
    """More episodes improve the learner: ten compared with one."""
    estimate = evidence.cell_scores({(arena, 10): 1.0, (arena, 1): -1.0})
    return judged(
        f"More episodes improve the learner ({arena})",
        SECTION[arena],
        estimate,
        above(0.0),
        points,
        points(_thesis(arena, 10) - _thesis(arena, 1)),
        f"Mean score {_shown(evidence, arena, 10)} after ten training episodes and "
        f"{_shown(evidence, arena, 1)} after one; in the thesis {_fine(_thesis(arena, 10))} and "
        f"{_fine(_thesis(arena, 1))}.",
    )


def gain_shrinks(evidence: Evidence, arena: str) -> Claim:
    """The gain shrinks: the early points per episode minus the points per episode from five to ten."""
    first = FIRST[arena]
    early, late = 1.0 / (first - 1), 1.0 / 5
    weights = {(arena, 1): -early, (arena, first): early}
    weights[arena, 5] = weights.get((arena, 5), 0.0) + late
    weights[arena, 10] = -late
    gains = [
        (_mean_shown(evidence, arena, after) - _mean_shown(evidence, arena, before)) / (after - before)
        for before, after in ((1, first), (5, 10))
    ]
    return judged(
        f"The gain from an episode shrinks ({arena})",
        SECTION[arena],
        evidence.cell_scores(weights),
        above(0.0),
        points,
        points(sum(weight * _thesis(*cell) for cell, weight in weights.items())),
        f"Each episode from 1 to {first} adds {points(gains[0])}, each from 5 to 10 {points(gains[1])}; the effect is "
        "the difference.",
    )


def generalises(evidence: Evidence) -> Claim:
    """Trained in the corridor, the learner forages in the rectangle better than chance."""
    learner = [row for row in of_arena(evidence.recalls, "rectangle") if row.episodes == 10]
    learned, chance = food_share(learner), food_share(of_arena(evidence.chance, "rectangle"))
    table = appendix_a.table_of("rectangle", 10)
    return judged(
        "The learner generalises: trained in the corridor, it forages in the rectangle",
        "5.4.2, 5.5",
        evidence.difference(learned, chance),
        above(0.0),
        percent_change,
        f"{percent(table.collected / table.available)} of the food, chance not measured",
        f"After ten episodes in the corridor the learner brings home {percent(learned.value)} of the food; "
        f"behaviours drawn at random bring home {percent(chance.value)}.",
    )


def comparable(evidence: Evidence) -> Claim:
    """The scores in the rectangle and in the corridor are comparable."""
    estimate = evidence.cell_scores({("corridor", 10): 1.0, ("rectangle", 10): -1.0})
    return judged(
        "Performance in the rectangle is comparable to the corridor's",
        "5.4.2",
        estimate,
        within(COMPARABLE),
        points,
        points(_thesis("corridor", 10) - _thesis("rectangle", 10)),
        f"Mean score after ten episodes: {_shown(evidence, 'corridor', 10)} in the corridor, "
        f"{_shown(evidence, 'rectangle', 10)} in the rectangle.",
    )


def _thesis(arena: str, episodes: int) -> float:
    """The mean of the scores that the thesis prints in the lines of a cell."""
    return appendix_a.mean_score(appendix_a.rows_of(appendix_a.table_of(arena, episodes)))


def _shown(evidence: Evidence, arena: str, episodes: int) -> str:
    return _fine(_mean_shown(evidence, arena, episodes))


def _mean_shown(evidence: Evidence, arena: str, episodes: int) -> float:
    rows = [row for row in of_arena(evidence.recalls, arena) if row.episodes == episodes]
    return Sample(rows, lambda row: row.score).value


AREA_MARGIN = 0.10
"""Largest difference in success between equal areas; the thesis says "most of the times" and "rarely"."""
OFTEN = 0.10
"""Share of recalls above which the learner executes a behaviour where it does not belong."""
MOST = 0.5
"""Share of failures above which a reason explains most of them."""
ALL_CORRECT = 0.9
"""Share of correct rounds above which "all the consequent behaviours are correctly executed"."""
_fine_percent = Unit("%", ".1f", 100.0)
AFTER_ORIENT = (
    State.ORIENTED_WITH_FOOD,
    State.READY_TO_PICK_UP_FOOD,
    State.FOOD_IN_HAND,
    State.AT_HOME_WITH_FOOD,
)


def areas(evidence: Evidence, arena: str) -> Claim:
    """Success depends on whether the food lies nearer to home than in training, or further.

    The thesis calls the two sides area 1 and area 2, but does not say clearly which is which. In the corridor either
    direction is counted; in the rectangle only that of the corridor.
    """
    training = training_distance(evidence.decisions)
    nearer, further = _sides(evidence, arena)
    rule: Rule = beyond(AREA_MARGIN)
    if arena != CORRIDOR:
        before, after = (sample.value for sample in _sides(evidence, CORRIDOR))
        rule = below(-AREA_MARGIN) if before < after else above(AREA_MARGIN)
    return judged(
        f"Success depends on whether food lies nearer to home or further than in training ({arena})",
        SECTION[arena],
        evidence.difference(nearer, further),
        rule,
        percent_change,
        "most of the times in area 2, rarely in area 1",
        f"Brought home: {_share(nearer)} nearer to home than the {training:.0f} pixels of training, "
        f"{_share(further)} further away.",
    )


def _sides(evidence: Evidence, arena: str) -> tuple[Sample[RecallRow], Sample[RecallRow]]:
    """Food nearer to home than in training, and the other food."""
    rows, training = of_arena(evidence.recalls, arena), training_distance(evidence.decisions)
    return (
        food_share(rows, lambda distance: distance < training),
        food_share(rows, lambda distance: distance >= training),
    )


def around_training(evidence: Evidence, arena: str) -> Claim:
    """Food as far from home as in training is brought home more often than other food."""
    rows, training = of_arena(evidence.recalls, arena), training_distance(evidence.decisions)
    near = food_share(rows, lambda distance: abs(distance - training) <= NEAR_TRAINING)
    other = food_share(rows, lambda distance: abs(distance - training) > NEAR_TRAINING)
    return judged(
        f"The learner succeeds best where food lies as far from home as in training ({arena})",
        SECTION[arena],
        evidence.difference(near, other),
        above(0.0),
        percent_change,
        "trained in one set-up, it fails where food lies elsewhere",
        f"Brought home: {_share(near)} within {NEAR_TRAINING:.0f} pixels of the training distance, "
        f"{_share(other)} elsewhere.",
    )


def orient_without_food(evidence: Evidence, arena: str) -> Claim:
    """'Orient with food' is executed although no food is near."""
    rows = of_arena(evidence.recalls, arena)
    recalls = Sample(rows, lambda row: row.orient_without_food > 0)
    rounds = Sample(rows, lambda row: row.orient_without_food, lambda row: row.steps)
    return judged(
        f"'Orient with food' is executed where there is no food ({arena})",
        SECTION[arena],
        evidence.mean(recalls),
        above(OFTEN),
        percent,
        "observed in area 2",
        f"In {percent(recalls.value)} of {len(rows)} recalls the learner oriented at least once without food within "
        f"the close threshold, in {_fine_percent(rounds.value)} of all rounds.",
    )


def failures_by_orient(evidence: Evidence) -> Claim:
    """Most failures happen because 'orient with food' was not executed."""
    failed = [row for row in of_arena(evidence.recalls, "corridor") if row.failed]
    reached = [row for row in failed if row.orient_wanted > 0]
    missed = Sample(reached, lambda row: row.orient_missed, lambda row: row.orient_wanted)
    return judged(
        "Most failures happen because 'orient with food' was not executed",
        "5.4.1.2",
        evidence.mean(Sample(failed, lambda row: row.failure_mode == State.NEXT_TO_FOOD)),
        above(MOST),
        percent,
        "the reason for the few failures in area 2",
        f"The effect is the share of failed recalls in the corridor, {len(failed)} in total, that had most of their "
        f"wrong rounds next to food. {len(reached)} of them reached food; there they missed {percent(missed.value)} "
        "of the rounds in which the teacher would orient.",
    )


def rest_is_correct(evidence: Evidence) -> Claim:
    """After a successful 'orient with food', all following behaviours are correct."""
    rows = of_arena(evidence.recalls, "corridor")
    correct = Sample(
        rows,
        lambda row: sum(row.rounds_by_state[s] - row.wrong_by_state[s] for s in AFTER_ORIENT),
        lambda row: sum(row.rounds_by_state[s] for s in AFTER_ORIENT),
    )
    return judged(
        "After 'orient with food', all consequent behaviours are executed correctly",
        "5.4.1.2",
        evidence.mean(correct),
        above(ALL_CORRECT),
        percent,
        "all",
        "The effect is the share of correct rounds in the corridor in the states "
        f"{', '.join(state.name for state in AFTER_ORIENT)}.",
    )


def _share(sample: Sample[RecallRow]) -> str:
    return f"{percent(sample.value)} of {sum(map(sample.bottom, sample.rows)):.0f} food objects"


FREQUENT = 0.5
"""Share of complete attempts above which episodes are achieved "quite frequently"."""
ENOUGH = 0.95
"""Share of the teacher's forages that must end within a sufficient limit."""


def attempts_per_episode(evidence: Evidence, noise: str) -> Sample[TrainingRow]:
    """Attempts per complete training episode under one noise condition."""
    rows = [row for row in evidence.trainings if row.noise == noise]
    return Sample(rows, lambda row: 1.0, lambda row: row.complete)


def losses_cost_attempts(evidence: Evidence) -> Claim:
    """Tracking losses are the main reason for incomplete training episodes."""
    laboratory = attempts_per_episode(evidence, LABORATORY)
    without = attempts_per_episode(evidence, NO_LOSSES)
    show = Unit("attempts per 100 episodes", ".2f", 100.0)
    return judged(
        "Tracking losses make more training attempts necessary",
        "5.3.1",
        evidence.difference(laboratory, without),
        above(0.0),
        show,
        'completeness "is mainly affected from the tracking"',
        f"{show(laboratory.value)} in the laboratory, {show(without.value)} without losses.",
    )


def frequent_without_losses(evidence: Evidence) -> Claim:
    """Complete training episodes are frequent without tracking losses."""
    rows = [row for row in evidence.trainings if row.noise == NO_LOSSES]
    complete = Sample(rows, lambda row: row.complete)
    laboratory = Sample([r for r in evidence.trainings if r.noise == LABORATORY], lambda row: row.complete)
    return judged(
        "Without tracking losses complete training episodes are frequent",
        "5.3.1",
        evidence.mean(complete),
        above(FREQUENT),
        percent,
        '"achieved quite frequently"',
        f"{percent(complete.value)} of {len(rows)} attempts without tracking losses were complete, "
        f"{percent(laboratory.value)} of {len(laboratory.rows)} in the laboratory.",
    )


def limit_is_enough(evidence: Evidence, arena: str) -> Claim:
    """The time limit, an estimate in the thesis, is enough for the teacher."""
    limit = next(cell.limit for cell in THESIS if cell.arena == arena)
    rows = of_arena(evidence.teachers, arena)
    estimate = bootstrap_quantile(rows, steps_needed, ENOUGH, evidence.rng, evidence.resamples)
    within = Sample(rows, lambda row: steps_needed(row) <= limit)
    show = Unit("steps")
    steps = sorted(map(steps_needed, rows))
    median = steps[(len(steps) - 1) // 2] if steps else math.nan
    return judged(
        f"{limit} steps are enough to forage ({arena})",
        LIMIT_SECTION[arena],
        estimate,
        at_most(limit),
        show,
        "an estimate; not measured",
        f"The effect is the number of steps in which the teacher completes 95 % of its forages. Of {len(rows)} "
        f"forages, half ended within {show(median)}, and {percent(within.value)} within {limit}.",
    )


def steps_needed(row: RecallRow) -> float:
    """Steps until all food was delivered; infinite if that never happened."""
    return math.inf if row.failed else row.steps


def claims(
    recalls: Sequence[RecallRow],
    trainings: Sequence[TrainingRow],
    teachers: Sequence[RecallRow],
    rng: np.random.Generator,
    resamples: int = RESAMPLES,
) -> list[Claim]:
    """Measure and judge every claim.

    Args:
        recalls: Recalls of the imitator, under one noise condition, and of a random policy if available.
        trainings: Attempts at training episodes, with and without tracking losses.
        teachers: Forages of the teacher alone, with a time limit well above the thesis's.
        rng: Draws the resamples.
        resamples: Resamples for each interval.

    Raises:
        ValueError: The recalls of the imitator have several noise conditions, or the rows several decisions.
    """
    evidence = gather(recalls, trainings, teachers, rng, resamples)
    return [
        *(improves(evidence, arena) for arena in THESIS_ARENAS),
        *(gain_shrinks(evidence, arena) for arena in THESIS_ARENAS),
        generalises(evidence),
        comparable(evidence),
        *(areas(evidence, arena) for arena in THESIS_ARENAS),
        *(around_training(evidence, arena) for arena in THESIS_ARENAS),
        *(orient_without_food(evidence, arena) for arena in THESIS_ARENAS),
        failures_by_orient(evidence),
        rest_is_correct(evidence),
        losses_cost_attempts(evidence),
        frequent_without_losses(evidence),
        *(limit_is_enough(evidence, arena) for arena in THESIS_ARENAS),
    ]
