"""Imitators in thousands of worlds, wholly in the kernel. Needs numba."""

from time import perf_counter

import numpy as np

from _throughput.batch import SECTION, WORLDS
from _throughput.imitating import experience
from _throughput.lines import Job, Measure, Values

VECTORS, IMITATORS = 500, 64
"""Experience vectors of each imitator, and how many of them take turns."""
THOUSANDS = Measure(
    SECTION,
    f"recall in the corridor under imitators of {VECTORS} experience vectors, in the kernel",
    "steps/s",
    f"whole episodes of {WORLDS:,} worlds, {IMITATORS} imitators, all cores",
    1e6,
)
FEW = Measure(
    SECTION,
    "the same with as few worlds at a time as keep all cores busy",
    "steps/s",
    "the default of `run_recalls`: fewer are idle while the last episodes end",
)
STORE = Measure(SECTION, "experience vectors put into memories", "vectors/s", "`memories_of`, one core")


def job(episodes: int, seed: int) -> Job:
    """Recalls under imitators.

    Args:
        episodes: Whole episodes a repeat.
        seed: Of trainings and worlds.
    """
    from khepera_forage.envs.batch.episodes import run_recalls
    from khepera_forage.policies.ballot_box import memories_of

    vectors, heard = experience(seed, 4 * VECTORS)
    # Each has learned from another stretch of the same trainings.
    firsts = np.linspace(0, 3 * VECTORS, IMITATORS, dtype=np.int64).tolist()
    parts = [(vectors[first : first + VECTORS], heard[first : first + VECTORS]) for first in firsts]
    which = np.arange(episodes) % IMITATORS

    def repeat() -> Values:
        start = perf_counter()
        memories = memories_of(parts * 16)
        stored = 16 * IMITATORS * VECTORS / (perf_counter() - start)
        values = {STORE: stored}
        for measure, worlds in ((THOUSANDS, WORLDS), (FEW, None)):
            start = perf_counter()
            steps = int(run_recalls("corridor", memories, which, seed, num_worlds=worlds).steps.sum())
            values[measure] = steps / (perf_counter() - start)
        return values

    return repeat
