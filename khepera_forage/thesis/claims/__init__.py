"""The claims of the thesis, each with a measured effect, its interval and a verdict."""

from collections.abc import Sequence

import numpy as np

from khepera_forage.estimates import RESAMPLES
from khepera_forage.rollouts.rows import RecallRow, TrainingRow
from khepera_forage.sim.arenas.thesis import THESIS_ARENAS
from khepera_forage.thesis.claims import behaviour, learning, time
from khepera_forage.thesis.claims.claim import Claim, Verdict
from khepera_forage.thesis.claims.evidence import gather

__all__ = ["Claim", "Verdict", "claims"]


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
        *(learning.improves(evidence, arena) for arena in THESIS_ARENAS),
        *(learning.gain_shrinks(evidence, arena) for arena in THESIS_ARENAS),
        learning.generalises(evidence),
        learning.comparable(evidence),
        *(behaviour.areas(evidence, arena) for arena in THESIS_ARENAS),
        *(behaviour.around_training(evidence, arena) for arena in THESIS_ARENAS),
        *(behaviour.orient_without_food(evidence, arena) for arena in THESIS_ARENAS),
        behaviour.failures_by_orient(evidence),
        behaviour.rest_is_correct(evidence),
        time.losses_cost_attempts(evidence),
        time.frequent_without_losses(evidence),
        *(time.limit_is_enough(evidence, arena) for arena in THESIS_ARENAS),
    ]
