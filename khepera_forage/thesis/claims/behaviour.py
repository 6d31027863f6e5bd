"""Claims about what the learner does: where food must lie, and the behaviour 'orient with food' (5.4.1.2)."""

from khepera_forage.rollouts.rows import RecallRow
from khepera_forage.task.states import State
from khepera_forage.thesis.claims.claim import (
    Above,
    Beyond,
    Claim,
    Unit,
    judged,
    percent,
    percent_change,
)
from khepera_forage.thesis.claims.evidence import (
    NEAR_TRAINING,
    TRAINING_DISTANCE,
    Evidence,
    Sample,
    food_share,
    of_arena,
)
from khepera_forage.thesis.claims.learning import SECTION

AREA_MARGIN = 0.10
"""Difference in success up to which two areas count as equal; the thesis: "most of the times", "rarely"."""
GHOSTS = 0.10
"""Share of recalls beyond which a behaviour out of place counts as something that the learner does."""
MOST = 0.5
ALL_CORRECT = 0.9
"""Share of correct rounds from which "all the consequent behaviours are correctly executed" may be said."""
_fine = Unit("%", ".1f", 100.0)
AFTER_ORIENT = (
    State.ORIENTED_WITH_FOOD,
    State.READY_TO_PICK_UP_FOOD,
    State.FOOD_IN_HAND,
    State.AT_HOME_WITH_FOOD,
)


def areas(evidence: Evidence, arena: str) -> Claim:
    """Success depends on the side of the training place on which the food lies, whichever is area 1."""
    rows = of_arena(evidence.recalls, arena)
    nearer = food_share(rows, lambda distance: distance < TRAINING_DISTANCE)
    further = food_share(rows, lambda distance: distance >= TRAINING_DISTANCE)
    return judged(
        f"Success depends on whether food lies nearer to home or further than in training ({arena})",
        SECTION[arena],
        evidence.difference(nearer, further),
        Beyond(AREA_MARGIN),
        percent_change,
        "most of the times in area 2, rarely in area 1",
        f"Brought home: {_share(nearer)} nearer to home than the {TRAINING_DISTANCE:.0f} pixels of training, "
        f"{_share(further)} further away.",
    )


def around_training(evidence: Evidence, arena: str) -> Claim:
    """Food as far from home as in training is brought home more often than other food."""
    rows = of_arena(evidence.recalls, arena)
    near = food_share(rows, lambda distance: abs(distance - TRAINING_DISTANCE) <= NEAR_TRAINING)
    other = food_share(rows, lambda distance: abs(distance - TRAINING_DISTANCE) > NEAR_TRAINING)
    return judged(
        f"It succeeds best where food lies as far from home as in training ({arena})",
        SECTION[arena],
        evidence.difference(near, other),
        Above(0.0),
        percent_change,
        "trained in one set-up, it fails where food lies otherwise",
        f"Brought home: {_share(near)} within {NEAR_TRAINING:.0f} pixels of the training distance, "
        f"{_share(other)} elsewhere.",
    )


def ghost_orient(evidence: Evidence, arena: str) -> Claim:
    """'Orient with food' is executed where no food is."""
    rows = of_arena(evidence.recalls, arena)
    with_ghost = Sample(rows, lambda row: row.orient_ghost > 0)
    rounds = Sample(rows, lambda row: row.orient_ghost, lambda row: row.steps)
    return judged(
        f"'Orient with food' is executed where no food is ({arena})",
        SECTION[arena],
        evidence.mean(with_ghost),
        Above(GHOSTS),
        percent,
        "observed in area 2",
        f"In {percent(with_ghost.value)} of {len(rows)} recalls it oriented at least once with no candidate "
        f"food close by; {_fine(rounds.value)} of all rounds were such.",
    )


def failures_by_orient(evidence: Evidence) -> Claim:
    """Most failures are an 'orient' that was not executed."""
    failed = [row for row in of_arena(evidence.recalls, "corridor") if row.failed]
    reached = [row for row in failed if row.orient_wanted > 0]
    missed = Sample(reached, lambda row: row.orient_missed, lambda row: row.orient_wanted)
    return judged(
        "Most failures are an 'orient with food' that was not executed",
        "5.4.1.2",
        evidence.mean(Sample(failed, lambda row: row.failure_mode == State.NEXT_TO_FOOD)),
        Above(MOST),
        percent,
        "the reason for the few failures in area 2",
        f"The share of {len(failed)} failed recalls in the corridor that went wrong most often next to food. "
        f"{len(reached)} of them came next to food at all, and there missed {percent(missed.value)} of the "
        "rounds in which the teacher would orient.",
    )


def rest_is_correct(evidence: Evidence) -> Claim:
    """When 'orient with food' succeeded, all that follows is executed correctly."""
    rows = of_arena(evidence.recalls, "corridor")
    correct = Sample(
        rows,
        lambda row: sum(row.rounds_by_state[s] - row.wrong_by_state[s] for s in AFTER_ORIENT),
        lambda row: sum(row.rounds_by_state[s] for s in AFTER_ORIENT),
    )
    return judged(
        "Once oriented, all the consequent behaviours are executed correctly",
        "5.4.1.2",
        evidence.mean(correct),
        Above(ALL_CORRECT),
        percent,
        "all",
        f"Share of correct rounds in the corridor with food between the fingers or in hand: "
        f"{', '.join(state.name for state in AFTER_ORIENT)}.",
    )


def _share(sample: Sample[RecallRow]) -> str:
    return f"{percent(sample.value)} of {sum(map(sample.bottom, sample.rows)):.0f} food objects"
