"""Faults of robots, cables and camera in the middle of trainings in the virtual laboratory.

    python benchmarks/lab_faults.py --help

Every fault has a training of its own, of three robots and a camera, with real drivers, fleet, video source, tracker and
files. For each fault: when it was noticed, whether the robots stopped, what the user read, whether the training went
on, and whether its experience is on disk, and true.
"""

import logging
import math
import sys
import threading
import time
import warnings
from collections.abc import Callable, Collection, Sequence
from contextlib import AbstractContextManager, ExitStack, nullcontext, suppress
from dataclasses import dataclass
from functools import partial
from itertools import chain, repeat, zip_longest
from logging.handlers import BufferingHandler
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any, NamedTuple
from unittest.mock import Mock, patch

import cv2
import numpy as np
from numpy.typing import NDArray

from khepera_forage.envs.laboratories import virtual_laboratory
from khepera_forage.envs.training import TEACHER, TrainingEnv
from khepera_forage.estimates import Table, Value, extremes, pick, table_of
from khepera_forage.experience import Experience, ExperienceWarning
from khepera_forage.figures import OURS, THESIS, WIDTH, legend, levels, new_figure
from khepera_forage.lab.operator import OperatorRequest
from khepera_forage.lab.virtual_laboratory import VirtualLaboratory
from khepera_forage.noise import Noise
from khepera_forage.policies.policy import HEARD
from khepera_forage.robots.serial.line import LineTooSlow
from khepera_forage.robots.virtual.virtual_khepera import Faults
from khepera_forage.rollouts.rows import TrainingRow
from khepera_forage.rollouts.training import ROBOT_LOST, train
from khepera_forage.study import Count, Job, Page, Picture, collect, finish, parse
from khepera_forage.task.states import Behaviour, StateVector
from khepera_forage.vision.video import VideoSource

if TYPE_CHECKING:
    from matplotlib.figure import Figure

COUNT = Count("series", 10, 1, "faults of each kind, each in a training of its own", adds_units=True)
ROBOTS, LEARNER = 3, "learner_0"
MAX_ROUNDS = 200
"""Rounds after which an attempt is out of time: most complete ones are shorter."""
_FIRST, _LAST = 3, 30
"""Rounds of a training between which a fault begins: all complete attempts are longer."""
_MOMENT = 0.01
"""Seconds: a fault begins within this time, so that it hits any part of a round."""
_FRAME_INTERVAL = 0.02
"""Seconds: 50 frames a second."""
_SETTLED = 8
"""Rounds without a loss after which a fault that has passed counts as recovered."""
_OUTDATED = 15.0
"""mm between the pose that the camera has reported and the true one. A robot drives 8 mm in a round."""
_SETTLING, _AFTERWARDS = 0.5, 3
"""mm by which a standing robot that touches a wall or food may be pushed back by it, within some rounds."""
RECOVERED, ATTEMPT_LOST = "recovered", "attempt lost"
"""Outcomes: the attempt went on; it ended, and another began."""


class VirtualCamera:
    """A camera below OpenCV, which shows one picture, with new sensor noise in every frame.

    Attributes:
        fault: `silent`, `failing`, `raising`, `frozen`, `black`, `overexposed`, `no signal`, `resized`, or empty.
    """

    def __init__(self) -> None:
        self.fault = ""
        self._picture = self._last = np.full((480, 640), 110, np.uint8)
        self._noise = np.random.default_rng(0).integers(0, 2, self._picture.shape, np.uint8)
        self._reads = 0
        self._is_new = False
        self._exposed, self._delivered = threading.Event(), threading.Event()

    def capture(self, source: int) -> Mock:
        """What `cv2.VideoCapture` returns, as far as it is used."""
        return Mock(get=Mock(return_value=1 / _FRAME_INTERVAL), read=self._read)

    def expose(self, picture: NDArray[np.uint8]) -> None:
        """Show a new picture; returns when it has been delivered, or cannot be."""
        self._picture = picture
        self._delivered.clear()
        self._exposed.set()
        if self.fault not in ("silent", "failing", "raising"):
            self._delivered.wait(0.1)

    def _read(self) -> tuple[bool, Any]:
        """The next frame, as OpenCV gives it. The reader has finished with the one before."""
        if self._is_new:
            self._delivered.set()
        self._is_new = self._exposed.wait(_FRAME_INTERVAL)
        while self.fault == "silent":
            time.sleep(_FRAME_INTERVAL)
        if self.fault == "raising":
            raise cv2.error("(-215:Assertion failed) !image.empty() in function 'retrieve'")
        if self._is_new:
            self._exposed.clear()
        self._reads += 1
        noisy = self._picture ^ np.roll(self._noise, 641 * self._reads)
        if self.fault != "frozen":
            self._last = noisy
        frames = {
            "black": noisy >> 5,
            "overexposed": cv2.add(noisy, noisy),
            "no signal": (noisy & 1) + 16,
            "resized": np.ascontiguousarray(noisy[:360]),
        }
        return self.fault != "failing", frames.get(self.fault, self._last)


class Target(NamedTuple):
    """What a fault hits: a robot by its number, or the camera."""

    lab: VirtualLaboratory
    camera: VirtualCamera
    robot: int


Begin = Callable[[Target], AbstractContextManager[object]]
"""Begins a fault when it is entered, and repairs it when it is left."""


def _line(**changes: Any) -> Begin:
    """A fault that changes attributes of the line to a robot."""
    return lambda target: patch.multiple(target.lab.virtual_kheperas[target.robot], **changes)


def _garbled(**rates: Any) -> Begin:
    return _line(faults=Faults(**rates))


def _camera(fault: str) -> Begin:
    return lambda target: patch.object(target.camera, "fault", fault)


def _restart(target: Target) -> AbstractContextManager[object]:
    """The power supply fails for a moment, during one reply."""
    return _line(faults=Mock(draw=Mock(side_effect=chain(["reset"], repeat(None)))))(target)


def _restart_without_banner(target: Target) -> AbstractContextManager[object]:
    target.lab.firmwares[target.robot].power_on()
    return nullcontext()


def _without_power(target: Target) -> AbstractContextManager[object]:
    target.lab.firmwares[target.robot].power_on()
    return _line(interrupted=True)(target)


def _all_unplugged(target: Target) -> AbstractContextManager[object]:
    for khepera in target.lab.virtual_kheperas:
        khepera.faults = Faults(unplug=1.0)
    return nullcontext()


def _port_pulled(target: Target) -> AbstractContextManager[object]:
    target.lab.virtual_kheperas[target.robot].close()
    return nullcontext()


class Kind(NamedTuple):
    """A kind of fault of a part of the laboratory.

    Attributes:
        lasts: Shortest and longest time in seconds until it passes by itself, or is repaired although nothing has
            noticed it.
        cause: What a message about it must contain; `|` separates alternatives.
        unreachable: Whether the robot drives on out of reach of its serial line.
    """

    name: str
    part: str
    begin: Begin
    lasts: tuple[float, float] = (60.0, 60.0)
    cause: str = ""
    unreachable: bool = False


ROBOT, CAMERA = "robot", "camera"
_BURST, _CUT, _CAMERA_BURST = (0.05, 0.5), (0.05, 1.5), (0.05, 0.3)
KINDS = (
    Kind("restarts", ROBOT, _restart, _BURST),
    Kind("restarts, banner lost", ROBOT, _restart_without_banner, _BURST),
    Kind("replies garbled for a while", ROBOT, _garbled(garble=0.3), _BURST),
    Kind("replies late for a while", ROBOT, _garbled(delay=0.3, lateness=(0.02, 0.2)), _BURST),
    Kind("replies lost for a while", ROBOT, _garbled(drop=0.3), _BURST),
    Kind("line cut for a while", ROBOT, _line(interrupted=True), _CUT, unreachable=True),
    Kind("all replies garbled", ROBOT, _garbled(garble=1.0)),
    Kind("power supply lost", ROBOT, _without_power),
    Kind("cable unplugged", ROBOT, _garbled(unplug=1.0)),
    Kind("all cables unplugged", ROBOT, _all_unplugged),
    Kind("line cut, robot on its battery", ROBOT, _line(interrupted=True), unreachable=True),
    Kind("port pulled, robot on its battery", ROBOT, _port_pulled, unreachable=True),
    Kind("no frames for a while", CAMERA, _camera("silent"), _CAMERA_BURST),
    Kind("frozen for a while", CAMERA, _camera("frozen"), _CAMERA_BURST),
    Kind("black for a while", CAMERA, _camera("black"), _CAMERA_BURST),
    Kind("overexposed for a while", CAMERA, _camera("overexposed"), _CAMERA_BURST),
    Kind("no frames", CAMERA, _camera("silent"), cause="no frame"),
    Kind("reads fail", CAMERA, _camera("failing"), cause="no frame|no more frames"),
    Kind("reads raise errors", CAMERA, _camera("raising"), cause="Assertion failed"),
    Kind("frozen", CAMERA, _camera("frozen"), cause="has not changed"),
    Kind("black", CAMERA, _camera("black"), cause="underexposed|shows nothing"),
    Kind("overexposed", CAMERA, _camera("overexposed"), cause="overexposed"),
    Kind("no signal", CAMERA, _camera("no signal"), cause="underexposed|shows nothing"),
    Kind("another frame size", CAMERA, _camera("resized"), cause="640 x 360"),
)


class ObservedTraining(TrainingEnv):
    """A training in the virtual laboratory that records what the learner was shown, and whether it was true.

    Attributes:
        perceived: By the seed of each attempt, what the learner was shown when it heard a behaviour: the experience.
        wrong: For each of all these vectors, whether object presence or arm of teacher or learner differ from what the
            simulated body senses.
        outdated: For each, whether teacher or learner were elsewhere than the camera reported.
    """

    def __init__(self, lab: VirtualLaboratory) -> None:
        super().__init__(len(lab.markers) - 1, MAX_ROUNDS, world=lab, noise=Noise.none())
        self.perceived: dict[int | None, list[tuple[StateVector, Behaviour]]] = {}
        self.wrong: list[bool] = []
        self.outdated: list[bool] = []
        self._lab, self._shown = lab, list[tuple[StateVector, Behaviour]]()

    def reset(self, seed: int | None = None, options: dict[str, Any] | None = None) -> None:
        """Start an attempt; see `TrainingEnv.reset`."""
        super().reset(seed, options)
        self._shown = self.perceived[seed] = []

    def observe(self, agent: str) -> NDArray[np.int64]:
        """Observe as in any training; what the learner hears is recorded and compared with the truth."""
        observation: NDArray[np.int64] = super().observe(agent)
        if agent == LEARNER and observation[HEARD] != Behaviour.WAIT:
            self._shown.append((StateVector(*observation[:5].tolist()), Behaviour(int(observation[HEARD]))))
            bodies, wrong, outdated = self._lab.simulation.robots, False, False
            for told, body, pose in list(zip(self.foragers, bodies, self._lab.poses(), strict=True))[:2]:
                senses = body.sense()
                true = bool(senses.object_presence), senses.arm
                wrong |= (bool(told.vector.object_presence), told.vector.arms_height) != true
                outdated |= math.dist(pose[:2], body.pose[:2]) > _OUTDATED
            self.wrong.append(wrong)
            self.outdated.append(outdated)
        return observation


def moving(lab: VirtualLaboratory) -> set[int]:
    """Numbers of the robots that move or turn a wheel while the simulation advances without commands."""
    bodies = lab.simulation.robots
    before = [(body.pose, body.sense()[1:3]) for body in bodies]
    for _ in range(_AFTERWARDS):
        lab.simulation.advance()
    return {
        i
        for i, (body, (pose, pulses)) in enumerate(zip(bodies, before, strict=True))
        if body.sense()[1:3] != pulses or math.dist(body.pose[:2], pose[:2]) > _SETTLING
    }


@dataclass
class FaultRow:
    """One fault of a part of the laboratory, with one of the outcomes above, and its training.

    Attributes:
        seconds: From its beginning until it had passed, or until the training noticed a loss.
        unattended: Longest time in seconds that a wheel within reach of its line turned since the last round.
        moving: Robots within reach that moved after the attempt had ended; `out_of_reach`: others.
        notices: Warnings; `named`: those with device and cause; `text`: all of them.
        vectors: Experience vectors on disk.
        missing: Those that the learner perceived and that are not on disk.
        altered: Those on disk that the learner did not perceive like this.
        wrong: Perceived ones that differ from what is true; `outdated`: perceived on an old scene of the camera.
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
    text: str = ""
    vectors: int = 0
    missing: int = 0
    altered: int = 0
    wrong: int = 0
    outdated: int = 0


class _Observed(Exception):  # noqa: N818 (an event)
    """All that shall be observed of a training has been."""


class FaultyTraining:
    """A training, in a random round of which a fault begins; `row` says what followed."""

    def __init__(self, kind: Kind, rng: np.random.Generator) -> None:
        self.row = FaultRow(kind.part, kind.name)
        self._kind, self._rng = kind, rng
        self._wait, self._robot = int(rng.integers(_FIRST, _LAST)), int(rng.integers(ROBOTS))
        self._camera, self._log = VirtualCamera(), BufferingHandler(1000)
        self._log.setLevel(logging.WARNING)
        self._fault = ExitStack()
        self._timers: list[threading.Timer] = []
        self._began, self._passed, self._quiet_rounds = 0.0, False, 0
        self._ending = threading.Event()
        self._round_end, self._longest = 0.0, 0.0

    def run(self, folder: Path) -> FaultRow:
        """Train until it is known what follows from the fault, and the training has gone on."""
        self._folder, logger, seed = folder, logging.getLogger("khepera_forage"), int(self._rng.integers(2**31))
        ended: list[TrainingRow] = []
        with (
            patch.object(cv2, "VideoCapture", self._camera.capture),
            patch.object(logger, "handlers", [self._log]),
            patch.object(logger, "propagate", False),
            self._opened() as self._lab,
            patch.object(self._lab.clock, "wait", partial(self._wait_and_expose, self._lab.clock.wait)),
        ):
            watch = threading.Thread(target=self._watch_wheels, daemon=True)
            watch.start()
            self._env = ObservedTraining(self._lab)
            with suppress(_Observed):
                train(self._env, seed, path=folder / "g1.csv", callback=self._end_round, on_attempt=ended.append)
            self._ending.set()
            watch.join()
        self._compare({row.seed for row in ended if not row.complete and row.reason != ROBOT_LOST})
        return self.row

    def _compare(self, discarded: Collection[int]) -> None:
        """Compare what is on disk with what the learner perceived; discarded attempts leave no file (5.2)."""
        row, env = self.row, self._env
        with warnings.catch_warnings(action="ignore", category=ExperienceWarning):  # lost ones have no closing line
            files = [Experience.load(file, recover=True) for file in self._folder.glob("g1*.csv")]
        stored = {file.seed: list(file) for file in files}
        for seed, perceived in env.perceived.items():
            if seed not in discarded:
                own = stored.get(seed, [])
                row.vectors += len(own)
                row.missing += max(0, len(perceived) - len(own))
                row.altered += sum(a != b for a, b in zip_longest(own, perceived[: len(own)]))
        row.wrong, row.outdated = sum(env.wrong), sum(env.outdated)

    def _opened(self) -> VirtualLaboratory:
        """Open all devices; again, if a busy machine lets the line to a virtual robot appear too slow."""
        options: dict[str, Any] = {"operator": self._operate, "camera": lambda _: VideoSource(0)}
        while True:
            with suppress(LineTooSlow):
                seed = int(self._rng.integers(2**31))
                return virtual_laboratory("corridor", ROBOTS, fault_seed=seed, **options)

    def _wait_and_expose(self, wait: Callable[[], None]) -> None:
        wait()
        self._camera.expose(self._lab.frame_source.newest()[0])

    def _watch_wheels(self) -> None:
        """A thread: the simulation stands still while the driver waits, but the driver's commands are real."""
        while not self._ending.wait(0.002):
            since = self._round_end
            turning = (f.turning for i, f in enumerate(self._lab.firmwares) if not self._is_out_of_reach(i))
            if any(turning):
                self._longest = max(self._longest, time.monotonic() - since)

    def _is_out_of_reach(self, robot: int) -> bool:
        return self._kind.unreachable and robot == self._robot

    def _operate(self, request: OperatorRequest) -> None:
        """Carry out a request to the operator; repair the fault if something is lost, or cannot be placed."""
        reconnects = request.reason.startswith("reconnect")
        if self._timers and (reconnects or request.errors):
            if not self.row.outcome and reconnects:  # lost between two attempts
                self._note_loss()
            self._repair()
        self._lab.virtual_operator(request)

    def _end_round(self) -> None:
        """Begin the fault, or observe what has become of it."""
        lost = "robot_lost" in self._env.infos[TEACHER]
        if not lost:
            self._round_end = time.monotonic()
        if not self._timers:
            self._wait -= 1
            if self._wait <= 0 and not lost:
                self._begin()
        elif not self.row.outcome:
            self._quiet_rounds += self._passed and not lost
            if lost:
                self._note_loss()
            elif self._quiet_rounds >= _SETTLED:
                self._note_outcome(RECOVERED)
        elif not lost:
            self._note_messages()
            raise _Observed

    def _begin(self) -> None:
        lab, kind = self._lab, self._kind
        self._device = lab.robots[self._robot].port if kind.part == ROBOT else CAMERA
        self._log.buffer.clear()
        self._began, self._longest = time.monotonic(), 0.0
        begin = partial(kind.begin, Target(lab, self._camera, self._robot))
        self._timers = [
            threading.Timer(self._rng.uniform(0, _MOMENT), lambda: self._fault.enter_context(begin())),
            threading.Timer(_MOMENT + self._rng.uniform(*kind.lasts), self._repair),
        ]
        for timer in self._timers:
            timer.start()

    def _repair(self) -> None:
        """End the fault, if it has not passed."""
        beginning, ending = self._timers
        beginning.join()
        ending.cancel()
        self._fault.close()
        self._passed = True

    def _note_loss(self) -> None:
        self._note_outcome(ATTEMPT_LOST)
        robots = moving(self._lab)
        self.row.out_of_reach = sum(map(self._is_out_of_reach, robots))
        self.row.moving = len(robots) - self.row.out_of_reach

    def _note_outcome(self, outcome: str) -> None:
        self.row.outcome = outcome
        self.row.seconds, self.row.unattended = time.monotonic() - self._began, self._longest

    def _note_messages(self) -> None:
        """Note what the user has read until the training went on."""
        texts = [record.getMessage() for record in self._log.buffer]
        causes = self._kind.cause.split("|")
        self.row.notices = len(texts)
        self.row.named = sum(self._device in text and any(cause in text for cause in causes) for text in texts)
        self.row.text = "; then: ".join(texts).replace(f"{self._folder}/", "")


def faults(kind: int, number: int, seed: int) -> list[FaultRow]:
    """A fault of the kind with a place in `KINDS`."""
    rng = np.random.default_rng((seed, kind, number))
    with TemporaryDirectory() as folder:
        return [FaultyTraining(KINDS[kind], rng).run(Path(folder).resolve())]


def _by_kind(rows: Sequence[FaultRow]) -> list[tuple[Kind, list[FaultRow]]]:
    """The rows of every kind that happened, in the order of the kinds."""
    return [(kind, own) for kind in KINDS if (own := pick(rows, kind=kind.name))]


def fault_table(rows: Sequence[FaultRow]) -> Table:
    """Outcomes, motion, messages and experience by kind of fault."""
    note = (
        f"Faults in random rounds of trainings of {ROBOTS} robots. Until noticed: to the end of the attempt, or to the "
        f"{_SETTLED}th round after a fault that passed; median [lowest, highest]. Wheels: within reach of the line. "
        "One message: exactly one, which names device and cause. Vectors: on disk; faulty ones are missing, altered, "
        "wrong or outdated. Message: the first one."
    )
    sums = ("missing", "altered", "wrong", "outdated")
    lines: list[dict[str, Value]] = []
    for kind, own in _by_kind(rows):
        texts = [row.text.partition("; its ")[0] for row in own if row.text]
        lines.append(
            {
                "part": kind.part,
                "fault": kind.name,
                "faults": len(own),
                **{outcome: len(pick(own, outcome=outcome)) for outcome in (RECOVERED, ATTEMPT_LOST)},
                "until noticed (s)": extremes([row.seconds for row in own]),
                "wheels unattended (s)": extremes([row.unattended for row in own]),
                "moving": sum(row.moving for row in own),
                "out of reach": sum(row.out_of_reach for row in own),
                "no message": len(pick(own, notices=0)),
                "one message": len(pick(own, notices=1, named=1)),
                "vectors": sum(row.vectors for row in own),
                "faulty vectors": sum(getattr(row, name) for row in own for name in sums),
                "message": texts[0] if texts else "",
            }
        )
    digits = {"until noticed (s)": 2, "wheels unattended (s)": 2}
    return table_of("faults", "Faults", note, lines, digits)


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
    kinds = range(0, len(KINDS), 3 if given.quick else 1)
    units = [
        Job(f"{KINDS[kind].name}, {number}", faults, (kind, number, given.seed))
        for number in range(given.series)
        for kind in kinds
    ]
    rows = collect(given, units, {FaultRow: "faults"}).of(FaultRow)
    caption = "seconds until a fault is noticed, and wheels without control"
    parts: list[Table | Picture] = [fault_table(rows), Picture("lab_faults", caption, picture(rows))]
    return finish(given, Page("Faults in the laboratory", parts))


if __name__ == "__main__":
    sys.exit(main())
