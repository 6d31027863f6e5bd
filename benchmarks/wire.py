"""Time on the wire: what a round costs by baud rate, and what several robots in parallel cost.

    python benchmarks/wire.py --help

Real drivers and virtual Kheperas exchange real bytes over pseudo-terminals, at the pace of the baud rate.
"""

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from _wire.page import fleet_table, picture, wire_table
from _wire.rounds import Round, rounds, work
from arguments import add_count, count_of, parser_for
from tqdm import tqdm

from khepera_forage.rollouts.row_files import write_rows
from khepera_forage.thesis.figures import save

ROUNDS, QUICK_ROUNDS = 200, 40
STEM = "wire"


def write(folder: Path, rows: Sequence[Round]) -> str:
    """Write tables, rows and picture.

    Returns:
        The page with the tables.
    """
    folder.mkdir(parents=True, exist_ok=True)
    tables = wire_table(rows), fleet_table(rows)
    text = "\n".join(table.markdown() for table in tables)
    (folder / f"{STEM}.md").write_text(f"{text}\n![{STEM}]({STEM}.png)\n", encoding="utf-8")
    for table in tables:
        (folder / f"{table.stem}.csv").write_text(table.csv(), encoding="utf-8")
    write_rows(folder / "rounds.csv", Round, rows)
    save(picture(rows), folder / f"{STEM}.png")
    return text


def run(arguments: argparse.Namespace) -> int:
    """Do what the arguments ask for."""
    count = count_of(arguments.rounds, ROUNDS, arguments.quick, QUICK_ROUNDS)
    progress = tqdm(work(), desc=STEM, unit="line", disable=not sys.stderr.isatty())
    rows = [row for baud, robots in progress for row in rounds(baud, robots, count, arguments.seed)]
    print(write(arguments.out, rows))
    print(f"Tables, picture and rows are in {arguments.out}")
    return 0


if __name__ == "__main__":
    parser = parser_for(__doc__, "results/wire")
    add_count(
        parser, "--rounds", ROUNDS, QUICK_ROUNDS, "rounds at each baud rate and with each number of robots"
    )
    sys.exit(run(parser.parse_args()))
