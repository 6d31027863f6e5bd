"""One fault after the other in a running training, each with what was observed of it."""

import threading
import time
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from khepera_forage.cli.train import ATTEMPTS
from khepera_forage.lab.operator import OperatorRequest
from khepera_forage.lab.virtual_laboratory import VirtualLaboratory
from laboratory_faults.files_on_disk import Snapshot, snapshot
from laboratory_faults.kinds import CAMERA, ROBOT, Kind, Repair, Target, begin_soon
from laboratory_faults.notices import names
from laboratory_faults.rows import ATTEMPT_LOST, RECOVERED, STOPPED
from laboratory_faults.virtual_camera import VirtualCamera
from laboratory_faults.watched_training import WatchedTraining
from laboratory_faults.wheels import WheelWatch, moving

PAUSE, QUICK_PAUSE = 30, 10
"""Rounds, at most, from the end of one fault to the next, and with `--quick`."""
_SETTLED = 8
"""Rounds without a loss after which a fault that has passed counts as recovered."""
_IMPATIENCE = 0.25
"""Share of the requests at which the operator presses Enter before the robot on an open line is repaired."""
_LASTS = 60.0
"""Seconds after which a fault that nothing has noticed is repaired."""
UNEXPECTED = Kind("unexpected", ROBOT, lambda _: lambda: None)


@dataclass(slots=True)
class Observed:
    """One fault and what was observed of it; see `FaultRow`."""

    kind: Kind
    attempt: int
    round: int
    device: str
    before: Snapshot
    began: float
    repair: Repair | None
    timer: threading.Timer | None = None
    outcome: str = ""
    seconds: float = 0.0
    unattended: float = 0.0
    moving: int = 0
    out_of_reach: int = 0
    notices: list[str] = field(default_factory=list)
    requests: int = 0
    continued: bool = False
    quiet_rounds: int = 0
    first: int = 0
    end: int | None = None

    @property
    def named(self) -> int:
        """Notices that name the device or file, and the cause."""
        return sum(names(notice, self.device, self.kind.cause) for notice in self.notices)


class Injector:
    """Begins faults of given kinds in random rounds, and observes them.

    Args:
        kinds: In their order.
        rng: Draws rounds, robots and durations.
        pause: Rounds, at most, from the end of one fault to the next.

    Attributes:
        observed: All faults so far.
        notices: What the user has read, and no fault has caused yet.
    """

    def __init__(self, kinds: Sequence[Kind], rng: np.random.Generator, pause: int = PAUSE) -> None:
        self.observed: list[Observed] = []
        self.notices: list[str] = []
        self._kinds, self._rng, self._pause = list(kinds), rng, pause
        self._wait = self._drawn_wait()
        self._present: Observed | None = None
        self._lab: VirtualLaboratory
        self._camera: VirtualCamera
        self._wheels: WheelWatch
        self._folder = Path()
        self._repairing = threading.Lock()
        self._attempts = self._rounds = self._perceived = 0

    @property
    def remaining(self) -> int:
        """Number of faults that have not begun."""
        return len(self._kinds)

    def attach(self, lab: VirtualLaboratory, camera: VirtualCamera, wheels: WheelWatch, folder: Path) -> None:
        """Use another laboratory from now on: the command was started again."""
        self._lab, self._camera, self._wheels, self._folder = lab, camera, wheels, folder

    def operator(self, request: OperatorRequest) -> None:
        """Carry out a request; repair the present fault if something is lost, or cannot be placed."""
        present = self._present
        if request.reason.startswith("reconnect"):
            if present is None:
                present = self._present = self._observed(UNEXPECTED, lambda: None)
            self._observe_end(ATTEMPT_LOST)
            present.requests += 1
            # A closed pseudo-terminal's name may by now be that of another process's robot.
            may_wait = all(khepera.connected for khepera in self._lab.virtual_kheperas)
            lasting = present.kind.part == ROBOT and present.kind.duration is None and present.repair
            if may_wait and lasting and self._rng.random() < _IMPATIENCE:
                return
            self._repair(present)
        elif present is not None and len(request.errors) > 0:
            self._repair(present)
        self._lab.virtual_operator(request)

    def end_round(self, training: WatchedTraining) -> None:
        """Observe a round, and begin or end a fault."""
        self._attempts, self._rounds = len(training.attempts), training.attempts[-1].rounds
        attempt, present = training.attempts[-1], self._present
        self._perceived = len(attempt.perceived)
        if attempt.lost:
            if present is None:
                self._present = self._observed(UNEXPECTED, lambda: None)
            self._observe_end(ATTEMPT_LOST)
            return
        self._wheels.end_round()
        if present is None:
            self._wait -= 1
            if self._wait <= 0 and self._kinds and attempt.perceived:
                self._begin(training)
            return
        if present.outcome:
            self._finish(present)
        elif present.repair is None:
            present.quiet_rounds += 1
            if present.quiet_rounds >= _SETTLED:
                self._observe_end(RECOVERED)
                self._finish(present)

    def stopped(self, error: str) -> None:
        """The command has ended with an error."""
        self.notices.append(error)
        if self._present is None:
            self._present = self._observed(UNEXPECTED, lambda: None)
        self._observe_end(STOPPED)
        self._repair(self._present)

    def finish(self) -> None:
        """The training is complete."""
        if self._present is not None:
            self._repair(self._present)
            self._observe_end(RECOVERED)
            self._finish(self._present)

    def _begin(self, training: WatchedTraining) -> None:
        kind = self._kinds.pop(0)
        robot = int(self._rng.integers(len(self._lab.robots)))
        files = sorted(self._folder.glob("g*.csv"), key=lambda path: path.stat().st_mtime)
        if kind.part == CAMERA:
            device = f"camera {self._lab.settings.camera.source}"
        elif kind.part == ROBOT:
            device = self._lab.robots[robot].port
        else:
            device = str(self._folder / ATTEMPTS if ATTEMPTS in kind.name else self._folder)
        self.notices.clear()
        present = self._present = self._observed(kind, None, device)
        target = Target(self._lab, self._camera, self._folder, files[-1], robot, self._rng)
        self._wheels.left_out = frozenset({robot} if kind.unreachable else ())
        present.repair = begin_soon(kind, target)
        duration = (_LASTS, _LASTS) if kind.duration is None else kind.duration
        present.timer = threading.Timer(float(self._rng.uniform(*duration)), lambda: self._repair(present))
        present.timer.start()

    def _observed(self, kind: Kind, repair: Repair | None, device: str = "/dev/") -> Observed:
        before = snapshot(self._folder) if kind is not UNEXPECTED else {}
        self._wheels.restart()
        now = Observed(kind, self._attempts - 1, self._rounds, device, before, time.monotonic(), repair)
        now.first = self._perceived
        self.observed.append(now)
        return now

    def _observe_end(self, outcome: str) -> None:
        """Observe the robots when the fault has passed, or the attempt has ended."""
        present = self._present
        if present is None or present.outcome:
            return
        present.outcome = outcome
        present.seconds = time.monotonic() - present.began
        present.unattended = self._wheels.longest
        if outcome != RECOVERED:
            robots = moving(self._lab)
            present.moving = len(robots - self._wheels.left_out)
            present.out_of_reach = len(robots & self._wheels.left_out)
            if outcome == ATTEMPT_LOST:  # after a stop the command has closed the laboratory
                self._wheels.restart()

    def _repair(self, present: Observed) -> None:
        with self._repairing:
            if present.repair is not None:
                present.repair()
                present.repair = None
        if present.timer is not None:
            present.timer.cancel()

    def _finish(self, present: Observed) -> None:
        """A round has followed: the next fault may begin."""
        present.notices = list(self.notices)
        present.continued = True
        present.end = self._perceived if present.attempt == self._attempts - 1 else None
        self.notices.clear()
        self._present = None
        self._wheels.left_out = frozenset()
        self._wait = self._drawn_wait()

    def _drawn_wait(self) -> int:
        return int(self._rng.integers(3, self._pause))
