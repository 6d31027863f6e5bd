"""`khepera-forage train`: train a learner and write its experience files g1.csv, g2.csv, ... (5.3)."""

import argparse
import sys
import warnings
from contextlib import closing
from itertools import count
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from khepera_forage.cli import options
from khepera_forage.cli.options import command, flag, option
from khepera_forage.envs.training import TrainingEnv
from khepera_forage.experience import Experience, ExperienceWarning
from khepera_forage.option_values import progress, whole_number
from khepera_forage.rollouts import training
from khepera_forage.rollouts.row_files import RowWriter, read_rows
from khepera_forage.rollouts.rows import TrainingRow
from khepera_forage.task.decisions import DEFAULT_DECISIONS, Decisions

ATTEMPTS = "attempts.csv"


class PlannedFile(NamedTuple):
    """An experience file to be made: g1.csv, g2.csv, ...; its seed does not depend on how many files there are."""

    number: int
    path: Path
    seed: np.random.SeedSequence


def planned_files(folder: Path, episodes: int, seed: int) -> list[PlannedFile]:
    """All files of a training."""
    seeds = np.random.SeedSequence(seed).spawn(episodes)
    return [PlannedFile(n, folder / f"g{n}.csv", each) for n, each in enumerate(seeds, 1)]


def require_new(files: list[PlannedFile], otherwise: str) -> None:
    """Refuse files that are there already; the message ends with what the user can do `otherwise`."""
    for file in files:
        if file.path.exists():
            raise FileExistsError(f"{file.path} exists; {otherwise}")


_LEARNERS = "learners, each in its own copy of the arena; the first one records (1; with --lab FILE all that it lists)"
_PATIENCE = "rounds that a learner may stay separated before the attempt ends (that of decision patience)"
_CONTINUE = "go on where a run with the same --seed and --out was interrupted, or add episodes to it"


@command(
    options.episodes(10, "complete training episodes, one file each"),
    options.seed("the same seed gives the same files"),
    options.out("experience", "folder for g1.csv, g2.csv, ... and attempts.csv"),
    options.ARENA,
    options.FOOD_TYPE,
    option("--num-learners", _LEARNERS, whole_number(1)),
    option("--patience", _PATIENCE, whole_number(1)),
    flag("--resume", "pause and resume (5.3.1): place a separated learner beside the teacher, and go on"),
    flag("--continue", _CONTINUE, dest="continued"),
    options.LAB,
    options.DECISION,
)
def train_command(arguments: argparse.Namespace) -> int:
    """Train a learner in the paired corridors and save its experience."""
    options.refuse_ignored_in_laboratory(arguments)
    decisions = options.decisions_of(arguments)
    own, decided = arguments.patience, decisions.patience
    if own is not None and decided not in (own, DEFAULT_DECISIONS.patience):
        raise ValueError(f"--patience is {own}, --decision patience={decided}; allowed: one of them")
    files, rows = files_to_record(arguments)
    if not files:
        print(f"all {arguments.episodes} files are in {arguments.out} already")
        return 0
    with closing(options.training_env(arguments, patience=arguments.patience)) as env:
        try:
            record(env, files, rows, arguments)
        except FileExistsError:  # all files were new when the command began
            allowed = "allowed: another one, or --continue after that run has ended"
            raise FileExistsError(f"--out is {str(arguments.out)!r}, where another run writes; {allowed}") from None
        except (OSError, KeyboardInterrupt):
            print("the same command with --continue goes on from here", file=sys.stderr)
            raise
        options.print_late_rounds(env)
    return 0


def files_to_record(arguments: argparse.Namespace) -> tuple[list[PlannedFile], list[TrainingRow]]:
    """The files of the training that are not complete, and the rows of the others; makes the folder."""
    arguments.out.mkdir(parents=True, exist_ok=True)
    files = planned_files(arguments.out, arguments.episodes, arguments.seed)
    if arguments.continued:
        arena = options.arena_of(arguments)
        # The file of a laboratory names another arena.
        name = None if arguments.lab is not None else arena if isinstance(arena, str) else arena.name
        return _unfinished(arguments.out, files, name, options.decisions_of(arguments))
    require_new(files, "--continue goes on after it, or choose another --out")
    return files, []


def record(env: TrainingEnv, files: list[PlannedFile], rows: list[TrainingRow], arguments: argparse.Namespace) -> None:
    """Write one file for each complete episode, and one row for each attempt after those of an earlier run."""
    hidden = arguments.lab is not None  # an operator of real robots answers questions on that screen
    with RowWriter(arguments.out / ATTEMPTS, TrainingRow) as attempts:
        if rows:
            attempts.write(*rows)
        about: dict[str, Any] = {"resume": arguments.resume, "on_attempt": attempts.write}
        for number, path, each in progress(files, hidden, unit="episode"):
            experience, own = training.train(env, each, file=number, path=path, **about)
            print(f"{path}: {len(experience)} experience vectors, {len(own)} attempt(s), {own[-1].rounds} rounds")


def _unfinished(
    folder: Path, files: list[PlannedFile], arena: str | None, decisions: Decisions
) -> tuple[list[PlannedFile], list[TrainingRow]]:
    """The files that an earlier run with the same seed has not finished, and the rows of those that it has.

    Errors come before any change. The file of an interrupted episode, which is recorded again, is kept under another
    name, such as `g3.interrupted-1.csv`.
    """
    attempts = folder / ATTEMPTS
    rows = read_rows(attempts, TrainingRow) if attempts.exists() else []
    there = [file for file in files if file.path.exists()]
    for file in [file for file in there if not _is_complete(file, arena, decisions)]:
        names = (file.path.with_name(f"{file.path.stem}.interrupted-{n}.csv") for n in count(1))
        kept = next(name for name in names if not name.exists())
        file.path.rename(kept)
        print(f"{file.path} was interrupted; its vectors are kept in {kept}")
    left = [file for file in files if not file.path.exists()]
    numbers = {file.number for file in left}
    without = {file.number for file in files} - numbers - {row.file for row in rows if row.complete}
    if without:
        print(f"{attempts} has no row of the complete episodes {', '.join(map(str, sorted(without)))}", file=sys.stderr)
    return left, [row for row in rows if row.file not in numbers]


def _is_complete(file: PlannedFile, arena: str | None, decisions: Decisions) -> bool:
    """Whether the file of an episode has its closing line; one of another arena or seed is an error."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", ExperienceWarning)
        experience = Experience.load(file.path, arena=arena, decisions=decisions, recover=True)
    if experience.seed not in file.seed.generate_state(decisions.most_attempts).tolist():
        raise ValueError(f"{file.path} is of another --seed; allowed with --continue: the same one")
    return not any(issubclass(warning.category, ExperienceWarning) for warning in caught)
