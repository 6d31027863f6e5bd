"""The files of a training on disk, compared with what the learner perceived."""

import warnings
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path
from typing import NamedTuple

from lab_comparison.observed_training import Vector

from khepera_forage.cli.train import ATTEMPTS
from khepera_forage.experience import Experience, ExperienceError, ExperienceWarning
from khepera_forage.rollouts.row_files import read_rows
from khepera_forage.rollouts.rows import TrainingRow
from laboratory_faults.watched_training import WatchedAttempt

_LOST = ".lost-"
"""Part of the names of the files of attempts in which something was lost."""
Snapshot = dict[str, bytes]
"""The contents of all files of a folder, by name."""


class StoredAttempt(NamedTuple):
    """The experience of an attempt on disk.

    Attributes:
        vectors: Complete rows.
        name: Of the file; empty if there is none.
    """

    vectors: Sequence[Vector]
    name: str


def snapshot(folder: Path) -> Snapshot:
    """The contents of all files now."""
    return {path.name: path.read_bytes() for path in folder.glob("*.csv")}


def stored_attempts(folder: Path, attempts: Sequence[WatchedAttempt]) -> list[StoredAttempt]:
    """The experience of each attempt on disk. A continued training repeats seeds, so that contents decide, too."""
    files: dict[str, Experience] = {}
    for path in sorted(folder.glob("g*.csv")):
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", ExperienceWarning)
            with suppress(ExperienceError):  # without a header, as a full disk may leave it
                files[path.name] = Experience.load(path, recover=True)
    found = {}
    for is_whole in (True, False):
        for number, attempt in enumerate(attempts):
            if number in found:
                continue
            own = {
                name: list(each)
                for name, each in files.items()
                if each.seed == attempt.seed and (_LOST in name) == bool(attempt.lost)
            }
            whole = [name for name, vectors in own.items() if vectors == attempt.perceived]
            # Only an attempt that an error has interrupted may have a part of its vectors on disk.
            best = whole or sorted(own, key=lambda name: differences(own[name], attempt.perceived))
            if best and (whole or not (is_whole or attempt.discarded)):
                found[number] = StoredAttempt(own[best[0]], best[0])
                del files[best[0]]
    return [found.get(number, StoredAttempt([], "")) for number in range(len(attempts))]


def differences(stored: Sequence[Vector], perceived: Sequence[Vector]) -> int:
    """Stored vectors that were not perceived like this, at this place."""
    return sum(a != b for a, b in zip(stored, perceived, strict=False)) + max(0, len(stored) - len(perceived))


def is_intact(before: Snapshot, folder: Path, discarded: set[int]) -> bool:
    """Whether all experience that was on disk is still there: in its file, or in one with another name.

    Args:
        before: The files at some moment.
        folder: Their folder, later.
        discarded: Seeds of attempts whose experience was discarded later (5.2).
    """
    now = snapshot(folder)
    complete = [row for row in read_rows(folder / ATTEMPTS, TrainingRow) if row.complete]
    for name, data in before.items():
        if name == ATTEMPTS:
            continue
        whole = data[: data.rfind(b"\n") + 1]
        is_there = any(other.startswith(whole) for key, other in now.items() if key != ATTEMPTS)
        if not is_there and not any(f"seed: {seed}\n".encode() in whole for seed in discarded):
            return False
    return len(complete) == len({row.file for row in complete})


def complete_files(folder: Path, attempts: Sequence[WatchedAttempt]) -> tuple[int, int]:
    """Number of complete files with the row of their complete attempt, and of those with other vectors."""
    path = folder / ATTEMPTS
    rows = [row for row in read_rows(path, TrainingRow) if row.complete] if path.exists() else []
    perceived = {a.seed: a.perceived for a in attempts if a.complete}
    complete = foreign = 0
    for file in folder.glob("g*.csv"):
        try:
            experience = Experience.load(file)
        except ExperienceError:
            continue
        own = [row for row in rows if file.name == f"g{row.file}.csv" and row.vectors == len(experience)]
        complete += len(own) == 1
        foreign += perceived.get(experience.seed or 0) != list(experience)
    return complete, foreign
