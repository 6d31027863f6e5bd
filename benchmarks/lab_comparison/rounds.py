"""The time of a round of two robots, part by part, as fast as possible and on the wall clock.

During the measurement, the methods that make up a round run under a stopwatch, so that every moment of a round counts
for exactly one part.
"""

from contextlib import ExitStack, closing, suppress
from dataclasses import dataclass
from typing import NamedTuple
from unittest.mock import patch

import numpy as np

from khepera_forage.envs.laboratories import virtual_laboratory
from khepera_forage.envs.training import TEACHER, TrainingEnv
from khepera_forage.lab.clock import SimulatedClock, WallClock
from khepera_forage.noise import Noise
from khepera_forage.robots.fleet import Fleet
from khepera_forage.rollouts.training import train
from khepera_forage.vision.rendering.frames import RenderedFrameSource
from khepera_forage.vision.tracker import Tracker
from lab_comparison.stopwatch import OUTSIDE, Sheet, Stopwatch

LOCK_STEP, PACED = "lock-step", "wall clock"
"""As fast as the machine allows; bytes at 38400 baud and rounds in real time."""
_METHODS: tuple[tuple[str, type, str], ...] = (
    ("transmit", Fleet, "transmit"),
    ("wait", WallClock, "wait"),
    ("simulate", SimulatedClock, "wait"),
    ("receive", Fleet, "receive"),
    ("render", RenderedFrameSource, "newest"),
    ("track", Tracker, "update"),
)
"""A part's name, and the method whose time it is, without the parts that the method calls."""
PARTS = {
    "transmit": "transmit",
    "wait": "wait for the clock",
    "simulate": "simulate the bodies",
    "receive": "receive",
    "render": "render",
    "track": "track",
    "decide": "perceive, decide and the rest",
}
"""Names of the parts for people, in the order of a round."""


@dataclass(frozen=True, slots=True)
class TimedRound:
    """One round of a training of two robots; times in ms.

    Attributes:
        pace: `lock-step` or `wall clock`.
        number: Of the round, from 0; the first round of every attempt is left out.
        transmit: Commands to both robots.
        wait: For the clock.
        simulate: The simulated bodies.
        receive: Senses of both robots.
        render: The frame.
        track: The tracker on it.
        decide: The rest: perception of both robots, teacher, learner, following, records.
        late: Whether the round took longer than it should.
    """

    pace: str
    number: int
    transmit: float
    wait: float
    simulate: float
    receive: float
    render: float
    track: float
    decide: float
    late: bool

    @property
    def busy(self) -> float:
        """Milliseconds of the round without the wait."""
        return self.transmit + self.simulate + self.receive + self.render + self.track + self.decide


class EnoughRounds(Exception):  # noqa: N818 (it ends a training, and nothing failed)
    """There have been as many rounds as wanted."""


class Timing(NamedTuple):
    """Rounds of one training after the other.

    Attributes:
        pace: `lock-step` or `wall clock`.
        rounds: How many.
        seed: Of the trainings.
    """

    pace: str
    rounds: int
    seed: int

    @property
    def key(self) -> str:
        """The pace."""
        return f"time of rounds, {self.pace}"

    def run(self) -> list[TimedRound]:
        """Measure them."""
        rows: list[TimedRound] = []
        paced = self.pace == PACED
        watch = Stopwatch()
        with ExitStack() as stack:
            for part, owner, name in _METHODS:
                method = getattr(owner, name)
                stack.enter_context(patch.object(owner, name, watch.timed(method, part)))
            lab = stack.enter_context(virtual_laboratory("corridor", 2, paced=paced, real_time=paced))
            env = stack.enter_context(closing(TrainingEnv(noise=Noise.none(), world=lab)))
            late = 0

            def note() -> None:
                nonlocal late
                sheet, watch.sheet = watch.sheet, Sheet()
                if env.infos[TEACHER]["steps"] > 1:  # the first round includes the operator's work
                    times = {part: 1000 * sheet.seconds[part] for part, _, _ in _METHODS}
                    times["decide"] = 1000 * sheet.seconds[OUTSIDE]
                    was_late = lab.clock.overruns > late
                    rows.append(TimedRound(self.pace, len(rows), **times, late=was_late))
                late = lab.clock.overruns
                if len(rows) >= self.rounds:
                    raise EnoughRounds

            with suppress(EnoughRounds):
                for seed in np.random.SeedSequence(self.seed).spawn(self.rounds):
                    train(env, seed, callback=note)
        return rows
