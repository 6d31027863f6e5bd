"""Series of whole trainings, in which every kind of fault happens once."""

import time
from collections.abc import Sequence
from contextlib import closing, redirect_stdout
from io import StringIO
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import NamedTuple

import numpy as np

from khepera_forage.cli import train
from khepera_forage.option_values import OneLineParser
from laboratory_faults.files_on_disk import complete_files, differences, is_intact, stored_attempts
from laboratory_faults.injector import PAUSE, Injector, Observed
from laboratory_faults.kinds import KINDS, Kind
from laboratory_faults.laboratories import laboratory, write_lab_file
from laboratory_faults.notices import collected
from laboratory_faults.rows import FaultRow, TrainingResult
from laboratory_faults.watched_training import WatchedAttempt, WatchedTraining
from laboratory_faults.wheels import WheelWatch

EPISODES = 2
"""Complete episodes that each training plans."""


class Series(NamedTuple):
    """Whole trainings, one after the other, until every kind of fault has happened once.

    Attributes:
        number: Of the series.
        kinds: Of faults.
        seed: Of the campaign.
        pause: Rounds, at most, from the end of one fault to the next.
    """

    number: int
    kinds: tuple[Kind, ...]
    seed: int
    pause: int = PAUSE

    @property
    def key(self) -> str:
        """The number."""
        return f"series {self.number}"

    def run(self) -> list[FaultRow | TrainingResult]:
        """Train until all faults have happened and the last training is complete."""
        rng = np.random.default_rng((self.seed, self.number))
        order = [self.kinds[i] for i in rng.permutation(len(self.kinds))]
        injector = Injector(order, rng, self.pause)
        rows: list[FaultRow | TrainingResult] = []
        number = 0
        with collected(injector.notices):
            while injector.remaining:
                with TemporaryDirectory() as folder:
                    rows += _Training(self.number, number, injector, rng).run(Path(folder).resolve())
                number += 1
        return rows


class _Training:
    """One training, with the functions of `khepera-forage train --lab lab.toml`, continued after every error."""

    def __init__(self, series: int, number: int, injector: Injector, rng: np.random.Generator) -> None:
        self._series, self._number = series, number
        self._injector, self._rng = injector, rng
        self._attempts: list[WatchedAttempt] = []
        self._stuck = 0

    def run(self, folder: Path) -> list[FaultRow | TrainingResult]:
        began = time.perf_counter()
        first = len(self._injector.observed)
        out = folder / "experience"
        lab_file = write_lab_file(folder)
        parser = OneLineParser()
        for add in train.train_command.options:
            add(parser)
        seed = int(self._rng.integers(2**31))
        options = [
            "--lab",
            str(lab_file),
            "--episodes",
            str(EPISODES),
            "--seed",
            str(seed),
            "--out",
            str(out),
        ]
        with redirect_stdout(StringIO()):
            while not self._command(parser, [*options], lab_file, out):
                if "--continue" not in options:
                    options.append("--continue")
        self._injector.finish()
        faults = self._injector.observed[first:]
        complete, foreign = complete_files(out, self._attempts)
        result = TrainingResult(
            series=self._series,
            training=self._number,
            faults=len(faults),
            rounds=sum(attempt.rounds for attempt in self._attempts),
            attempts=len(self._attempts),
            planned=EPISODES,
            complete=complete,
            foreign=foreign,
            stuck=self._stuck,
            seconds=time.perf_counter() - began,
        )
        return [*self._fault_rows(faults, out), result]

    def _command(self, parser: OneLineParser, options: list[str], lab_file: Path, out: Path) -> bool:
        """Run the command once; returns whether the training is complete."""
        arguments = parser.parse_args(options)
        try:
            files = train.files_to_record(arguments)
        except ValueError as error:
            self._delete_by_hand(str(error), out)
            return False
        if not files:
            return True
        seed = int(self._rng.integers(2**31))
        with (
            laboratory(lab_file, self._injector.operator, seed) as (lab, camera),
            closing(WheelWatch(lab)) as wheels,
        ):
            self._injector.attach(lab, camera, wheels, out)
            env = WatchedTraining(lab, self._attempts, self._injector.end_round)
            try:
                train.record(env, files, arguments)
                return True
            except (ValueError, OSError) as error:  # the command prints one line
                self._injector.stopped(str(error))
            except Exception as error:  # and these with a traceback
                self._injector.stopped(f"Traceback: {error}")
        return False

    def _delete_by_hand(self, error: str, out: Path) -> None:
        """What a user must do if the command refuses to continue."""
        self._stuck += 1
        self._injector.notices.append(error)
        for path in out.glob("g*.csv"):
            if str(path) in error:
                path.unlink()
                return
        raise RuntimeError(f"the command refuses to continue: {error}")

    def _fault_rows(self, faults: Sequence[Observed], out: Path) -> list[FaultRow]:
        stored = stored_attempts(out, self._attempts)
        discarded = {attempt.seed for attempt in self._attempts if attempt.discarded}
        rows = []
        for fault in faults:
            attempt, file = self._attempts[fault.attempt], stored[fault.attempt]
            count = len(file.vectors)
            during = slice(fault.first, fault.end)
            perceived = len(attempt.perceived[during])
            on_disk = len(attempt.perceived[:count][during])
            rows.append(
                FaultRow(
                    part=fault.kind.part,
                    kind=fault.kind.name,
                    series=self._series,
                    training=self._number,
                    seed=attempt.seed,
                    round=fault.round,
                    outcome=fault.outcome,
                    seconds=fault.seconds,
                    unattended=fault.unattended,
                    moving=fault.moving,
                    out_of_reach=fault.out_of_reach,
                    notices=len(fault.notices),
                    named=fault.named,
                    requests=fault.requests,
                    intact=is_intact(fault.before, out, discarded),
                    before=fault.first,
                    perceived=perceived,
                    stored=on_disk,
                    missing=0 if attempt.discarded else perceived - on_disk,
                    altered=differences(file.vectors, attempt.perceived),
                    wrong=sum(attempt.wrong[:count][during]),
                    outdated=sum(attempt.outdated[:count][during]),
                    continued=fault.continued,
                    text=fault.notices[0].replace(f"{out.parent}/", "").replace("\n", " ")
                    if fault.notices
                    else "",
                )
            )
        return rows


def series(count: int, seed: int, kinds: tuple[Kind, ...] = KINDS, pause: int = PAUSE) -> list[Series]:
    """All series of a campaign."""
    return [Series(number, kinds, seed, pause) for number in range(count)]
