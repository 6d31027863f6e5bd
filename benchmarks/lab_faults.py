"""Faults of robots, cables, camera and disk in the middle of whole trainings in the virtual laboratory.

    python benchmarks/lab_faults.py --help

A `lab.toml` with three robots and a camera; real drivers, fleet, video source, tracker and files. In every series of
trainings each kind of fault happens once, in a random round. For each fault: whether the robots stopped, what the user
read, and whether the training went on; for each training, what is on disk.
"""

import logging
import sys
import threading
import time
import warnings
from collections.abc import Generator, Sequence
from contextlib import closing, redirect_stdout, suppress
from dataclasses import asdict, dataclass
from io import StringIO
from itertools import zip_longest
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, NamedTuple
from unittest.mock import patch

import numpy as np
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
from laboratory.observed_training import ObservedAttempt, ObservedTraining, Vector, moving
from scipy.optimize import linear_sum_assignment

from khepera_forage.cli import train
from khepera_forage.cli.train import ATTEMPTS
from khepera_forage.estimates import Table, Value, extremes, pick, table_of
from khepera_forage.experience import Experience, ExperienceError, ExperienceWarning
from khepera_forage.figures import OURS, THESIS, WIDTH, legend, levels, new_figure
from khepera_forage.lab.operator import OperatorRequest
from khepera_forage.lab.virtual_laboratory import VirtualLaboratory
from khepera_forage.option_values import OneLineParser
from khepera_forage.rollouts.row_files import read_rows
from khepera_forage.rollouts.rows import TrainingRow
from khepera_forage.study import Count, Job, Page, Picture, collect, finish, parse

if TYPE_CHECKING:
    from matplotlib.figure import Figure

COUNT = Count("series", 10, 1, f"series of trainings, each with {len(KINDS)} faults", adds_units=True)
MAX_ROUNDS = 200
"""Rounds after which an attempt is out of time: most complete ones are shorter."""
RECOVERED, ATTEMPT_LOST, STOPPED = "recovered", "attempt lost", "stopped"
"""Outcomes: the attempt went on; it ended, and another began; the command ended with an error, and was continued."""
_ROUND, _COMPLETE = "round", "complete"
"""Further events of a training: a round without a loss, and its end."""
_SETTLED = 8
"""Rounds without a loss after which a fault that has passed counts as recovered."""
_LASTS = (60.0, 60.0)
"""Seconds after which a fault that nothing has noticed is repaired."""
_ANOTHER = 1e6
"""Different vectors of a file that belongs to another attempt."""


class SeriesSize(NamedTuple):
    """How much is done in a series.

    Each kind of fault happens once, at most `pause` rounds after the end of another; each training plans `episodes`
    complete ones.
    """

    kinds: Sequence[Kind] = KINDS
    episodes: int = 2
    pause: int = 30


QUICK = SeriesSize(KINDS[::3], episodes=1, pause=10)


@dataclass
class FaultRow:
    """One fault of a part of the laboratory, with one of the outcomes above.

    Attributes:
        seconds: From its beginning until it had passed, or until the training noticed a loss.
        unattended: Longest time in seconds that a wheel within reach of its line turned since the last round.
        moving: Robots within reach that moved after the attempt had ended; `out_of_reach`: others.
        notices: Warnings, and the error with which the command ended; `named`: those with device or file and cause.
        continued: Whether a round of training followed.
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
    continued: bool = False
    text: str = ""


@dataclass
class TrainingResult:
    """One whole training: what became of the vectors that the learner perceived.

    Attributes:
        vectors: Stored ones.
        missing: Those that are not on disk, unless their attempt was discarded (5.2).
        altered: Stored ones that the learner did not perceive like this.
        wrong: Stored ones that differ from what is true; `outdated`: perceived on an old scene of the camera.
        complete: Whether there is a file for each planned episode, with its closing line, and with the row and the
            vectors of its complete attempt.
    """

    vectors: int = 0
    missing: int = 0
    altered: int = 0
    wrong: int = 0
    outdated: int = 0
    complete: bool = False


class WheelWatch:
    """The longest time for which a wheel was commanded to turn since the last round ended, in seconds.

    The virtual laboratory simulates no time while the driver waits, but commands and timeouts of the driver are real.
    Robots that nothing can reach are left out.
    """

    def __init__(self, lab: VirtualLaboratory) -> None:
        self.left_out: frozenset[int] = frozenset()
        self.restart()
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


class Injector:
    """Begins each kind of fault in a random round of trainings, repairs it, and observes what follows.

    Attributes:
        rows: All faults so far; the last one may be present.
        notices: What the user has read since the beginning of the last fault.
        done: Whether all kinds have happened.
        lab: The laboratory, another one when the command was started again; `camera` and `wheels` are its own.
        folder: Of the training's files; `attempts` are the training's.
    """

    lab: VirtualLaboratory
    camera: VirtualCamera
    wheels: WheelWatch
    folder: Path
    attempts: list[ObservedAttempt]

    def __init__(self, kinds: Sequence[Kind], rng: np.random.Generator, pause: int) -> None:
        self.rows: list[FaultRow] = []
        self.notices: list[str] = []
        self.done = False
        self._rng, self._pause = rng, pause
        self._repair: Repair | None = None
        self._timer: threading.Timer | None = None
        self._repairing = threading.Lock()
        self._events = self._all(kinds)
        next(self._events)

    def operator(self, request: OperatorRequest) -> None:
        """Carry out a request; repair the fault if something is lost, or cannot be placed."""
        if request.reason.startswith("reconnect"):
            self.note(ATTEMPT_LOST)
        if request.reason.startswith("reconnect") or request.errors:
            self.repair()
        self.lab.virtual_operator(request)

    def end_round(self, training: ObservedTraining) -> None:
        """Observe a round."""
        lost = bool(self.attempts[-1].lost)
        if not lost:
            self.wheels.round_end = time.monotonic()
        self.note(ATTEMPT_LOST if lost else _ROUND)

    def note(self, event: str) -> None:
        """Go on after a round, after the end of an attempt or of the command, or after the training is complete."""
        if event == _COMPLETE:
            self.repair()
        self._events.send(event)

    def repair(self) -> None:
        """Repair the fault, if it has begun and has not passed."""
        with self._repairing:
            if self._repair is not None:
                self._repair()
                self._repair = None
        if self._timer is not None:
            self._timer.cancel()

    def _all(self, kinds: Sequence[Kind]) -> Generator[None, str, None]:
        """All faults, one after the other; each `yield` is an event."""
        for number, kind in enumerate(kinds, 1):
            wait = int(self._rng.integers(3, self._pause))
            while wait > 0 or not self.attempts[-1].perceived:
                event = yield
                wait -= event == _ROUND
            row, device, began, quiet = FaultRow(kind.part, kind.name), self._begin(kind), time.monotonic(), 0
            self.rows.append(row)
            self.done = number == len(kinds)
            while not row.outcome:
                event = yield
                row.seconds, row.unattended = time.monotonic() - began, self.wheels.longest
                quiet += event == _ROUND and self._repair is None
                if event in (ATTEMPT_LOST, STOPPED):
                    row.outcome, robots = event, moving(self.lab)
                    row.moving = len(robots - self.wheels.left_out)
                    row.out_of_reach = len(robots & self.wheels.left_out)
                elif event == _COMPLETE or quiet >= _SETTLED:
                    row.outcome = RECOVERED
            while event not in (_ROUND, _COMPLETE):
                event = yield
            row.continued, row.notices = True, len(self.notices)
            causes = kind.cause.split("|")
            row.named = sum(device in text and any(cause in text for cause in causes) for text in self.notices)
            if self.notices:
                row.text = self.notices[0].replace(f"{self.folder.parent}/", "").replace("\n", " ")
            self.wheels.left_out = frozenset()
        while True:
            yield

    def _begin(self, kind: Kind) -> str:
        """Begin a fault; returns the name of the device or file that a message about it must contain."""
        lab, folder, robot = self.lab, self.folder, int(self._rng.integers(len(self.lab.robots)))
        self.notices.clear()
        self.wheels.restart()
        self.wheels.left_out = frozenset({robot} if kind.unreachable else ())
        file = max(folder.glob("g*.csv"), key=lambda path: path.stat().st_mtime)
        port = lab.robots[robot].port
        self._repair = begin_soon(kind, Target(lab, self.camera, folder, file, robot, self._rng))
        self._timer = threading.Timer(float(self._rng.uniform(*(kind.duration or _LASTS))), self.repair)
        self._timer.start()
        if kind.part == CAMERA:
            return f"camera {lab.settings.camera.source}"
        return port if kind.part == ROBOT else str(folder / ATTEMPTS if ATTEMPTS in kind.name else folder)


class _Collector(logging.Handler):
    """Appends warnings to a list instead of printing them."""

    def __init__(self, notices: list[str]) -> None:
        super().__init__(logging.WARNING)
        self._notices = notices

    def emit(self, record: logging.LogRecord) -> None:
        self._notices.append(record.getMessage())


def series(number: int, size: SeriesSize, seed: int) -> list[FaultRow | TrainingResult]:
    """Whole trainings, one after the other, until every kind of fault has happened once."""
    rng = np.random.default_rng((seed, number))
    injector = Injector([size.kinds[i] for i in rng.permutation(len(size.kinds))], rng, size.pause)
    results: list[TrainingResult] = []
    logger = logging.getLogger("khepera_forage")
    with (
        patch.object(logger, "handlers", [_Collector(injector.notices)]),
        patch.object(logger, "propagate", False),
        redirect_stdout(StringIO()),
    ):
        while not injector.done:
            with TemporaryDirectory() as folder:
                results.append(_training(Path(folder).resolve(), size.episodes, injector, rng))
    return [*injector.rows, *results]


def _training(folder: Path, episodes: int, injector: Injector, rng: np.random.Generator) -> TrainingResult:
    """A training with the functions of `khepera-forage train --lab lab.toml`, continued after every error."""
    out, lab_file, attempts = folder / "experience", write_lab_file(folder), list[ObservedAttempt]()
    injector.folder, injector.attempts = out, attempts
    parser = OneLineParser()
    for add in train.train_command.options:
        add(parser)
    options = ["--lab", str(lab_file), "--episodes", str(episodes), "--out", str(out)]
    options += ["--seed", str(int(rng.integers(2**31)))]
    arguments = parser.parse_args(options)
    files, rows = train.files_to_record(arguments)
    while files:
        with (
            laboratory(lab_file, injector.operator, int(rng.integers(2**31))) as (lab, camera),
            closing(WheelWatch(lab)) as wheels,
        ):
            injector.lab, injector.camera, injector.wheels = lab, camera, wheels
            env = ObservedTraining(lab, attempts, injector.end_round)
            env.max_cycles = MAX_ROUNDS
            try:
                train.record(env, files, rows, arguments)
                break
            except Exception as error:
                expected = isinstance(error, ValueError | OSError)  # the command prints one line
                injector.notices.append(str(error) if expected else f"Traceback: {error}")
                injector.note(STOPPED)
                injector.repair()
        files, rows = train.files_to_record(parser.parse_args([*options, "--continue"]))
    injector.note(_COMPLETE)
    return _compared_files(attempts, out, episodes)


def _compared_files(attempts: Sequence[ObservedAttempt], out: Path, episodes: int) -> TrainingResult:
    """Compare the files of a training with what the learner perceived."""
    result = TrainingResult()
    for attempt, vectors in zip(attempts, stored_vectors(out, attempts), strict=True):
        count, perceived = len(vectors), len(attempt.perceived)
        result.vectors += count
        result.missing += 0 if attempt.discarded else max(0, perceived - count)
        result.altered += sum(a != b for a, b in zip(vectors, attempt.perceived, strict=False))
        result.altered += max(0, count - perceived)
        result.wrong += sum(attempt.wrong[:count])
        result.outdated += sum(attempt.outdated[:count])
    rows = [own for own in read_rows(out / ATTEMPTS, TrainingRow) if own.complete]
    complete = {attempt.seed: attempt.perceived for attempt in attempts if attempt.complete}
    files = [Experience.load(out / f"g{number}.csv") for number in range(1, episodes + 1)]
    result.complete = all(complete.get(file.seed) == list(file) for file in files)
    result.complete &= [(own.file, own.vectors) for own in rows] == [*enumerate(map(len, files), 1)]
    return result


def stored_vectors(folder: Path, attempts: Sequence[ObservedAttempt]) -> list[list[Vector]]:
    """The experience of each attempt on disk. A continued training repeats seeds: the most similar file is its own."""
    files: dict[str, Experience] = {}
    for path in sorted(folder.glob("g*.csv")):
        # Without a header, as a full disk may leave it.
        with warnings.catch_warnings(), suppress(ExperienceError):
            warnings.simplefilter("ignore", ExperienceWarning)
            files[path.name] = Experience.load(path, recover=True)

    def cost(attempt: ObservedAttempt, name: str) -> float:
        """Number of different vectors; the file of a lost attempt has another name, or attempts.csv was full, too."""
        different: list[bool] = [a != b for a, b in zip_longest(files[name], attempt.perceived)]
        return sum(different) + 0.5 * ((".lost-" in name) != bool(attempt.lost))

    costs = np.array(
        [
            [cost(attempt, name) if file.seed == attempt.seed else _ANOTHER for name, file in files.items()]
            for attempt in attempts
        ]
    )
    found: list[list[Vector]] = [[] for _ in attempts]
    for number, file in zip(*linear_sum_assignment(costs), strict=True):
        if costs[number, file] < _ANOTHER:
            found[number] = list(list(files.values())[file])
    return found


def _by_kind(rows: Sequence[FaultRow]) -> list[tuple[Kind, list[FaultRow]]]:
    """The rows of every kind that happened, in the order of the kinds."""
    return [(kind, own) for kind in KINDS if (own := pick(rows, kind=kind.name))]


def fault_table(rows: Sequence[FaultRow]) -> Table:
    """Outcomes, motion, experience and messages by kind of fault."""
    note = (
        "Faults in random rounds of trainings of three robots. Until noticed: to the end of the attempt, or to the "
        "eighth round after a fault that passed; median [lowest, highest]. Wheels: within reach of the line. "
        "One message: exactly one, which names device or file and cause. Message: the first one."
    )
    lines: list[dict[str, Value]] = []
    for kind, own in _by_kind(rows):
        texts = [row.text.partition("; its ")[0] for row in own if row.text]
        lines.append(
            {
                "part": kind.part,
                "fault": kind.name,
                "faults": len(own),
                **{outcome: len(pick(own, outcome=outcome)) for outcome in (RECOVERED, ATTEMPT_LOST, STOPPED)},
                "until noticed (s)": extremes([row.seconds for row in own]),
                "wheels unattended (s)": extremes([row.unattended for row in own]),
                "moving": sum(row.moving for row in own),
                "out of reach": sum(row.out_of_reach for row in own),
                "no message": len(pick(own, notices=0)),
                "one message": len(pick(own, notices=1, named=1)),
                "continued": len(pick(own, continued=True)),
                "message": texts[0] if texts else "",
            }
        )
    digits = {"until noticed (s)": 2, "wheels unattended (s)": 2}
    return table_of("faults", "Faults", note, lines, digits)


def training_table(rows: Sequence[TrainingResult], episodes: int) -> Table:
    """Sums over all trainings."""
    note = f"Whole trainings, each for {episodes} complete episode(s), and the vectors that they stored."
    sums = {name: sum(getattr(row, name) for row in rows) for name in asdict(TrainingResult())}
    return table_of("trainings", "Trainings", note, [{"trainings": len(rows), **sums}])


def picture(rows: Sequence[FaultRow]) -> "Figure":
    """Seconds until a fault was noticed, and of wheels without control, by kind."""
    shown = {
        kind.name: [extremes([row.seconds for row in own]), extremes([row.unattended for row in own])]
        for kind, own in _by_kind(rows)
    }
    figure = new_figure(WIDTH, 0.8 + 0.22 * len(shown))
    axes = figure.subplots()
    names = ("from the fault until it is noticed, or over", "wheels turning since the last round")
    levels(axes, shown, "seconds: median, lowest and highest", names, (OURS, THESIS))
    legend(figure, axes, columns=2)
    return figure


def main() -> int:
    """Run the benchmark."""
    given = parse("lab_faults", __doc__, COUNT)
    size = QUICK if given.quick else SeriesSize()
    units = [Job(f"series {number}", series, (number, size, given.seed)) for number in range(given.series)]
    rows = collect(given, units, {FaultRow: "faults", TrainingResult: "trainings"})
    faults = rows.of(FaultRow)
    caption = "seconds until a fault is noticed, and wheels without control"
    parts: list[Table | Picture] = [
        *(fault_table(faults), training_table(rows.of(TrainingResult), size.episodes)),
        Picture("lab_faults", caption, picture(faults)),
    ]
    return finish(given, Page("Faults in the laboratory", parts))


if __name__ == "__main__":
    sys.exit(main())
