"""Trainings on disturbed lines: every fault at every rate, for a fixed number of rounds."""

import logging
import warnings
from collections.abc import Iterator, Sequence
from contextlib import closing, contextmanager, suppress
from dataclasses import dataclass, replace
from itertools import zip_longest
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import NamedTuple

import numpy as np

from khepera_forage.envs.laboratories import virtual_laboratory
from khepera_forage.experience import Experience, ExperienceWarning
from khepera_forage.robots.virtual.faults import FAULTS, Faults
from khepera_forage.rollouts.training import IncompleteTrainingError, train
from lab_comparison.observed_training import AttemptRecord, ObservedTraining, Vector, moving
from lab_comparison.rounds import EnoughRounds

RATES = (0.001, 0.01, 0.05)
LATENESS = (0.02, 0.2)
"""Seconds by which a delayed reply is late: about half are below the driver's timeout, half above."""
NO_FAULT = "none"
"""The condition without faults, which checks the measurement itself."""


@dataclass(frozen=True, slots=True)
class DisturbedAttempt:
    """One attempt at a training episode on disturbed lines; see also `AttemptRecord`.

    Attributes:
        fault: Which, or `NO_FAULT`.
        rate: Share of replies with the fault.
        training: Number of the training, from 0; it lasts until an episode is complete.
        attempt: In this training, from 1.
        rounds: Begun rounds.
        lost: What was lost in the last round; empty if nothing was.
        kept: Whether the experience is on disk: of a complete attempt, of one interrupted by a loss, or of the last
            one. That of another incomplete attempt is forgotten (5.2).
        replies: Of the robots in the rounds.
        faults: In the rounds.
        unseen: Garbled replies among these that read as other valid ones.
        disturbed: Rounds with a fault.
        recovered: Rounds with a fault in which no robot was lost.
        halted: Rounds in which a body did not turn its wheels as its driver commanded.
        misread: Rounds after which a driver reported other senses than its body's, counters not considered.
        miscounted: Rounds in which a driver's counters changed differently from its body's.
        moving: Robots that still moved after the end.
        vectors: Shown to the learner with a behaviour.
        stored: Vectors on disk.
        altered: Vectors on disk that differ from those shown, are missing, or are too many.
        wrong: Untrue vectors among those shown.
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


class DisturbedTrainings(NamedTuple):
    """Trainings of two robots, one after the other, for a fixed number of rounds.

    Attributes:
        fault: Which, or `NO_FAULT`.
        rate: Of the fault.
        rounds: How many.
        seed: Of everything.
    """

    fault: str
    rate: float
    rounds: int
    seed: int

    @property
    def key(self) -> str:
        """Fault and rate."""
        return f"fault {self.fault} {self.rate:g}"

    def run(self) -> list[DisturbedAttempt]:
        """One row an attempt; the last attempt is interrupted, as by Ctrl-C."""
        rates = {} if self.fault == NO_FAULT else {self.fault: self.rate}
        faults = Faults(lateness=LATENESS, **rates)
        left = self.rounds
        rows: list[DisturbedAttempt] = []

        def count() -> None:
            nonlocal left
            left -= 1
            if left <= 0:
                raise EnoughRounds

        with (
            logging_off(),
            TemporaryDirectory() as folder,
            virtual_laboratory("corridor", 2, fault_seed=self.seed) as lab,
            closing(ObservedTraining(lab, faults, count)) as env,
        ):
            number = 0
            while left > 0:
                path = Path(folder) / f"g{number}.csv"
                with suppress(EnoughRounds, IncompleteTrainingError):
                    train(env, np.random.SeedSequence(self.seed, spawn_key=(number,)), path=path)
                for attempt, record in enumerate(env.records, start=1):
                    file = _file(path, attempt, attempt == len(env.records))
                    rows.append(self._row(number, attempt, record, file))
                env.records.clear()
                number += 1
            env.close()
            rows[-1] = replace(rows[-1], moving=rows[-1].moving + moving(lab))
        return rows

    def _row(self, training: int, attempt: int, record: AttemptRecord, file: Path | None) -> DisturbedAttempt:
        stored = _read(file) if file is not None else []
        return DisturbedAttempt(
            fault=self.fault,
            rate=self.rate,
            training=training,
            attempt=attempt,
            rounds=record.rounds,
            lost=record.lost,
            kept=file is not None,
            replies=record.faults.replies,
            faults=record.faults.disturbed,
            unseen=record.faults.undetectable,
            disturbed=record.disturbed,
            recovered=record.recovered,
            halted=record.halted,
            misread=record.misread,
            miscounted=record.miscounted,
            moving=record.moving,
            vectors=len(record.heard),
            stored=len(stored),
            altered=0 if file is None else _differences(stored, record.heard),
            wrong=record.wrong,
            seconds=sum(record.seconds),
            longest=max(record.seconds, default=0.0),
        )


def conditions(rounds: int, seed: int) -> list[DisturbedTrainings]:
    """All conditions, the slow ones first."""
    work = [DisturbedTrainings(fault, rate, rounds, seed) for rate in reversed(RATES) for fault in FAULTS]
    return [*work, DisturbedTrainings(NO_FAULT, 0.0, rounds, seed)]


@contextmanager
def logging_off() -> Iterator[None]:
    """Switch logging off: losses are counted here, and need not be reported."""
    logger = logging.getLogger("khepera_forage")
    before = logger.level
    logger.setLevel(logging.CRITICAL + 1)
    try:
        yield
    finally:
        logger.setLevel(before)


def _file(path: Path, attempt: int, last: bool) -> Path | None:
    """The file with the experience of an attempt, if there is one."""
    lost = path.with_name(f"{path.stem}.lost-{attempt}{path.suffix}")
    if lost.exists():
        return lost
    return path if last and path.exists() else None


def _read(path: Path) -> list[Vector]:
    with warnings.catch_warnings():
        # Only the file of a complete episode has a closing line.
        warnings.simplefilter("ignore", ExperienceWarning)
        return list(Experience.load(path, recover=True))


def _differences(stored: Sequence[Vector], shown: Sequence[Vector]) -> int:
    return sum(a != b for a, b in zip_longest(stored, shown))
