"""How fast everything is, on one core, beside the goals and beside bare pymunk stepping the same bodies.

    python benchmarks/throughput.py --help

Goals: 15,000 steps a second of Corridor-v0 under the teacher, 4,000 rounds a second of the paired corridors, 40,000
decisions a second of an imitator with 1,000 experience vectors, half a second for the import, 1 GB for the main job;
with `--batch`, 15 million steps a second wholly in the kernel, 5 million and 300 times pymunk through `gym.make_vec`,
and 150,000 of one world; then there is a second picture, of what a step costs against worlds and food.
"""

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from _throughput import (
    bare_pymunk,
    batch,
    batch_imitator,
    batch_pairs,
    compiling,
    design,
    foraging,
    imitating,
    page,
    parts,
    processes,
    scaling,
)
from _throughput.lines import Job, Line, lines_of, repeated
from arguments import add_count, count_of, parser_for
from tqdm import tqdm

from khepera_forage.rollouts.row_files import write_rows
from khepera_forage.thesis.figures import save

REPEATS, QUICK_REPEATS = 7, 2
STEPS, QUICK_STEPS = 10_000, 400
"""Steps, rounds or decisions of a measure in each repeat."""
EPISODES, QUICK_EPISODES = 16_384, 1_024
"""Episodes of a measure of the batched worlds in each repeat."""
BATCH_STEPS, QUICK_BATCH_STEPS = 100_000, 2_000
"""Steps of each measure against the number of worlds, and of food."""
STEM = "throughput"


def jobs(steps: int, seed: int) -> list[Job]:
    """Everything that is repeated.

    Args:
        steps: Steps, rounds or decisions of a measure in each repeat.
        seed: Of all episodes and trainings.
    """
    return [
        foraging.corridor_job(steps, seed),
        foraging.rectangle_job(steps, seed),
        foraging.wheels_job(steps, seed),
        foraging.paired_job(steps, seed),
        bare_pymunk.job(steps),
        imitating.job(steps, seed),
        processes.import_job,
        parts.job(steps, seed),
    ]


def batch_jobs(quick: bool, seed: int) -> list[Job]:
    """Everything about many worlds at once that is repeated."""
    episodes = QUICK_EPISODES if quick else EPISODES
    return [
        *(module.job(episodes, seed) for module in (batch, batch_imitator, batch_pairs)),
        scaling.job(QUICK_BATCH_STEPS if quick else BATCH_STEPS, seed),
    ]


def measure(work: Sequence[Job], repeats: int) -> list[Line]:
    """Every measure, after one round that warms up and is not counted."""
    runs = tqdm(
        repeated(work, repeats + 1),
        total=repeats + 1,
        desc=STEM,
        unit="repeat",
        disable=not sys.stderr.isatty(),
    )
    return lines_of(list(runs)[1:])


def write(folder: Path, lines: Sequence[Line]) -> str:
    """Write table, rows and picture.

    Returns:
        The page with the table.
    """
    folder.mkdir(parents=True, exist_ok=True)
    text = page.page(lines)
    (folder / f"{STEM}.md").write_text(f"{text}\n![throughput]({STEM}.png)\n", encoding="utf-8")
    write_rows(folder / f"{STEM}.csv", Line, lines)
    save(page.picture(lines), folder / f"{STEM}.png")
    if any(line.section == scaling.SECTION for line in lines):
        save(scaling.picture(lines), folder / f"{STEM}_batch.png")
        with (folder / f"{STEM}.md").open("a", encoding="utf-8") as file:
            file.write(f"![worlds and food]({STEM}_batch.png)\n")
    return text


def run(arguments: argparse.Namespace) -> int:
    """Do what the arguments ask for."""
    quick = arguments.quick
    steps = count_of(arguments.steps, STEPS, quick, QUICK_STEPS)
    repeats = count_of(arguments.repeats, REPEATS, quick, QUICK_REPEATS)
    lines = measure(jobs(steps, arguments.seed), repeats)
    if arguments.batch:
        lines += measure(batch_jobs(quick, arguments.seed), repeats)
        replications = design.QUICK_REPLICATIONS if quick else design.REPLICATIONS
        lines += lines_of([[design.job(replications, arguments.seed)]])
        lines += lines_of([[compiling.job()]])
    if arguments.memory:
        lines += lines_of([[processes.memory_job(arguments.seed)()]])
    print(write(arguments.out, lines))
    print(f"Table, picture and rows are in {arguments.out}")
    return 0


if __name__ == "__main__":
    parser = parser_for(__doc__, "results/throughput")
    add_count(parser, "--steps", STEPS, QUICK_STEPS, "steps, rounds or decisions of each measure in a repeat")
    add_count(parser, "--repeats", REPEATS, QUICK_REPEATS, "repeats, of which the median counts")
    parser.add_argument("--batch", action="store_true", help="also the batched worlds (needs numba)")
    parser.add_argument("--memory", action="store_true", help="also the peak memory of the main job in small")
    sys.exit(run(parser.parse_args()))
