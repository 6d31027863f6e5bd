"""Whether recalls in the batched worlds are those of pymunk: two-sample tests, and how surely they would find a fault.

    python benchmarks/agreement.py --help

Teacher and imitator in corridor and rectangle: scores, steps and food delivered of thousands of recalls in each
simulator; the same with wheels 2 % slow in the batch, which must be found. Needs numba (the extra `fast`).
"""

import argparse
import sys
from pathlib import Path

import numpy as np
from _agreement import comparing, page, samples
from arguments import add_count, count_of, parser_for

from khepera_forage.rollouts.row_files import write_rows
from khepera_forage.thesis.figures import save

EPISODES, QUICK_EPISODES = 3_000, 50
REPEATS, QUICK_REPEATS = 200, 20
"""Repeated samples for the power of the tests."""
STEM = "agreement"


def run(arguments: argparse.Namespace) -> int:
    """Do what the arguments ask for."""
    quick, seed = arguments.quick, arguments.seed
    episodes = count_of(arguments.episodes, EPISODES, quick, QUICK_EPISODES)
    repeats = QUICK_REPEATS if quick else REPEATS
    known = samples.experiences(seed, arguments.jobs)
    rows = samples.in_pymunk(seed, episodes, known, arguments.jobs)
    many = samples.BATCH_FACTOR * episodes
    all_of = {}
    same, slow, surely = [], [], []
    rng = np.random.default_rng((seed, 3))
    for condition in samples.CONDITIONS:
        single = all_of[condition, "pymunk"] = samples.sample_of(rows, condition)
        batch = all_of[condition, "batch"] = samples.in_batch(seed, condition, many, known)
        slower = all_of[condition, "slow"] = samples.in_batch(seed, condition, many, known, samples.SLOW)
        same += comparing.compare(condition, 1.0, single, batch)
        slow += comparing.compare(condition, samples.SLOW, single, slower)
        surely.append(comparing.power(condition, batch, slower, episodes, repeats, rng))
    tables = (page.compared(same, episodes, many), page.planted(slow), page.surely(surely, repeats))
    text = "# Do the batch and pymunk agree?\n\n" + "\n".join(table.markdown() for table in tables)
    out: Path = arguments.out
    out.mkdir(parents=True, exist_ok=True)
    (out / f"{STEM}.md").write_text(f"{text}\n![{STEM}]({STEM}.png)\n", encoding="utf-8")
    for table in tables:
        (out / f"{table.stem}.csv").write_text(table.csv(), encoding="utf-8")
    write_rows(out / "pymunk_recalls.csv", samples.Recalled, rows)
    save(page.picture(all_of), out / f"{STEM}.png")
    print(text)
    print(f"Tables, picture and pymunk's rows are in {out}")
    return 0


if __name__ == "__main__":
    parser = parser_for(__doc__, "results/agreement")
    add_count(parser, "--episodes", EPISODES, QUICK_EPISODES, "recalls of each condition in pymunk")
    parser.add_argument("--jobs", type=int, default=-1, help="processes for pymunk; -1 is one a core (-1)")
    sys.exit(run(parser.parse_args()))
