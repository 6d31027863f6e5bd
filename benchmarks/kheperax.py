"""How fast our batched bodies are beside Kheperax, on the nearest equal work, in one session.

    python benchmarks/kheperax.py --help

Kheperax 0.2.0 and JAX get a virtual environment of their own (some 1.2 GB, made by this script, once). Both sides are
given the same arena, starts and wheel commands, in alternation; the page says what is equal and what is not. Needs the
extras `fast` and `plots`, and a machine with nothing else to do.
"""

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

import numba
from _kheperax.environment import NoKheperax, environment, megabytes
from _kheperax.lines import PAIRS, TASKS, Plan, Row
from _kheperax.ours import Bodies
from _kheperax.page import STEM, by_worlds, page, picture, steps_table
from _kheperax.theirs import About, Kheperax
from _kheperax.work import Work
from arguments import add_count, count_of, parser_for, positive
from tqdm import tqdm

from khepera_forage.rollouts.row_files import write_rows
from khepera_forage.thesis.figures import save

REPEATS, QUICK_REPEATS = 7, 2
WORLDS, QUICK_WORLDS = (64, 256, 1024, 4096, 16384), (64, 256)
REFERENCE, QUICK_REFERENCE = 4096, 256
"""Worlds of the lines that have no counterpart."""
SECONDS, QUICK_SECONDS, WARM_UP_SECONDS = 0.25, 0.05, 1e-6
"""Of each line in each repeat, at least."""


def measure(plan: Plan, repeats: int, kheperax: Kheperax, bodies: Bodies) -> list[Row]:
    """All rows, after one repeat that warms up and is not counted."""
    lines = (2 * len(PAIRS) * len(plan.worlds) + 1 + len(TASKS)) * (repeats + 1)
    rows: list[Row] = []
    with tqdm(total=lines, desc=STEM, unit="line", disable=not sys.stderr.isatty()) as progress:
        for number in range(-1, repeats):
            this = plan if number >= 0 else plan._replace(at_least=WARM_UP_SECONDS)
            for row in this.repeat(number, kheperax, bodies):
                progress.update()
                rows.append(row)
    return [row for row in rows if row.repeat >= 0]


def write(folder: Path, rows: Sequence[Row], about: About, size: float) -> str:
    """Write page, tables, rows and picture.

    Args:
        folder: Where to.
        rows: Of all lines and repeats.
        about: What Kheperax' process said of itself.
        size: Of its environment in MB.

    Returns:
        The page.
    """
    folder.mkdir(parents=True, exist_ok=True)
    text = page(rows, about, size)
    (folder / f"{STEM}.md").write_text(text, encoding="utf-8")
    for table in (steps_table(rows), by_worlds(rows)):
        (folder / f"{table.stem}.csv").write_text(table.csv(), encoding="utf-8")
    write_rows(folder / "rows.csv", Row, rows)
    save(picture(rows), folder / f"{STEM}.png")
    return text


def run(arguments: argparse.Namespace) -> int:
    """Do what the arguments ask for."""
    quick = arguments.quick
    repeats = count_of(arguments.repeats, REPEATS, quick, QUICK_REPEATS)
    worlds = tuple(sorted(set(arguments.worlds or (QUICK_WORLDS if quick else WORLDS))))
    reference = QUICK_REFERENCE if quick else REFERENCE
    plan = Plan(worlds, reference, QUICK_SECONDS if quick else SECONDS, arguments.seed)
    work = Work.of(max(*worlds, reference), arguments.seed)
    folder = arguments.venv or arguments.out / "venv"
    try:
        python = environment(folder)
        with Kheperax(python, work, numba.get_num_threads()) as kheperax:
            rows = measure(plan, repeats, kheperax, Bodies(work, arguments.seed))
            about = kheperax.about
    except NoKheperax as error:
        print(f"kheperax.py: {error}", file=sys.stderr)
        return 1
    print(write(arguments.out, rows, about, megabytes(folder)))
    print(f"Page, picture, tables and rows are in {arguments.out}")
    return 0


if __name__ == "__main__":
    parser = parser_for(__doc__, "results/kheperax")
    add_count(parser, "--repeats", REPEATS, QUICK_REPEATS, "repeats, of which the median counts")
    parser.add_argument(
        "--worlds",
        type=positive,
        nargs="+",
        metavar="N",
        help=f"numbers of worlds to step together ({' '.join(map(str, WORLDS))}; with --quick "
        f"{' '.join(map(str, QUICK_WORLDS))})",
    )
    parser.add_argument(
        "--venv",
        type=Path,
        help="Kheperax' virtual environment, made if it does not exist (venv in the results' folder)",
    )
    sys.exit(run(parser.parse_args()))
