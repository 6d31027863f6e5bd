"""Every learner side by side: how well it forages, and how much experience that took.

    python benchmarks/learners.py --help

Imitators, learners that ask the teacher, and reinforcement learning, each looked at after growing amounts of learning.
A run that is killed goes on where it was: the same command again. Page, tables, picture and rows are written to
`--out`. `--tune` compares settings instead, over other seeds.
"""

import argparse
import sys
from collections.abc import Mapping, Sequence

import numpy as np
from _learners.backends import BACKENDS, unavailable
from _learners.curves import curves
from _learners.folder import ROWS, claim, in_order, kept, rewrite
from _learners.lessons import Compared
from _learners.page import amounts_table, main_table, page
from _learners.pictures import figure
from _learners.rows import Batch, Size, steps_up_to
from _learners.tuning import FIRST_SEED, candidates, differences, reading, tuning_page, tuning_table
from _learners.units import Unit, everyone, left_out, plan, told
from arguments import add_count, count_of, parser_for
from tqdm import tqdm

from khepera_forage.rollouts.row_files import RowWriter, read_rows
from khepera_forage.thesis.figures import save

TUNING = "tuning"
"""The folder in `--out` that `--tune` writes to."""
SEEDS, QUICK_SEEDS = 10, 2
RECALLS, QUICK_RECALLS = 10, 1
STEPS, QUICK_STEPS = 1_000_000, 1_000
EPISODES, QUICK_EPISODES = (1, 2, 3, 5, 10), (1, 2)
QUERIES, QUICK_QUERIES = (100, 200, 300, 500, 1_000), (100, 200)


def work(units: Sequence[Unit], arguments: argparse.Namespace) -> None:
    """Do it; the rows of a unit are written when it is done."""
    backend = BACKENDS[arguments.backend](arguments.jobs, arguments.address)
    with backend as workers, RowWriter(arguments.out / ROWS, Batch, resume=True) as writer:
        print(f"{len(units)} units for {workers.number} {workers.title}", flush=True)
        silent = not sys.stderr.isatty()
        for rows in tqdm(workers.done(units), total=len(units), desc="learners", unit="unit", disable=silent):
            writer.write(*rows)


def rows_of(
    learners: Mapping[str, Compared],
    known: Mapping[str, Compared],
    replications: range,
    size: Size,
    arguments: argparse.Namespace,
) -> list[Batch]:
    """All rows of the folder, once those that were not there yet are.

    Raises:
        SystemExit: There are rows of other settings, or damaged ones.
    """
    out, seed = arguments.out, arguments.seed
    try:
        claim(out, seed, size, {name: told(learner) for name, learner in learners.items()})
        done = {row.key for row in kept(out, size, known)}
    except ValueError as error:
        sys.exit(f"learners.py: {error}")
    units = plan(learners, replications, size, seed)
    todo = [unit for unit in units if unit.key not in done]
    if len(todo) < len(units):
        print(f"{len(units) - len(todo)} of {len(units)} units are done already, in {out / ROWS}", flush=True)
    if todo:
        work(todo, arguments)
    rows = in_order(kept(out, size, known), list(known))
    rewrite(out, rows)
    return rows


def compare(size: Size, seeds: int, arguments: argparse.Namespace) -> None:
    """Every learner of the registry."""
    out, known = arguments.out, everyone()
    asked = {name: learner for name, learner in known.items() if name in (arguments.only or known)}
    missing = {name: reason for name, learner in asked.items() if (reason := left_out(learner))}
    for name, reason in missing.items():
        print(f"{name} is left out: {reason}")
    learners = {name: learner for name, learner in asked.items() if name not in missing}
    rows = rows_of(learners, known, range(seeds), size, arguments)
    if not rows:
        return
    found = curves(rows, np.random.default_rng(arguments.seed))
    for table in (main_table(found, known), amounts_table(found, known)):
        (out / f"{table.stem}.csv").write_text(table.csv(), encoding="utf-8")
    command = (
        f"python benchmarks/learners.py --seeds {seeds} --recalls {size.recalls} --steps {size.steps[-1]} "
        f"--seed {arguments.seed}{' --quick' * arguments.quick}"
    )
    (out / "learners.md").write_text(page(found, known, missing, tuned(arguments), command), encoding="utf-8")
    save(figure(found, known), out / "learners.png")


def tune(size: Size, seeds: int, arguments: argparse.Namespace) -> None:
    """Settings beside those of the registry."""
    tried = candidates()
    asked = {name: c for name, c in tried.items() if name.split(".")[0] in (arguments.only or everyone())}
    size = size._replace(episodes=size.episodes[-1:], queries=size.queries[-1:])
    rows = rows_of(asked, tried, range(FIRST_SEED, FIRST_SEED + seeds), size, arguments)
    if rows:
        gains = differences(rows, np.random.default_rng(arguments.seed))
        table = tuning_table(curves(rows, np.random.default_rng(arguments.seed)), gains, tried)
        only = "".join(f" --only {name}" for name in arguments.only or ())
        command = (
            f"python benchmarks/learners.py --tune{only} --seeds {seeds} --recalls {size.recalls} "
            f"--seed {arguments.seed}{' --quick' * arguments.quick}"
        )
        text = tuning_page(table, reading(gains, tried), command)
        (arguments.out / "tuning.md").write_text(text, encoding="utf-8")
        (arguments.out / f"{table.stem}.csv").write_text(table.csv(), encoding="utf-8")


def tuned(arguments: argparse.Namespace) -> str:
    """What came of an earlier run with `--tune` in the same folder; empty if there was none."""
    folder = arguments.out / TUNING
    if not (folder / "tuning.md").exists():
        return ""
    tried = candidates()
    rows = in_order([row for row in read_rows(folder / ROWS, Batch) if row.learner in tried], list(tried))
    return reading(differences(rows, np.random.default_rng(arguments.seed)), tried)


def run(arguments: argparse.Namespace) -> int:
    """Do what the arguments ask for."""
    quick = arguments.quick
    size = Size(
        recalls=count_of(arguments.recalls, RECALLS, quick, QUICK_RECALLS),
        episodes=QUICK_EPISODES if quick else EPISODES,
        queries=QUICK_QUERIES if quick else QUERIES,
        steps=steps_up_to(count_of(arguments.steps, STEPS, quick, QUICK_STEPS)),
    )
    seeds = count_of(arguments.seeds, SEEDS, quick, QUICK_SEEDS)
    if arguments.tune:
        arguments.out /= TUNING
    (tune if arguments.tune else compare)(size, seeds, arguments)
    print(f"Everything is in {arguments.out}")
    return 0


if __name__ == "__main__":
    parser = parser_for(__doc__, "results/learners")
    add_count(
        parser,
        "--seeds",
        SEEDS,
        QUICK_SEEDS,
        "repetitions of everything, each with training files of its own",
    )
    add_count(
        parser, "--recalls", RECALLS, QUICK_RECALLS, "recalls in each arena after each amount of learning"
    )
    add_count(parser, "--steps", STEPS, QUICK_STEPS, "most steps of trial and error")
    parser.add_argument(
        "--only",
        action="append",
        choices=list(everyone()),
        help="one learner; may be given several times (all)",
    )
    parser.add_argument("--tune", action="store_true", help="compare settings of each learner instead")
    parser.add_argument("--jobs", type=int, default=-1, help="processes; -1 is one a core (-1)")
    parser.add_argument(
        "--backend", choices=list(BACKENDS), default="loky", help="who works: loky is this machine (loky)"
    )
    parser.add_argument("--address", help="of a Ray or Dask cluster (one is started on this machine)")
    given = parser.parse_args()
    if reason := unavailable(given.backend, given.address):
        parser.error(reason)
    sys.exit(run(given))
