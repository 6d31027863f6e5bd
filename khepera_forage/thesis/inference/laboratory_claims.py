"""The claims of the thesis, measured under one laboratory: the ordinary reproduction, with its decisions and noise."""

import numpy as np

from khepera_forage.envs.backends import COMPILED
from khepera_forage.rollouts.rows import TEACHER
from khepera_forage.rollouts.training import IncompleteTrainingError
from khepera_forage.task.decisions import decisions_text
from khepera_forage.thesis.claims import Claim, claims
from khepera_forage.thesis.design import NO_LOSSES
from khepera_forage.thesis.inference.prior import Laboratory
from khepera_forage.thesis.jobs import compiled_jobs, job_counts

RESAMPLES = 500
"""For each interval."""


def claims_of(laboratory: Laboratory, seed: int, replications: int) -> list[Claim]:
    """Measure every claim of the thesis under one laboratory.

    The jobs are those of a reproduction on the compiled backend. Of the other noise conditions only the laboratory
    without tracking losses is needed, and of that only the training files.

    Args:
        laboratory: Decisions and noise.
        seed: Of all experiments and of the intervals. The same arguments give the same claims, for any number of
            threads.
        replications: Of the whole design. With fewer than `statistics.MIN_REPLICATIONS` there are no intervals, and
            claims that need one are undecided.

    Returns:
        One claim each, always in the same order.

    Raises:
        IncompleteTrainingError: No attempt at some training episode was complete, within the number of attempts that
            the decisions allow.
        ValueError: A mark where robot or food does not fit.
        ImportError: numba is not installed.
    """
    decisions, noise = laboratory
    counts = job_counts(replications, COMPILED)._replace(
        noise_replications=replications, noise_conditions=(NO_LOSSES,), noise_cells=()
    )
    try:
        outcomes = [job.run() for job in compiled_jobs(seed, counts, decisions, noise)]
    except IncompleteTrainingError as error:
        raise IncompleteTrainingError(
            f"{error}; seed {seed}, decisions: {decisions_text(decisions)}"
        ) from error
    recalls = [row for outcome in outcomes for row in outcome.recalls]
    return claims(
        recalls=[row for row in recalls if row.learner != TEACHER],
        trainings=[row for outcome in outcomes for row in outcome.trainings],
        teachers=[row for row in recalls if row.learner == TEACHER],
        rng=np.random.default_rng(seed),
        resamples=RESAMPLES,
    )
