"""The expert's own figures: how surely and how fast the teacher forages, and that the task is not trivial.

    python benchmarks/teacher.py --help

In corridor and rectangle, for each type of food, from many random starts; and the same teacher with SEARCH FOR FOOD
in place of ORIENT WITH FOOD, which must deliver nothing.
"""

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from _teacher.forages import Block, Forage, blocks
from _teacher.page import picture, summaries, table
from arguments import add_count, count_of, parser_for
from joblib import Parallel, delayed
from tqdm import tqdm

from khepera_forage.rollouts.row_files import write_rows
from khepera_forage.thesis.figures import save

FORAGES, QUICK_FORAGES = 500, 25
STEM = "teacher"


def forage(work: Sequence[Block], jobs: int) -> list[Forage]:
    """Do the work; the rows come in its order, whatever the number of processes."""
    running = Parallel(n_jobs=jobs, return_as="generator")(delayed(Block.run)(block) for block in work)
    progress = tqdm(running, total=len(work), desc=STEM, unit="block", disable=not sys.stderr.isatty())
    return [row for rows in progress for row in rows]


def write(folder: Path, rows: Sequence[Forage]) -> str:
    """Write table, rows and picture.

    Returns:
        The page with the table.
    """
    folder.mkdir(parents=True, exist_ok=True)
    results = summaries(rows)
    text = table(results).markdown()
    (folder / f"{STEM}.md").write_text(f"{text}\n![teacher]({STEM}.png)\n", encoding="utf-8")
    (folder / f"{STEM}.csv").write_text(table(results).csv(), encoding="utf-8")
    write_rows(folder / "forages.csv", Forage, rows)
    save(picture(results), folder / f"{STEM}.png")
    return text


def run(arguments: argparse.Namespace) -> int:
    """Do what the arguments ask for."""
    forages = count_of(arguments.forages, FORAGES, arguments.quick, QUICK_FORAGES)
    rows = forage(blocks(arguments.seed, forages), arguments.jobs)
    print(write(arguments.out, rows))
    print(f"Table, picture and rows are in {arguments.out}")
    return 0


if __name__ == "__main__":
    parser = parser_for(__doc__, "results/teacher")
    add_count(parser, "--forages", FORAGES, QUICK_FORAGES, "random starts of each line")
    parser.add_argument("--jobs", type=int, default=-1, help="processes; -1 is one a core (-1)")
    sys.exit(run(parser.parse_args()))
