"""The experience files that a training makes: all of a new folder, or those that an interrupted run left open."""

import warnings
from itertools import count
from pathlib import Path
from typing import NamedTuple

import numpy as np

from khepera_forage.experience import Experience, ExperienceWarning
from khepera_forage.files import replacing
from khepera_forage.rollouts.row_files import read_rows, write_rows
from khepera_forage.rollouts.rows import TrainingRow
from khepera_forage.task.decisions import Decisions

ATTEMPTS = "attempts.csv"


class PlannedFile(NamedTuple):
    """An experience file to be made.

    Attributes:
        number: From 1.
        path: g1.csv, g2.csv, ...
        seed: Of its training. It does not depend on how many files there are.
    """

    number: int
    path: Path
    seed: np.random.SeedSequence


def planned_files(folder: Path, episodes: int, seed: int) -> list[PlannedFile]:
    """All files of a training."""
    seeds = np.random.SeedSequence(seed).spawn(episodes)
    return [PlannedFile(n, folder / f"g{n}.csv", each) for n, each in enumerate(seeds, 1)]


def require_new(files: list[PlannedFile], otherwise: str) -> None:
    """Check that none of the files is there already.

    Args:
        files: To be made.
        otherwise: What else the user can do, for the message.

    Raises:
        FileExistsError: One is.
    """
    for file in files:
        if file.path.exists():
            raise FileExistsError(f"{file.path} exists; {otherwise}")


def unfinished(folder: Path, files: list[PlannedFile], decisions: Decisions) -> list[PlannedFile]:
    """The files that an earlier run with the same seed has not finished.

    The file of an interrupted episode is kept under another name, such as `g3.interrupted-1.csv`, and the rows of its
    attempts are removed from `attempts.csv`, because the episode is recorded again.

    Args:
        folder: Of the files.
        files: All files of the training.
        decisions: Those of the files.

    Raises:
        ExperienceError: A file is no experience file, or of other decisions. Nothing is changed then.
        ValueError: A file is of another seed. Nothing is changed then.
    """
    there = [file for file in files if file.path.exists()]
    interrupted = [file for file in there if not _is_complete(file, decisions)]
    for file in interrupted:
        names = (file.path.with_name(f"{file.path.stem}.interrupted-{n}.csv") for n in count(1))
        kept = next(name for name in names if not name.exists())
        file.path.rename(kept)
        print(f"{file.path} was interrupted; its vectors are kept in {kept}")
    left = [file for file in files if not file.path.exists()]
    _forget_attempts(folder / ATTEMPTS, {file.number for file in left})
    return left


def _is_complete(file: PlannedFile, decisions: Decisions) -> bool:
    """Whether the file of an episode has its closing line.

    Raises:
        ExperienceError: It is no experience file, or of other decisions.
        ValueError: It is of another seed.
    """
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", ExperienceWarning)
        experience = Experience.load(file.path, decisions=decisions, recover=True)
    if experience.seed not in file.seed.generate_state(decisions.most_attempts).tolist():
        raise ValueError(f"{file.path} is of another --seed; allowed with --continue: the same one")
    return not any(issubclass(warning.category, ExperienceWarning) for warning in caught)


def _forget_attempts(path: Path, numbers: set[int]) -> None:
    """Remove the rows of some files; the old rows are there until all of the new ones are written."""
    if path.exists():
        rows = [row for row in read_rows(path, TrainingRow) if row.file not in numbers]
        with replacing(path) as partial:
            write_rows(partial, TrainingRow, rows)
