"""Speed of environments, policies and compiled worlds, compared with goals and with bare pymunk.

    python benchmarks/throughput.py --help

Goals on one core: 15,000 steps a second of Corridor-v0 under the teacher, 4,000 rounds a second of the paired
corridors, 40,000 decisions a second of an imitator with 1,000 experience vectors, half a second for the import, 1 GB
for the main job. With `--compiled`: 15 million steps a second in the kernel, 5 million and 300 times pymunk through
`gym.make_vec`, and 150,000 of one world; there is then a second picture, of the cost of a step against worlds and food.
"""

import argparse
import sys

from harness.arguments import Count, parse
from harness.page import finish
from harness.processes import collect
from timing import bare_pymunk, compiled, compiling, environments, fresh_processes, imitator, parts, scaling
from timing.measures import Job, Measured, Repeat, lines_of, repeats
from timing.page import page

COUNTS = (
    Count("steps", 10_000, 400, "steps, rounds or decisions of each measure in a repeat"),
    Count("repeats", 7, 2, "repeats, of which the median counts"),
)
EPISODES, QUICK_EPISODES = 16_384, 1_024
"""Compiled episodes of a measure in each repeat."""
COMPILED_STEPS, QUICK_COMPILED_STEPS = 100_000, 2_000
"""Steps of each measure against the number of worlds, and of food."""


def python_jobs(steps: int, seed: int) -> list[Job]:
    """Everything on pymunk.

    Args:
        steps: Steps, rounds or decisions of a measure in each repeat.
        seed: Of all episodes and trainings.
    """
    return [
        *environments.jobs(steps, seed),
        bare_pymunk.job(steps),
        imitator.job(steps, seed),
        fresh_processes.import_job,
        parts.job(steps, seed),
    ]


def compiled_jobs(quick: bool, seed: int) -> list[Job]:
    """Everything compiled that is repeated."""
    episodes = QUICK_EPISODES if quick else EPISODES
    return [
        compiled.worlds_job(episodes, seed),
        compiled.imitators_job(episodes, seed),
        compiled.training_job(episodes, seed),
        scaling.job(QUICK_COMPILED_STEPS if quick else COMPILED_STEPS, seed),
    ]


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The arguments of this script alone."""
    parser.add_argument("--compiled", action="store_true", help="also the compiled backend (needs numba)")
    parser.add_argument("--memory", action="store_true", help="also the peak memory of the main job in small")


def main() -> int:
    """Run the benchmark."""
    given = parse("throughput", __doc__, *COUNTS, jobs=None, add=add_arguments)
    seed, quick = given.seed, given.quick
    units = repeats("python", python_jobs(given.steps, seed), given.repeats)
    if given.compiled:
        units += repeats("compiled", compiled_jobs(quick, seed), given.repeats)
        replications = compiled.QUICK_REPLICATIONS if quick else compiled.REPLICATIONS
        units.append(Repeat("design", 0, [compiled.design_job(replications, seed)]))
        units.append(Repeat("compiling", 0, [compiling.job]))
    if given.memory:
        units.append(Repeat("memory", 0, [fresh_processes.memory_job(seed)]))
    rows = collect(given, units, {Measured: "measurements"})
    options = [f"--{name}" for name in ("compiled", "memory") if getattr(given, name)]
    return finish(given, page(lines_of(rows.of(Measured))), *options)


if __name__ == "__main__":
    sys.exit(main())
