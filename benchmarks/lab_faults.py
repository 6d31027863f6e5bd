"""Faults of robots, cables, camera and disk in the middle of whole trainings in the virtual laboratory.

    python benchmarks/lab_faults.py --help

A `lab.toml` with three robots and a camera; real drivers, fleet, video source, tracker and files. In every series of
trainings each kind of fault happens once, in a random round. For each fault: whether the robots stopped, what the user
read, what is on disk, and whether the training went on.
"""

import logging
import sys
import threading
import time
import warnings
from collections.abc import Sequence
from contextlib import closing, redirect_stdout, suppress
from dataclasses import dataclass, field
from functools import partial
from io import StringIO
from itertools import zip_longest
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING
from unittest.mock import patch

import numpy as np
from laboratory import Work
from laboratory.failing_devices import (
    CAMERA,
    KINDS,
    ROBOT,
    Kind,
    Repair,
    Target,
    VirtualCamera,
    begin_soon,
    laboratory,
    write_lab_file,
)
from laboratory.observed_training import Attempt, ObservedTraining, Vector, moving

from khepera_forage.cli import train
from khepera_forage.cli.train import ATTEMPTS
from khepera_forage.estimates import Column, Table, Value, extremes, pick
from khepera_forage.experience import Experience, ExperienceError, ExperienceWarning
from khepera_forage.figures import GREY, OURS, THESIS, WIDTH, legend, new_figure
from khepera_forage.lab.operator import OperatorRequest
from khepera_forage.lab.virtual_laboratory import VirtualLaboratory
from khepera_forage.option_values import OneLineParser
from khepera_forage.rollouts.row_files import read_rows
from khepera_forage.rollouts.rows import TrainingRow
from khepera_forage.study import Count, Page, Picture, collect, finish, parse

if TYPE_CHECKING:
    from matplotlib.figure import Figure

COUNT = Count("series", 34, 1, f"series of trainings, each with {len(KINDS)} faults", adds_units=True)
QUICK = 3
"""Every third kind of fault, with --quick."""
EPISODES = 2
"""Complete episodes that each training plans."""
MAX_ROUNDS = 200
"""Rounds after which an attempt is out of time: most complete ones are shorter."""
PAUSE, QUICK_PAUSE = 30, 10
"""Rounds, at most, from the end of one fault to the next, and with `--quick`."""
RECOVERED, ATTEMPT_LOST, STOPPED = "recovered", "attempt lost", "stopped"
"""Outcomes: the attempt went on; it ended, and another began; the command ended with an error, and was continued."""
UNEXPECTED = Kind("unexpected", ROBOT, lambda _: lambda: None)
_SETTLED = 8
"""Rounds without a loss after which a fault that has passed counts as recovered."""
_IMPATIENCE = 0.25
"""Share of the requests at which the operator presses Enter before the robot on an open line is repaired."""
_LASTS = 60.0
"""Seconds after which a fault that nothing has noticed is repaired."""


@dataclass(slots=True)
class FaultRow:
    """One fault.

    Attributes:
        part: Of the laboratory: robot, camera or disk.
        kind: Name of the kind of fault; `unexpected` for a loss without a fault.
        outcome: `RECOVERED`, `ATTEMPT_LOST` or `STOPPED`.
        seconds: From the beginning of the fault until it had passed, or until the training noticed a loss.
        unattended: Longest time in seconds that a wheel within reach of its line turned since the last round.
        moving: Robots within reach that moved after the attempt had ended.
        out_of_reach: Robots that moved, and that no program can reach.
        notices: Messages: warnings, and the error with which the command ended.
        named: Notices that name the device or file, and the cause.
        requests: Requests to the operator to repair something.
        continued: Whether a round of training followed.
        intact: Whether all that was on disk before the fault was still there at the end of the training.
        perceived: Experience vectors that the learner perceived from the fault until it was over.
        missing: Those among them that are not on disk, unless the attempt was discarded later (5.2).
        altered: Vectors in the file of the attempt that the learner did not perceive like this.
        wrong: Stored vectors that differ from what is true, on the camera's newest scene.
        outdated: Stored vectors perceived while the camera's scene was not that of the round.
        text: The first notice.
    """

    part: str
    kind: str
    outcome: str = ""
    seconds: float = 0.0
    unattended: float = 0.0
    moving: int = 0
    out_of_reach: int = 0
    notices: int = 0
    named: int = 0
    requests: int = 0
    continued: bool = False
    intact: bool = False
    perceived: int = 0
    missing: int = 0
    altered: int = 0
    wrong: int = 0
    outdated: int = 0
    text: str = ""


@dataclass(frozen=True, slots=True)
class TrainingResult:
    """One whole training.

    Attributes:
        faults: Faults in it.
        rounds: Of all attempts.
        attempts: Begun ones.
        planned: Complete episodes planned.
        complete: Complete experience files, each with the row of its complete attempt in `attempts.csv`.
        foreign: Complete files that hold other vectors than a complete attempt's.
        seconds: Of the whole training.
    """

    faults: int
    rounds: int
    attempts: int
    planned: int
    complete: int
    foreign: int
    seconds: float


class WheelWatch:
    """The longest time for which a wheel was commanded to turn since the last round ended, in seconds.

    The virtual laboratory simulates no time while the driver waits, but commands and timeouts of the driver are real.
    Robots that nothing can reach are left out.
    """

    def __init__(self, lab: VirtualLaboratory) -> None:
        self.longest = 0.0
        self.left_out: frozenset[int] = frozenset()
        self.round_end = time.monotonic()
        self._firmwares = lab.firmwares
        self._closing = threading.Event()
        self._thread = threading.Thread(target=self._watch, daemon=True)
        self._thread.start()

    def restart(self) -> None:
        """Forget what was measured."""
        self.longest, self.round_end = 0.0, time.monotonic()

    def close(self) -> None:
        """End the thread."""
        self._closing.set()
        self._thread.join()

    def _watch(self) -> None:
        while not self._closing.wait(0.002):
            since = self.round_end
            if any(f.turning for i, f in enumerate(self._firmwares) if i not in self.left_out):
                self.longest = max(self.longest, time.monotonic() - since)


@dataclass(slots=True)
class Present:
    """A fault that has begun.

    Attributes:
        kind: Of the fault.
        row: What is observed of it.
        device: What messages must name.
        attempt: Number of the attempt in which it began.
        first: Experience vectors that the learner perceived in this attempt before it.
        before: The files at its beginning.
        repair: What ends it; None once it has.
        end: Experience vectors in the attempt when it was over; None if the attempt ended first.
    """

    kind: Kind
    row: FaultRow
    device: str
    attempt: int
    first: int
    before: dict[str, bytes]
    repair: Repair | None
    began: float = field(default_factory=time.monotonic)
    timer: threading.Timer | None = None
    quiet_rounds: int = 0
    end: int | None = None


class Injector:
    """Begins faults of given kinds in random rounds, and observes them.

    Args:
        kinds: In their order.
        rng: Draws rounds, robots and durations.
        pause: Rounds, at most, from the end of one fault to the next.

    Attributes:
        remaining: Kinds that have not happened yet.
        observed: All faults so far.
        notices: What the user has read, and no fault has caused yet.
        folder: Of the present training's files.
        attempts: At the present training.
    """

    def __init__(self, kinds: Sequence[Kind], rng: np.random.Generator, pause: int) -> None:
        self.remaining = list(kinds)
        self.observed: list[Present] = []
        self.notices: list[str] = []
        self._rng, self._pause = rng, pause
        self._wait = self._drawn_wait()
        self._present: Present | None = None
        self._lab: VirtualLaboratory
        self._camera: VirtualCamera
        self._wheels: WheelWatch
        self.folder = Path()
        self.attempts: list[Attempt] = []
        self._repairing = threading.Lock()

    def attach(self, lab: VirtualLaboratory, camera: VirtualCamera, wheels: WheelWatch) -> None:
        """Use another laboratory from now on: the command was started again."""
        self._lab, self._camera, self._wheels = lab, camera, wheels

    def operator(self, request: OperatorRequest) -> None:
        """Carry out a request; repair the present fault if something is lost, or cannot be placed."""
        if request.reason.startswith("reconnect"):
            present = self._observe_end(ATTEMPT_LOST)
            present.row.requests += 1
            # A closed pseudo-terminal's name may by now be that of another process's robot.
            may_wait = all(khepera.connected for khepera in self._lab.virtual_kheperas)
            lasting = present.kind.part == ROBOT and present.kind.duration is None and present.repair
            if may_wait and lasting and self._rng.random() < _IMPATIENCE:
                return
            self._repair(present)
        elif self._present is not None and len(request.errors) > 0:
            self._repair(self._present)
        self._lab.virtual_operator(request)

    def end_round(self, training: ObservedTraining) -> None:
        """Observe a round, and begin or end a fault."""
        attempt, present = training.attempts[-1], self._present
        if attempt.lost:
            self._observe_end(ATTEMPT_LOST)
            return
        self._wheels.round_end = time.monotonic()
        if present is None:
            self._wait -= 1
            if self._wait <= 0 and self.remaining and attempt.perceived:
                self._begin()
        elif present.row.outcome:
            self._finish(present)
        elif present.repair is None:
            present.quiet_rounds += 1
            if present.quiet_rounds >= _SETTLED:
                self._finish(self._observe_end(RECOVERED))

    def stopped(self, error: str) -> None:
        """The command has ended with an error."""
        self.notices.append(error)
        self._repair(self._observe_end(STOPPED))

    def finish(self) -> None:
        """The training is complete."""
        if self._present is not None:
            self._repair(self._present)
            self._finish(self._observe_end(RECOVERED))

    def _begin(self) -> None:
        kind = self.remaining.pop(0)
        robot = int(self._rng.integers(len(self._lab.robots)))
        files = sorted(self.folder.glob("g*.csv"), key=lambda path: path.stat().st_mtime)
        if kind.part == CAMERA:
            device = f"camera {self._lab.settings.camera.source}"
        elif kind.part == ROBOT:
            device = self._lab.robots[robot].port
        else:
            device = str(self.folder / ATTEMPTS if ATTEMPTS in kind.name else self.folder)
        self.notices.clear()
        present = self._observed(kind, device, None)
        target = Target(self._lab, self._camera, self.folder, files[-1], robot, self._rng)
        self._wheels.left_out = frozenset({robot} if kind.unreachable else ())
        present.repair = begin_soon(kind, target)
        duration = kind.duration or (_LASTS, _LASTS)
        present.timer = threading.Timer(float(self._rng.uniform(*duration)), lambda: self._repair(present))
        present.timer.start()

    def _observed(self, kind: Kind, device: str, repair: Repair | None) -> Present:
        before = {} if kind is UNEXPECTED else snapshot(self.folder)
        self._wheels.restart()
        attempt, first = len(self.attempts) - 1, len(self.attempts[-1].perceived)
        row = FaultRow(kind.part, kind.name)
        self._present = Present(kind, row, device, attempt, first, before, repair)
        self.observed.append(self._present)
        return self._present

    def _observe_end(self, outcome: str) -> Present:
        """Observe the robots when the fault has passed, or the attempt has ended, at first because of it."""
        present = self._present or self._observed(UNEXPECTED, "/dev/", lambda: None)
        row = present.row
        if row.outcome:
            return present
        row.outcome = outcome
        row.seconds = time.monotonic() - present.began
        row.unattended = self._wheels.longest
        if outcome != RECOVERED:
            robots = moving(self._lab)
            row.moving = len(robots - self._wheels.left_out)
            row.out_of_reach = len(robots & self._wheels.left_out)
            if outcome == ATTEMPT_LOST:  # after a stop the command has closed the laboratory
                self._wheels.restart()
        return present

    def _repair(self, present: Present) -> None:
        with self._repairing:
            if present.repair is not None:
                present.repair()
                present.repair = None
        if present.timer is not None:
            present.timer.cancel()

    def _finish(self, present: Present) -> None:
        """A round has followed: the next fault may begin."""
        row, causes = present.row, present.kind.cause.split("|")
        row.notices = len(self.notices)
        row.named = sum(
            present.device in notice and any(cause in notice for cause in causes) for notice in self.notices
        )
        row.text = (
            self.notices[0].replace(f"{self.folder.parent}/", "").replace("\n", " ") if self.notices else ""
        )
        row.continued = True
        if present.attempt == len(self.attempts) - 1:
            present.end = len(self.attempts[-1].perceived)
        self.notices.clear()
        self._present = None
        self._wheels.left_out = frozenset()
        self._wait = self._drawn_wait()

    def _drawn_wait(self) -> int:
        return int(self._rng.integers(3, self._pause))


class _Collector(logging.Handler):
    """Appends warnings to a list instead of printing them."""

    def __init__(self, notices: list[str]) -> None:
        super().__init__(logging.WARNING)
        self._notices = notices

    def emit(self, record: logging.LogRecord) -> None:
        self._notices.append(record.getMessage())


def series(number: int, kinds: Sequence[Kind], seed: int, pause: int) -> list[FaultRow | TrainingResult]:
    """Whole trainings, one after the other, until every kind of fault has happened once."""
    rng = np.random.default_rng((seed, number))
    order = [kinds[i] for i in rng.permutation(len(kinds))]
    injector = Injector(order, rng, pause)
    rows: list[FaultRow | TrainingResult] = []
    logger = logging.getLogger("khepera_forage")
    with (
        patch.object(logger, "handlers", [_Collector(injector.notices)]),
        patch.object(logger, "propagate", False),
    ):
        while injector.remaining:
            with TemporaryDirectory() as folder:
                rows += _training(Path(folder).resolve(), injector, rng)
    return rows


def _training(folder: Path, injector: Injector, rng: np.random.Generator) -> list[FaultRow | TrainingResult]:
    """A training with the functions of `khepera-forage train --lab lab.toml`, continued after every error."""
    began, first = time.perf_counter(), len(injector.observed)
    out, lab_file = folder / "experience", write_lab_file(folder)
    injector.folder, injector.attempts = out, []
    attempts = injector.attempts
    parser = OneLineParser()
    for add in train.train_command.options:
        add(parser)
    options = ["--lab", str(lab_file), "--episodes", str(EPISODES), "--out", str(out)]
    options += ["--seed", str(int(rng.integers(2**31)))]
    arguments = parser.parse_args(options)
    with redirect_stdout(StringIO()):
        while files := train.files_to_record(arguments):
            seed = int(rng.integers(2**31))
            with (
                laboratory(lab_file, injector.operator, seed) as (lab, camera),
                closing(WheelWatch(lab)) as wheels,
            ):
                injector.attach(lab, camera, wheels)
                env = ObservedTraining(lab, attempts, injector.end_round)
                env.max_cycles = MAX_ROUNDS
                try:
                    train.record(env, files, arguments)
                    break
                except (ValueError, OSError) as error:  # the command prints one line
                    injector.stopped(str(error))
                except Exception as error:  # and these with a traceback
                    injector.stopped(f"Traceback: {error}")
            arguments = parser.parse_args([*options, "--continue"])
    injector.finish()
    faults = injector.observed[first:]
    _compare_files(faults, attempts, out)
    result = TrainingResult(
        *(len(faults), sum(attempt.rounds for attempt in attempts), len(attempts), EPISODES),
        *(*complete_files(out, attempts), time.perf_counter() - began),
    )
    return [*(fault.row for fault in faults), result]


def snapshot(folder: Path) -> dict[str, bytes]:
    """The contents of all files now, by name."""
    return {path.name: path.read_bytes() for path in folder.glob("*.csv")}


def _compare_files(faults: Sequence[Present], attempts: Sequence[Attempt], out: Path) -> None:
    """Compare the files of a training with what the learner perceived around each fault."""
    stored = stored_attempts(out, attempts)
    discarded = {attempt.seed for attempt in attempts if attempt.discarded}
    for fault in faults:
        row, attempt, vectors = fault.row, attempts[fault.attempt], stored[fault.attempt]
        during, count = slice(fault.first, fault.end), len(vectors)
        row.intact = is_intact(fault.before, out, discarded)
        row.perceived = len(attempt.perceived[during])
        row.missing = 0 if attempt.discarded else row.perceived - len(attempt.perceived[:count][during])
        altered = sum(a != b for a, b in zip(vectors, attempt.perceived, strict=False))
        row.altered = altered + max(0, count - len(attempt.perceived))
        row.wrong = sum(attempt.wrong[:count][during])
        row.outdated = sum(attempt.outdated[:count][during])


def stored_attempts(folder: Path, attempts: Sequence[Attempt]) -> list[list[Vector]]:
    """The experience of each attempt on disk. A continued training repeats seeds, so that contents decide, too."""
    files: dict[str, Experience] = {}
    for path in sorted(folder.glob("g*.csv")):
        # Without a header, as a full disk may leave it.
        with warnings.catch_warnings(), suppress(ExperienceError):
            warnings.simplefilter("ignore", ExperienceWarning)
            files[path.name] = Experience.load(path, recover=True)
    found: dict[int, list[Vector]] = {}
    for whole in (True, False):
        for number, attempt in enumerate(attempts):
            # Only an attempt that an error has interrupted may have a part of its vectors on disk.
            if number in found or (attempt.discarded and not whole):
                continue
            own = [
                (sum(a != b for a, b in zip_longest(file, attempt.perceived)), name)
                for name, file in files.items()
                if file.seed == attempt.seed and (".lost-" in name) == bool(attempt.lost)
            ]
            if own and (not whole or min(own)[0] == 0):
                found[number] = list(files.pop(min(own)[1]))
    return [found.get(number, []) for number in range(len(attempts))]


def is_intact(before: dict[str, bytes], folder: Path, discarded: set[int | None]) -> bool:
    """Whether all experience that was on disk is still there: in its file, or in one with another name.

    Args:
        before: The files at some moment.
        folder: Their folder, later.
        discarded: Seeds of attempts whose experience was discarded later (5.2).
    """
    now = snapshot(folder)
    complete = [row.file for row in read_rows(folder / ATTEMPTS, TrainingRow) if row.complete]
    for name, data in before.items():
        whole = data[: data.rfind(b"\n") + 1]
        is_there = any(other.startswith(whole) for key, other in now.items() if key != ATTEMPTS)
        gone = not is_there and not any(f"seed: {seed}\n".encode() in whole for seed in discarded)
        if gone and name != ATTEMPTS:
            return False
    return len(complete) == len(set(complete))


def complete_files(folder: Path, attempts: Sequence[Attempt]) -> tuple[int, int]:
    """Number of complete files with the row of their complete attempt, and of those with other vectors."""
    path = folder / ATTEMPTS
    rows = [row for row in read_rows(path, TrainingRow) if row.complete] if path.exists() else []
    perceived = {attempt.seed: attempt.perceived for attempt in attempts if attempt.complete}
    complete = foreign = 0
    for file in folder.glob("g*.csv"):
        with suppress(ExperienceError):
            experience = Experience.load(file)
            own = [row for row in rows if file.name == f"g{row.file}.csv" and row.vectors == len(experience)]
            complete += len(own) == 1
            foreign += perceived.get(experience.seed) != list(experience)
    return complete, foreign


def _by_kind(rows: Sequence[FaultRow]) -> list[tuple[Kind, list[FaultRow]]]:
    """The rows of every kind that happened, in the order of the kinds."""
    kinds = [(kind, pick(rows, kind=kind.name)) for kind in (*KINDS, UNEXPECTED)]
    return [(kind, own) for kind, own in kinds if own]


def fault_table(rows: Sequence[FaultRow]) -> Table:
    """Outcomes, motion, experience and messages by kind of fault."""
    note = (
        "Faults in random rounds of trainings of three robots. Recovered: the attempt went on. Attempt lost: the "
        "operator was asked to repair, and another attempt followed. Stopped: the command ended with an error, and was "
        "continued with --continue. Until noticed: seconds from the fault to the end of the attempt or, for a fault "
        "that passed, to the eighth round after it; median [lowest, highest]. Wheels unattended: the longest time for "
        "which a wheel within reach of its line was commanded to turn since the last round had ended. Moving: robots "
        "that moved after the attempt had ended. Out of reach: robots that moved although the driver tried to stop "
        "them, because their line was interrupted and their power supply was not; no program can stop these. Files "
        "damaged: faults after which experience was gone that had been on disk. Missing: vectors perceived during the "
        "fault, and not on disk. Altered: stored other than perceived. Wrong: stored other than the learner's body "
        "senses, or with another behaviour than the teacher's. Outdated: stored while the camera's poses were more "
        "than 15 mm from the true ones. One message: faults after which the user read exactly one warning or error, "
        "which names the device or file and the cause; a fault that passes by itself needs none. Continued: a round of "
        "training followed."
    )
    sums = ("moving", "out_of_reach", "missing", "altered", "wrong", "outdated")
    lines: list[tuple[Value, ...]] = []
    for kind, own in _by_kind(rows):
        none = sum(row.notices == 0 for row in own)
        one = sum(row.notices == row.named == 1 for row in own)
        lines.append(
            (
                *(kind.part, kind.name, len(own)),
                *(len(pick(own, outcome=outcome)) for outcome in (RECOVERED, ATTEMPT_LOST, STOPPED)),
                *(extremes([getattr(row, name) for row in own]) for name in ("seconds", "unattended")),
                *(sum(getattr(row, name) for row in own) for name in sums),
                *(
                    len(pick(own, intact=False)),
                    none,
                    one,
                    len(own) - none - one,
                    len(pick(own, continued=True)),
                ),
            )
        )
    columns = (
        *map(Column, ("part", "fault", "faults", RECOVERED, ATTEMPT_LOST, STOPPED)),
        *(Column(f"{name} (s)", 2, estimate=True) for name in ("until noticed", "wheels unattended")),
        *(Column(name.replace("_", " ")) for name in sums),
        *map(Column, ("files damaged", "no message", "one message", "others", "continued")),
    )
    return Table("faults", "Faults", note, columns, lines)


def training_table(rows: Sequence[TrainingResult]) -> Table:
    """Sums over all trainings."""
    note = (
        f"Whole trainings of {EPISODES} complete episodes each, with the functions of `khepera-forage train --lab "
        "lab.toml`. Complete: files with closing line whose attempt is in attempts.csv. Foreign: complete files that "
        "hold other vectors than their attempt's."
    )
    names = ("faults", "attempts", "rounds", "planned", "complete", "foreign")
    columns = (Column("trainings"), *map(Column, names), Column("hours", digits=2))
    line = (len(rows), *(sum(getattr(row, name) for row in rows) for name in names))
    hours = sum(row.seconds for row in rows) / 3600
    return Table("trainings", "Trainings", note, columns, [(*line, hours)])


def notice_table(rows: Sequence[FaultRow]) -> Table:
    """One message of each kind."""
    note = (
        "What the user reads: the first message after one fault of each kind, without the number of vectors."
    )
    lines: list[tuple[Value, ...]] = []
    for kind, own in _by_kind(rows):
        told = [row.text for row in own if row.text]
        lines += [(kind.name, told[0].partition("; its ")[0])] if told else []
    return Table("notices", "Messages", note, (Column("fault"), Column("message")), lines)


def picture(rows: Sequence[FaultRow]) -> "Figure":
    """Seconds until a fault was noticed, and of wheels without control, by kind."""
    kinds = _by_kind(rows)[::-1]
    figure = new_figure(WIDTH, 0.8 + 0.22 * len(kinds))
    axes = figure.subplots()
    for shift, name, label, colour in (
        (0.2, "seconds", "from the fault until it is noticed, or over", OURS),
        (-0.2, "unattended", "wheels turning since the last round", THESIS),
    ):
        values, low, high = np.array([extremes([getattr(row, name) for row in own]) for _, own in kinds]).T
        spread = [values - low, high - values]
        places = np.arange(len(kinds)) + shift
        axes.barh(places, values, 0.38, color=colour, xerr=spread, ecolor=GREY, capsize=2, label=label)
    axes.set_yticks(range(len(kinds)), [kind.name for kind, _ in kinds])
    axes.set(xlabel="seconds: median, lowest and highest")
    axes.set_xlim(left=0)
    legend(figure, axes, columns=2)
    return figure


def main() -> int:
    """Run the benchmark."""
    given = parse("lab_faults", __doc__, COUNT)
    kinds, pause = (KINDS[::QUICK], QUICK_PAUSE) if given.quick else (KINDS, PAUSE)
    units = [
        Work(f"series {number}", partial(series, number, kinds, given.seed, pause))
        for number in range(given.series)
    ]
    rows = collect(given, units, {FaultRow: "faults", TrainingResult: "trainings"})
    faults = rows.of(FaultRow)
    caption = "seconds until a fault is noticed, and wheels without control"
    parts: list[Table | Picture] = [
        *(fault_table(faults), training_table(rows.of(TrainingResult)), notice_table(faults)),
        Picture("lab_faults", caption, picture(faults)),
    ]
    return finish(given, Page("Faults in the laboratory", parts))


if __name__ == "__main__":
    sys.exit(main())
