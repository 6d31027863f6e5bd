"""A training in the virtual laboratory that records what the learner was shown, what was true, and what failed."""

import time
from collections.abc import Callable
from dataclasses import dataclass, field, fields
from typing import Any

import numpy as np
from numpy.typing import NDArray

from khepera_forage.envs.training import TEACHER, TrainingEnv
from khepera_forage.lab.virtual_laboratory import VirtualLaboratory
from khepera_forage.noise import Noise
from khepera_forage.policies import Teacher
from khepera_forage.policies.policy import HEARD
from khepera_forage.robots.virtual.faults import FaultCounts, Faults
from khepera_forage.robots.virtual.virtual_khepera import VirtualKhepera
from khepera_forage.task.states import Behaviour, StateVector
from lab_comparison.truth import Truth

Vector = tuple[StateVector, Behaviour]
"""An experience vector."""
LEARNER = "learner_0"
_AFTERWARDS = 3
"""Rounds for which the bodies are observed when they should stand still."""


@dataclass(slots=True)
class AttemptRecord:
    """A record of one attempt.

    Attributes:
        rounds: Begun rounds.
        lost: Why the last round ended the attempt: a lost robot or camera; empty if nothing was lost.
        heard: What the learner was shown whenever it heard a behaviour: the experience.
        wrong: Vectors among these that differ from what the learner's body senses, or whose behaviour differs from what
            the teacher would have called on its own body's senses.
        faults: In rounds.
        disturbed: Rounds with a fault.
        recovered: Rounds with a fault in which no robot was lost.
        halted: Rounds in which a body did not turn its wheels as its driver commanded.
        misread: Rounds after which a driver reported other senses than its body's, counters not considered.
        miscounted: Rounds in which a driver's counters changed differently from its body's.
        moving: Robots that still moved after the end of the attempt.
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


class ObservedTraining(TrainingEnv):
    """`TrainingEnv` in a virtual laboratory, with a record of every attempt.

    Args:
        lab: The laboratory, with undisturbed lines.
        faults: Of all lines in every round; there are none while the operator works. None leaves the lines as they
            are.
        callback: Called after every round; an exception from it interrupts the training.

    Attributes:
        records: One an attempt.
    """

    def __init__(
        self, lab: VirtualLaboratory, faults: Faults | None, callback: Callable[[], None] = lambda: None
    ) -> None:
        super().__init__(num_learners=len(lab.markers) - 1, world=lab, noise=Noise.none())
        self.records: list[AttemptRecord] = []
        self._lab, self._wanted, self._callback = lab, faults, callback
        self._ports: list[VirtualKhepera] = []
        self._truth: Truth

    def reset(self, seed: int | None = None, options: dict[str, Any] | None = None) -> None:
        """Start an attempt with a new record; see `TrainingEnv.reset`."""
        self.records.append(AttemptRecord())
        if self._wanted is not None:
            self._disturb(Faults())
        super().reset(seed, options)
        self._truth = Truth(self._lab, self.foragers)
        if self._wanted is not None:
            self._disturb(self._wanted)

    def observe(self, agent: str) -> NDArray[np.int64]:
        """Observe as in any training; what the learner hears is recorded and compared with the truth."""
        observation: NDArray[np.int64] = super().observe(agent)
        if agent == LEARNER and observation[HEARD] != Behaviour.WAIT:
            record = self.records[-1]
            shown, behaviour = StateVector(*observation[:5].tolist()), Behaviour(int(observation[HEARD]))
            record.heard.append((shown, behaviour))
            teacher = super().observe(TEACHER)
            teacher[:5] = self._truth.vector(0)
            called = Teacher.of(self).act(teacher)
            record.wrong += (shown, behaviour) != (self._truth.vector(1), called)
        return observation

    def step(self, action: int | None) -> None:
        """Step as in any training; the last robot's step ends the round, which is recorded."""
        if self.agent_selection != self.possible_agents[-1] or not self.agents:
            super().step(action)
            return
        record, before, began = self.records[-1], self._faults(), time.perf_counter()
        record.rounds += 1
        super().step(action)
        record.seconds.append(time.perf_counter() - began)
        happened = _sum(self._faults(), before, -1)
        record.faults = _sum(record.faults, happened, 1)
        record.disturbed += happened.disturbed > 0
        record.lost = self.infos[TEACHER].get("robot_lost", "")
        if record.lost:
            record.moving = moving(self._lab)
        else:
            record.recovered += happened.disturbed > 0
            failures = self._truth.end_round()
            record.halted += failures.halted
            record.misread += failures.misread
            record.miscounted += failures.miscounted
        self._callback()

    def _disturb(self, faults: Faults) -> None:
        for port in self._lab.virtual_kheperas:
            port.faults = faults

    def _faults(self) -> FaultCounts:
        """Counts of all lines so far; a lost line is replaced by a new one."""
        self._ports += [port for port in self._lab.virtual_kheperas if port not in self._ports]
        total = FaultCounts()
        for port in self._ports:
            total = _sum(total, port.fault_counts, 1)
        return total


def moving(lab: VirtualLaboratory) -> int:
    """Number of bodies that move or turn a wheel while the simulation advances without commands."""
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
