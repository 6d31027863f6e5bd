"""The thesis' whole design, replicated in batches: training, recalls and their rows, but no report. Needs numba."""

from time import perf_counter

from _throughput.batch import SECTION
from _throughput.lines import Measure, Values

REPLICATIONS, QUICK_REPLICATIONS = 1000, 20


def job(replications: int, seed: int) -> Values:
    """Once: it is long enough to be measured.

    Args:
        replications: Each with ten training files and 106 recalls.
        seed: Of all of them.
    """
    from khepera_forage.thesis.compiled_replications import GROUP_SIZE, CompiledReplications

    def run(count: int) -> None:
        for first in range(0, count, GROUP_SIZE):
            CompiledReplications(seed, first, min(GROUP_SIZE, count - first)).run()

    run(1)  # compiles
    start = perf_counter()
    run(replications)
    measure = Measure(
        SECTION,
        f"{replications:,} replications of the thesis' design",
        "s",
        "ten training episodes and 106 recalls each, as rows; compiling and the report left out",
        60.0,
    )
    return {measure: perf_counter() - start}
