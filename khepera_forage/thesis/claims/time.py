"""Claims about time: attempts per complete training episode (5.3.1), and time limits of recalls (5.4)."""

import math

from khepera_forage.estimates import bootstrap_quantile
from khepera_forage.rollouts.rows import RecallRow, TrainingRow
from khepera_forage.thesis.claims.claim import Above, AtMost, Claim, Unit, judged, percent
from khepera_forage.thesis.claims.evidence import Evidence, Sample, of_arena
from khepera_forage.thesis.design import LABORATORY, NO_LOSSES, THESIS

SECTION = {"corridor": "5.4.1.1", "rectangle": "5.4.2.1"}
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
        Above(0.0),
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
        Above(FREQUENT),
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
        SECTION[arena],
        estimate,
        AtMost(limit),
        show,
        "an estimate; not measured",
        f"The effect is the number of steps in which the teacher completes 95 % of its forages. Of {len(rows)} "
        f"forages, half ended within {show(median)}, and {percent(within.value)} within {limit}.",
    )


def steps_needed(row: RecallRow) -> float:
    """Steps until all food was delivered; infinite if that never happened."""
    return math.inf if row.failed else row.steps
