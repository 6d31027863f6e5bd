"""Imitators in thousands of worlds, wholly in the kernel. Needs numba."""

from time import perf_counter

import numpy as np

from _throughput.batch import SECTION
from _throughput.imitating import experience
from _throughput.lines import Job, Measure, Values

VECTORS, IMITATORS = 500, 64
"""Experience vectors of each imitator, and how many of them take turns."""
KERNEL = Measure(
    SECTION,
    f"recall in the corridor under imitators of {VECTORS} experience vectors, in the kernel",
    "steps/s",
    f"whole episodes, {IMITATORS} imitators, all cores",
    1e6,
)
STORE = Measure(SECTION, "experience vectors put into memories", "vectors/s", "`memories_of`, one core")


def job(episodes: int, seed: int) -> Job:
    """Recalls under imitators.

    Args:
        episodes: Whole episodes a repeat.
        seed: Of trainings and worlds.
    """
    from khepera_forage.policies.nearest_neighbour.memories import memories_of
    from khepera_forage.rollouts.compiled.recalls import run_recalls

    vectors, heard = experience(seed, 4 * VECTORS)
    # Each has learned from another stretch of the same trainings.
    firsts = np.linspace(0, 3 * VECTORS, IMITATORS, dtype=np.int64).tolist()
    parts = [(vectors[first : first + VECTORS], heard[first : first + VECTORS]) for first in firsts]
    which = np.arange(episodes) % IMITATORS

    def repeat() -> Values:
        start = perf_counter()
        memories = memories_of(parts * 16)
        stored = 16 * IMITATORS * VECTORS / (perf_counter() - start)
        start = perf_counter()
        steps = int(run_recalls("corridor", memories, which, seed).steps.sum())
        return {STORE: stored, KERNEL: steps / (perf_counter() - start)}

    return repeat
