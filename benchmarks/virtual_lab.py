"""The virtual laboratory: what bytes and pixels change, what a round takes, and what disturbed lines do.

    python benchmarks/virtual_lab.py --help

Training and recall with real drivers on pseudo-terminals and the real tracker on rendered frames, against the same in
pymunk alone; the time of a round, part by part; and every fault of a line at several rates, with what was stored
compared with what was shown, and that with the truth.
"""

import argparse
import os
import sys
from pathlib import Path
from typing import NamedTuple

from _virtual_lab import page, pictures
from _virtual_lab.compared import recalls, trainings
from _virtual_lab.disturbances import disturbances
from _virtual_lab.episodes import WORLDS, Outcome, Replication, replications
from _virtual_lab.faults import Disturbed, DisturbedRow, conditions
from _virtual_lab.rounds import LOCK_STEP, PACED, TimedRound, Timing
from arguments import add_count, count_of, parser_for, positive
from joblib import Parallel, delayed
from tqdm import tqdm

from khepera_forage.rollouts.row_files import write_rows
from khepera_forage.rollouts.rows import RecallRow, TrainingRow
from khepera_forage.thesis.figures import save

REPLICATIONS, QUICK_REPLICATIONS = 16, 1
FILES, QUICK_FILES = 5, 1
RECALLS, QUICK_RECALLS = 4, 1
ROUNDS, QUICK_ROUNDS = 1000, 25
STEM = "virtual_lab"
_TIMED = {LOCK_STEP: (1000, 60), PACED: (300, 30)}
"""Rounds that are timed, and how many of them with --quick."""


class Results(NamedTuple):
    """All rows."""

    outcomes: list[Outcome]
    disturbed: list[DisturbedRow]
    timed: list[TimedRound]


def work_through(arguments: argparse.Namespace) -> Results:
    """Do all the work: times alone on the machine, then the rest in parallel."""
    quick = arguments.quick
    timings = [Timing(pace, counts[quick], arguments.seed) for pace, counts in _TIMED.items()]
    quiet = not sys.stderr.isatty()
    timed = [row for t in tqdm(timings, desc="round times", unit="pace", disable=quiet) for row in t.run()]
    count = count_of(arguments.replications, REPLICATIONS, quick, QUICK_REPLICATIONS)
    files, number = (QUICK_FILES, QUICK_RECALLS) if quick else (FILES, RECALLS)
    rounds = count_of(arguments.rounds, ROUNDS, quick, QUICK_ROUNDS)
    work: list[Replication | Disturbed] = [
        *conditions(rounds, arguments.seed),
        *replications(count, files, number, arguments.seed),
    ]
    running = Parallel(n_jobs=arguments.jobs, return_as="generator")(delayed(_run)(piece) for piece in work)
    done = list(tqdm(running, total=len(work), desc=STEM, unit="piece", disable=quiet))
    outcomes = [outcome for outcome in done if isinstance(outcome, Outcome)]
    return Results(outcomes, [row for rows in done if isinstance(rows, list) for row in rows], timed)


def _run(piece: Replication | Disturbed) -> Outcome | list[DisturbedRow]:
    return piece.run()


def write(folder: Path, results: Results) -> str:
    """Write tables, rows and pictures.

    Returns:
        The page with the tables.
    """
    folder.mkdir(parents=True, exist_ok=True)
    recalled, disturbed = recalls(results.outcomes), disturbances(results.disturbed)
    tables = (
        page.training_table(trainings(results.outcomes)),
        page.recall_table(
            recalled,
            sum(outcome.repeated for outcome in results.outcomes),
            sum(len(outcome.unplaced) for outcome in results.outcomes),
        ),
        page.round_table(results.timed),
        page.fault_table(disturbed),
        page.experience_table(disturbed),
    )
    drawn = {
        "recalls": pictures.recall_picture(recalled),
        "rounds": pictures.round_picture(results.timed),
        "faults": pictures.fault_picture(disturbed),
    }
    text = "\n".join(table.markdown() for table in tables)
    shown = "\n\n".join(f"![{name}]({name}.png)" for name in drawn)
    (folder / f"{STEM}.md").write_text(f"{text}\n{shown}\n", encoding="utf-8")
    for table in tables:
        (folder / f"{table.stem}.csv").write_text(table.csv(), encoding="utf-8")
    for name, figure in drawn.items():
        save(figure, folder / f"{name}.png")
    for world in WORLDS:
        own = [outcome for outcome in results.outcomes if outcome.world == world]
        write_rows(folder / f"recall_rows_{world}.csv", RecallRow, [r for o in own for r in o.recalls])
        write_rows(folder / f"training_rows_{world}.csv", TrainingRow, [r for o in own for r in o.trainings])
    write_rows(folder / "round_rows.csv", TimedRound, results.timed)
    write_rows(folder / "fault_rows.csv", DisturbedRow, results.disturbed)
    return text


def run(arguments: argparse.Namespace) -> int:
    """Do what the arguments ask for."""
    print(write(arguments.out, work_through(arguments)))
    print(f"Tables, pictures and rows are in {arguments.out}")
    return 0


if __name__ == "__main__":
    parser = parser_for(__doc__, "results/virtual_lab")
    add_count(
        parser, "--replications", REPLICATIONS, QUICK_REPLICATIONS, "trainings and recalls, in each world"
    )
    add_count(parser, "--rounds", ROUNDS, QUICK_ROUNDS, "rounds with each fault at each rate")
    parser.add_argument(
        "--jobs",
        type=positive,
        default=1 + (os.cpu_count() or 1),
        help="processes; by default one more than there are cores, as drivers often wait",
    )
    sys.exit(run(parser.parse_args()))
