"""The thesis' claims, each with a measured effect, an interval and a verdict that can come out either way."""

from collections.abc import Sequence

import numpy as np

from khepera_forage.experiments import claims_behaviour, claims_learning, claims_time
from khepera_forage.experiments.claim import Claim
from khepera_forage.experiments.evidence import gather
from khepera_forage.experiments.rows import RecallRow, TrainingRow
from khepera_forage.experiments.statistics import RESAMPLES

ARENAS = ("corridor", "rectangle")


def claims(
    recalls: Sequence[RecallRow],
    trainings: Sequence[TrainingRow],
    teachers: Sequence[RecallRow],
    rng: np.random.Generator,
    resamples: int = RESAMPLES,
) -> list[Claim]:
    """Measure and judge every claim.

    Args:
        recalls: The imitator's, of one noise condition; with them those of a random policy, if there are any.
        trainings: Attempts at training episodes, with and without tracking losses.
        teachers: Forages of the teacher alone, best with a limit well above the thesis'.
        rng: Draws the resamples.
        resamples: How many.

    Raises:
        ValueError: The imitator's rows are of several noise conditions.
    """
    evidence = gather(recalls, trainings, teachers, rng, resamples)
    return [
        *(claims_learning.improves(evidence, arena) for arena in ARENAS),
        *(claims_learning.gain_shrinks(evidence, arena) for arena in ARENAS),
        claims_learning.generalises(evidence),
        claims_learning.comparable(evidence),
        *(claims_behaviour.areas(evidence, arena) for arena in ARENAS),
        *(claims_behaviour.around_training(evidence, arena) for arena in ARENAS),
        *(claims_behaviour.ghost_orient(evidence, arena) for arena in ARENAS),
        claims_behaviour.failures_by_orient(evidence),
        claims_behaviour.rest_is_correct(evidence),
        claims_time.losses_cost_attempts(evidence),
        claims_time.frequent_without_losses(evidence),
        *(claims_time.limit_is_enough(evidence, arena) for arena in ARENAS),
    ]
