"""Trainings on disturbed lines: every fault at every rate, for a given number of rounds."""

import logging
import warnings
from collections.abc import Iterator, Sequence
from contextlib import closing, contextmanager, suppress
from dataclasses import dataclass, replace
from itertools import zip_longest
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from _virtual_lab.watched import Notes, Vector, WatchedTraining, moving
from khepera_forage.experience import Experience, ExperienceWarning
from khepera_forage.lab.virtual_laboratory import VirtualLaboratory
from khepera_forage.robots.virtual.faults import FAULTS, Faults
from khepera_forage.rollouts.training import IncompleteTrainingError, train

RATES = (0.001, 0.01, 0.05)
LATENESS = (0.02, 0.2)
"""Seconds by which a delayed reply is late: about half of them less than the driver's timeout, half more."""
NOTHING = "nothing"
"""The condition with no fault at all: the check on the check."""


@dataclass(frozen=True, slots=True)
class DisturbedRow:
    """One attempt at a training episode on disturbed lines; `Notes` says more of most fields.

    Attributes:
        fault: Which, or `nothing`.
        rate: Of it, a share of replies.
        training: Number of the training, from 0; it goes on until an episode is complete.
        attempt: In this training, from 1.
        rounds: That were begun.
        lost: Why its last round was the last, if something was lost.
        kept: Whether its experience is on disk: complete, cut short by a loss, or by the end of the benchmark;
            that of an attempt with a separation is forgotten (5.2).
        replies: Of the robots in its rounds.
        faults: In its rounds.
        unseen: Garbled replies among these that read as other valid ones.
        disturbed: Rounds with a fault.
        recovered: Of these, rounds in which nobody was lost.
        halted: Rounds in which a body did not turn its wheels as its driver had it.
        misread: Rounds after which a driver reported other senses, counters apart, than its body's.
        miscounted: Rounds in which a driver's counters went on otherwise than its body's.
        moving: Robots that moved on when they should have stood.
        vectors: Shown to the learner with a behaviour that it heard.
        stored: On disk.
        altered: On disk otherwise than shown, or missing there, or too many.
        wrong: Of those shown, the untrue ones.
        seconds: Of all rounds.
        longest: Seconds of the longest round.
    """

    fault: str
    rate: float
    training: int
    attempt: int
    rounds: int
    lost: str
    kept: bool
    replies: int
    faults: int
    unseen: int
    disturbed: int
    recovered: int
    halted: int
    misread: int
    miscounted: int
    moving: int
    vectors: int
    stored: int
    altered: int
    wrong: int
    seconds: float
    longest: float


class _Enough(Exception):  # noqa: N818 (it ends a training, and nothing more)
    """There have been as many rounds as were asked for."""


@dataclass(frozen=True, slots=True)
class Disturbed:
    """Trainings of two robots, one after the other, until there have been enough rounds.

    Attributes:
        fault: Which, or `nothing`.
        rate: Of it.
        rounds: How many.
        seed: Of everything.
    """

    fault: str
    rate: float
    rounds: int
    seed: int

    def run(self) -> list[DisturbedRow]:
        """One row an attempt; the last one ends in its midst, as if somebody had pressed Ctrl-C."""
        rates = {} if self.fault == NOTHING else {self.fault: self.rate}
        faults = Faults(lateness=LATENESS, **rates)
        left = self.rounds
        rows: list[DisturbedRow] = []

        def count() -> None:
            nonlocal left
            left -= 1
            if left <= 0:
                raise _Enough

        with (
            unheard(),
            TemporaryDirectory() as folder,
            VirtualLaboratory.from_arena("corridor", 2, fault_seed=self.seed) as lab,
            closing(WatchedTraining(lab, faults, count)) as env,
        ):
            number = 0
            while left > 0:
                path = Path(folder) / f"g{number}.csv"
                with suppress(_Enough, IncompleteTrainingError):
                    train(env, np.random.SeedSequence(self.seed, spawn_key=(number,)), path=path)
                for attempt, note in enumerate(env.notes, start=1):
                    rows.append(
                        self._row(number, attempt, note, _file(path, attempt, attempt == len(env.notes)))
                    )
                env.notes.clear()
                number += 1
            env.close()
            rows[-1] = replace(rows[-1], moving=rows[-1].moving + moving(lab))
        return rows

    def _row(self, training: int, attempt: int, note: Notes, file: Path | None) -> DisturbedRow:
        stored = _read(file) if file is not None else []
        return DisturbedRow(
            fault=self.fault,
            rate=self.rate,
            training=training,
            attempt=attempt,
            rounds=note.rounds,
            lost=note.lost,
            kept=file is not None,
            replies=note.faults.replies,
            faults=note.faults.disturbed,
            unseen=note.faults.undetectable,
            disturbed=note.disturbed,
            recovered=note.recovered,
            halted=note.halted,
            misread=note.misread,
            miscounted=note.miscounted,
            moving=note.moving,
            vectors=len(note.heard),
            stored=len(stored),
            altered=0 if file is None else _differences(stored, note.heard),
            wrong=note.wrong,
            seconds=sum(note.seconds),
            longest=max(note.seconds, default=0.0),
        )


def conditions(rounds: int, seed: int) -> list[Disturbed]:
    """All of them; the slow ones first, so that none is left for the end."""
    work = [Disturbed(fault, rate, rounds, seed) for rate in reversed(RATES) for fault in FAULTS]
    return [*work, Disturbed(NOTHING, 0.0, rounds, seed)]


@contextmanager
def unheard() -> Iterator[None]:
    """Nothing is logged: what was lost is counted here, and not told to anybody."""
    logger = logging.getLogger("khepera_forage")
    before = logger.level
    logger.setLevel(logging.CRITICAL + 1)
    try:
        yield
    finally:
        logger.setLevel(before)


def _file(path: Path, attempt: int, last: bool) -> Path | None:
    """Where the experience of an attempt is on disk, if it is."""
    lost = path.with_name(f"{path.stem}.lost-{attempt}{path.suffix}")
    if lost.exists():
        return lost
    return path if last and path.exists() else None


def _read(path: Path) -> list[Vector]:
    with warnings.catch_warnings():
        # Only that of a complete episode has its closing line.
        warnings.simplefilter("ignore", ExperienceWarning)
        return list(Experience.load(path, recover=True))


def _differences(stored: Sequence[Vector], shown: Sequence[Vector]) -> int:
    return sum(a != b for a, b in zip_longest(stored, shown))
