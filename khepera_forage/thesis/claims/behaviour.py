"""Claims about the learner's success by the food's place, and about 'orient with food' (5.4.1.2)."""

from khepera_forage.rollouts.rows import RecallRow
from khepera_forage.sim.arenas.thesis import CORRIDOR
from khepera_forage.task.states import State
from khepera_forage.thesis.claims.claim import (
    Above,
    Below,
    Beyond,
    Claim,
    Rule,
    Unit,
    judged,
    percent,
    percent_change,
)
from khepera_forage.thesis.claims.evidence import NEAR_TRAINING, Evidence, Sample, food_share, of_arena
from khepera_forage.thesis.claims.learning import SECTION
from khepera_forage.thesis.design import training_distance

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
    rule: Rule = Beyond(AREA_MARGIN)
    if arena != CORRIDOR:
        before, after = (sample.value for sample in _sides(evidence, CORRIDOR))
        rule = Below(-AREA_MARGIN) if before < after else Above(AREA_MARGIN)
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
        Above(0.0),
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
        Above(OFTEN),
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
        Above(MOST),
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
        Above(ALL_CORRECT),
        percent,
        "all",
        "The effect is the share of correct rounds in the corridor in the states "
        f"{', '.join(state.name for state in AFTER_ORIENT)}.",
    )


def _share(sample: Sample[RecallRow]) -> str:
    return f"{percent(sample.value)} of {sum(map(sample.bottom, sample.rows)):.0f} food objects"
