"""Paired corridors in thousands, wholly in the kernel. Needs numba."""

from time import perf_counter

from _throughput.batch import SECTION
from _throughput.lines import Job, Measure, Values

ROUNDS = Measure(
    SECTION,
    "paired corridors, in the kernel",
    "rounds/s",
    "a teacher and a learner each, whole training episodes, incomplete attempts included, all cores; "
    "pymunk's are above",
)
EPISODES = Measure(SECTION, "complete training episodes", "episodes/s", "the same run")


def job(episodes: int, seed: int) -> Job:
    """Training of as many learners as episodes.

    Args:
        episodes: Complete training episodes a repeat.
        seed: Of all trainings.
    """
    from khepera_forage.rollouts.compiled.training import train_learners

    def repeat() -> Values:
        start = perf_counter()
        rounds = int(train_learners(episodes, seed=seed).attempts.rounds.sum())
        taken = perf_counter() - start
        return {ROUNDS: rounds / taken, EPISODES: episodes / taken}

    return repeat
