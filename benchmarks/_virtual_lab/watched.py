"""A training in the virtual laboratory under observation: what was shown, what was true, what went wrong."""

import time
from collections.abc import Callable
from dataclasses import dataclass, field, fields
from typing import Any

import numpy as np
from numpy.typing import NDArray

from _virtual_lab.truth import Truth
from khepera_forage.envs.training import TEACHER, TrainingEnv
from khepera_forage.lab.virtual_laboratory import VirtualLaboratory
from khepera_forage.noise import Noise
from khepera_forage.policies import Teacher
from khepera_forage.policies.policy import HEARD
from khepera_forage.robots.virtual.faults import FaultCounts, Faults
from khepera_forage.robots.virtual.virtual_khepera import VirtualKhepera
from khepera_forage.task.states import Behaviour, StateVector

Vector = tuple[StateVector, Behaviour]
"""An experience vector."""
LEARNER = "learner_0"
_AFTERWARDS = 3
"""Rounds for which the bodies are watched once they should stand."""


@dataclass(slots=True)
class Notes:
    """What came of an attempt.

    Attributes:
        rounds: That were begun.
        lost: Why its last round is its last: a robot, or the camera; otherwise empty.
        heard: What the learner was shown whenever it heard a behaviour: the experience.
        wrong: Of these, those whose state vector is not that of its body, or whose behaviour the teacher would not have
            called, had it sensed what its own body does.
        faults: In rounds.
        disturbed: Rounds with a fault.
        recovered: Rounds with a fault in which nobody was lost.
        halted: Rounds in which a body did not turn its wheels as its driver had it.
        misread: Rounds after which a driver reported other senses, counters apart, than its body's.
        miscounted: Rounds in which a driver's counters went on otherwise than its body's.
        moving: Robots that moved on after the attempt should have stopped them.
        seconds: Of each round.
    """

    rounds: int = 0
    lost: str = ""
    heard: list[Vector] = field(default_factory=list)
    wrong: int = 0
    faults: FaultCounts = field(default_factory=FaultCounts)
    disturbed: int = 0
    recovered: int = 0
    halted: int = 0
    misread: int = 0
    miscounted: int = 0
    moving: int = 0
    seconds: list[float] = field(default_factory=list)


class WatchedTraining(TrainingEnv):
    """`TrainingEnv` in a virtual laboratory, with notes.

    Args:
        lab: Where it takes place, on undisturbed lines.
        faults: Of all lines in every round; while the operator is at work there are none.
        end: Called after every round; what it raises ends the training there, in the midst of it.

    Attributes:
        notes: One an attempt.
    """

    def __init__(
        self, lab: VirtualLaboratory, faults: Faults, end: Callable[[], None] = lambda: None
    ) -> None:
        super().__init__(num_learners=len(lab.markers) - 1, world=lab, noise=Noise.none())
        self.notes: list[Notes] = []
        self._lab, self._wanted, self._end = lab, faults, end
        self._ports: list[VirtualKhepera] = []
        self._truth: Truth

    def reset(self, seed: int | None = None, options: dict[str, Any] | None = None) -> None:
        """As in any training, on a new page of notes."""
        self.notes.append(Notes())
        self._disturb(Faults())
        super().reset(seed, options)
        self._truth = Truth(self._lab, self.foragers)
        self._disturb(self._wanted)

    def observe(self, agent: str) -> NDArray[np.int64]:
        """As in any training; what the learner hears is noted, and whether all of it is true."""
        observation = super().observe(agent)
        if agent == LEARNER and observation[HEARD] != Behaviour.WAIT:
            note = self.notes[-1]
            shown, word = StateVector(*observation[:5].tolist()), Behaviour(int(observation[HEARD]))
            note.heard.append((shown, word))
            teacher = super().observe(TEACHER)
            teacher[:5] = self._truth.vector(0)
            called = Teacher(self.home_radius).act(teacher)
            note.wrong += (shown, word) != (self._truth.vector(1), called)
        return observation

    def step(self, action: int | None) -> None:
        """As in any training; a round is noted when the last robot's step ends it."""
        if self.agent_selection != self.possible_agents[-1] or not self.agents:
            super().step(action)
            return
        note, before, began = self.notes[-1], self._faults(), time.perf_counter()
        note.rounds += 1
        super().step(action)
        note.seconds.append(time.perf_counter() - began)
        happened = _sum(self._faults(), before, -1)
        note.faults = _sum(note.faults, happened, 1)
        note.disturbed += happened.disturbed > 0
        note.lost = self.infos[TEACHER].get("robot_lost", "")
        if note.lost:
            note.moving = moving(self._lab)
        else:
            note.recovered += happened.disturbed > 0
            went = self._truth.take_in()
            note.halted += went.halted
            note.misread += went.misread
            note.miscounted += went.miscounted
        self._end()

    def _disturb(self, faults: Faults) -> None:
        for port in self._lab.virtual_kheperas:
            port.faults = faults

    def _faults(self) -> FaultCounts:
        """On all lines there have been: one that was lost is replaced by another."""
        self._ports += [port for port in self._lab.virtual_kheperas if port not in self._ports]
        total = FaultCounts()
        for port in self._ports:
            total = _sum(total, port.fault_counts, 1)
        return total


def moving(lab: VirtualLaboratory) -> int:
    """How many bodies still move, or turn a wheel, when time goes on and nobody commands anything."""
    before = [(body.pose, body.sense()) for body in lab.simulation.robots]
    for _ in range(_AFTERWARDS):
        lab.simulation.advance()
    return sum(
        body.pose != pose
        or (body.sense().left_pulses, body.sense().right_pulses) != (senses.left_pulses, senses.right_pulses)
        for body, (pose, senses) in zip(lab.simulation.robots, before, strict=True)
    )


def _sum(one: FaultCounts, other: FaultCounts, sign: int) -> FaultCounts:
    names = [count.name for count in fields(FaultCounts)]
    return FaultCounts(**{name: getattr(one, name) + sign * getattr(other, name) for name in names})
