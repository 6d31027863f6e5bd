"""What a round of two robots takes, part by part, as fast as it goes and on the wall clock.

For the time of the measurement the public methods that make up a round are replaced on their classes by the same
methods under a stopwatch, so that every moment of a round counts for exactly one part.
"""

from contextlib import ExitStack, closing, suppress
from dataclasses import dataclass
from unittest.mock import patch

import numpy as np
from _throughput.stopwatch import OUTSIDE, Sheet, Stopwatch

from khepera_forage.envs.training import TEACHER, TrainingEnv
from khepera_forage.lab.clock import SimulatedClock, WallClock
from khepera_forage.lab.virtual_laboratory import VirtualLaboratory
from khepera_forage.noise import Noise
from khepera_forage.robots.serial.fleet import Fleet
from khepera_forage.rollouts.training import train
from khepera_forage.vision.rendering.frames import RenderedFrameSource
from khepera_forage.vision.tracker import Tracker

LOCK_STEP, PACED = "lock-step", "wall clock"
"""As fast as the machine goes; bytes at 38400 baud and rounds of 100 ms."""
_METHODS: tuple[tuple[str, type, str], ...] = (
    ("transmit", Fleet, "transmit"),
    ("wait", WallClock, "wait"),
    ("physics", SimulatedClock, "wait"),
    ("receive", Fleet, "receive"),
    ("render", RenderedFrameSource, "newest"),
    ("track", Tracker, "update"),
)
"""A part's name, and the method whose time is its, without the parts that it calls."""
PARTS = {
    "transmit": "transmit",
    "wait": "wait for the beat",
    "physics": "physics",
    "receive": "receive",
    "render": "render",
    "track": "track",
    "decide": "perceive, decide and the rest",
}
"""What the parts are called, in the order of a round."""


@dataclass(frozen=True, slots=True)
class TimedRound:
    """One round of a training of two robots; times in ms.

    Attributes:
        pace: `lock-step` or `wall clock`.
        number: Of the round, from 0; the first round of every attempt is left out.
        transmit: Commands to both robots.
        wait: For the beat of 100 ms.
        physics: The simulated bodies.
        receive: Senses of both robots.
        render: The frame.
        track: The tracker on it.
        decide: All the rest: perception of both robots, teacher, learner, following, records.
        late: Whether the beat was missed.
    """

    pace: str
    number: int
    transmit: float
    wait: float
    physics: float
    receive: float
    render: float
    track: float
    decide: float
    late: bool

    @property
    def busy(self) -> float:
        """What the round took without waiting, in ms."""
        return self.transmit + self.physics + self.receive + self.render + self.track + self.decide


class _Enough(Exception):  # noqa: N818 (it ends a training, and nothing more)
    """There have been as many rounds as were asked for."""


@dataclass(frozen=True, slots=True)
class Timing:
    """Rounds of one training after the other.

    Attributes:
        pace: `lock-step` or `wall clock`.
        rounds: How many.
        seed: Of the trainings.
    """

    pace: str
    rounds: int
    seed: int

    def run(self) -> list[TimedRound]:
        """Measure them."""
        rows: list[TimedRound] = []
        paced = self.pace == PACED
        watch = Stopwatch()
        with ExitStack() as stack:
            for part, owner, name in _METHODS:
                method = getattr(owner, name)
                stack.enter_context(patch.object(owner, name, watch.timed(method, part)))
            lab = stack.enter_context(
                VirtualLaboratory.from_arena("corridor", 2, paced=paced, real_time=paced)
            )
            env = stack.enter_context(closing(TrainingEnv(noise=Noise.none(), world=lab)))
            late = 0

            def note() -> None:
                nonlocal late
                sheet, watch.sheet = watch.sheet, Sheet()
                if env.infos[TEACHER]["steps"] > 1:  # the first has the operator's work in it
                    times = {part: 1000 * sheet.seconds[part] for part, _, _ in _METHODS}
                    decide = 1000 * sheet.seconds[OUTSIDE]
                    rows.append(
                        TimedRound(
                            self.pace, len(rows), **times, decide=decide, late=lab.clock.overruns > late
                        )
                    )
                late = lab.clock.overruns
                if len(rows) >= self.rounds:
                    raise _Enough

            with suppress(_Enough):
                for seed in np.random.SeedSequence(self.seed).spawn(self.rounds):
                    train(env, seed, callback=note)
        return rows
