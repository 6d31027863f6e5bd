"""A training in the virtual laboratory that records what the learner was shown, what was true, and what failed.

Every robot has a second perception on the same camera scene, with senses from the simulated body instead of the line.
"""

import math
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from khepera_forage.envs.arguments import food_odds
from khepera_forage.envs.forager import Forager, arena_map_of, perceive_all
from khepera_forage.envs.layouts import tracker_of
from khepera_forage.envs.training import TEACHER, TrainingEnv
from khepera_forage.lab.virtual_laboratory import VirtualLaboratory
from khepera_forage.noise import Noise
from khepera_forage.policies import Teacher
from khepera_forage.policies.policy import HEARD
from khepera_forage.robots.khepera import Motors, Senses, applicable
from khepera_forage.robots.virtual.faults import Faults
from khepera_forage.robots.virtual.virtual_khepera import VirtualKhepera
from khepera_forage.sim.simulation import SimulatedKhepera
from khepera_forage.task.placement import draw_food_types
from khepera_forage.task.states import Behaviour, StateVector

Vector = tuple[StateVector, Behaviour]
"""An experience vector."""
LEARNER = "learner_0"
_OUTDATED = 15.0
"""mm between the pose that the camera has reported and the true one. A robot drives 8 mm in a round."""
_SETTLING = 0.5
"""mm by which a standing robot that touches a wall or food may be pushed back by it."""
_AFTERWARDS = 3
"""Rounds for which bodies are observed that should stand still."""


@dataclass(slots=True)
class Attempt:
    """A record of one attempt.

    Attributes:
        seed: Of the attempt.
        perceived: What the learner was shown whenever it heard a behaviour: the experience.
        wrong: For each of these vectors, whether it differs from what the learner's body senses, or its behaviour from
            what the teacher would have called on its own body's senses.
        outdated: For each of them, whether teacher or learner were elsewhere than the camera reported.
        rounds: Begun rounds.
        lost: Why the last round ended the attempt: a lost robot or camera; empty if nothing was lost.
        complete: Whether it was complete.
        faults: Faulty replies in rounds.
        unseen: Garbled replies among these that read as other valid ones.
        disturbed: Rounds with a fault.
        misread: Rounds after which a driver reported other senses than its body's, counters not considered.
        miscounted: Rounds in which a driver's counters changed differently from its body's.
        moving: Robots that still moved after a loss.
        seconds: Of all rounds.
    """

    seed: int | None
    perceived: list[Vector] = field(default_factory=list)
    wrong: list[bool] = field(default_factory=list)
    outdated: list[bool] = field(default_factory=list)
    rounds: int = 0
    lost: str = ""
    complete: bool = False
    discarded: bool = False
    """Whether it ended incomplete, with nothing lost (5.2)."""
    faults: int = 0
    unseen: int = 0
    disturbed: int = 0
    misread: int = 0
    miscounted: int = 0
    moving: int = 0
    seconds: float = 0.0


class ObservedTraining(TrainingEnv):
    """`TrainingEnv` in a virtual laboratory, with a record of every attempt.

    Args:
        lab: The laboratory.
        on_round: Called after every round; an exception from it interrupts the training.
        faults: Of all lines in every round, but not while the operator works. None leaves the lines as they are.
        attempts: Receives the record of every attempt at its beginning.
    """

    def __init__(
        self,
        lab: VirtualLaboratory,
        on_round: Callable[["ObservedTraining"], None] = lambda _: None,
        faults: Faults | None = None,
        attempts: list[Attempt] | None = None,
    ) -> None:
        super().__init__(num_learners=len(lab.markers) - 1, world=lab, noise=Noise.none())
        self.attempts: list[Attempt] = [] if attempts is None else attempts
        self._lab, self._wanted, self._on_round = lab, faults, on_round
        self._ports: list[VirtualKhepera] = []
        self._truth: Truth

    def reset(self, seed: int | None = None, options: dict[str, Any] | None = None) -> None:
        """Start an attempt with a new record; see `TrainingEnv.reset`."""
        self.attempts.append(Attempt(seed))
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
            attempt = self.attempts[-1]
            shown, behaviour = StateVector(*observation[:5].tolist()), Behaviour(int(observation[HEARD]))
            attempt.perceived.append((shown, behaviour))
            teacher = super().observe(TEACHER)
            teacher[:5] = self._truth.vector(0)
            called = Teacher.of(self).act(teacher)
            attempt.wrong.append((shown, behaviour) != (self._truth.vector(1), called))
            pairs = zip(self._lab.poses()[:2], self._lab.simulation.poses()[:2], strict=True)
            attempt.outdated.append(any(math.dist(seen[:2], true[:2]) > _OUTDATED for seen, true in pairs))
        return observation

    def step(self, action: int | None) -> None:
        """Step as in any training; the last robot's step ends the round, which is recorded."""
        if self.agent_selection != self.possible_agents[-1] or not self.agents:
            super().step(action)
            return
        attempt, (faults, unseen), began = self.attempts[-1], self._counts(), time.perf_counter()
        attempt.rounds += 1
        super().step(action)
        attempt.seconds += time.perf_counter() - began
        faults_now, unseen_now = self._counts()
        attempt.faults += faults_now - faults
        attempt.unseen += unseen_now - unseen
        attempt.disturbed += faults_now > faults
        attempt.lost = self.infos[TEACHER].get("robot_lost", "")
        attempt.complete = self.terminations[TEACHER]
        attempt.discarded = self.truncations[TEACHER] and not attempt.lost
        if attempt.lost:
            attempt.moving = len(moving(self._lab))
        else:
            misread, miscounted = self._truth.end_round()
            attempt.misread += misread
            attempt.miscounted += miscounted
        self._on_round(self)

    def _disturb(self, faults: Faults) -> None:
        for port in self._lab.virtual_kheperas:
            port.faults = faults

    def _counts(self) -> tuple[int, int]:
        """Faults and undetectable ones of all lines so far; a lost line is replaced by a new one."""
        self._ports += [port for port in self._lab.virtual_kheperas if port not in self._ports]
        counts = [port.fault_counts for port in self._ports]
        return sum(count.disturbed for count in counts), sum(count.undetectable for count in counts)


class _Body:
    """A simulated body that is sensed here and driven by its driver, over the line."""

    has_gripper = True

    def __init__(self, body: SimulatedKhepera) -> None:
        self._body = body

    def sense(self) -> Senses:
        return self._body.sense()

    def drive(self, motors: Motors) -> Motors:
        return applicable(motors)

    def stop(self) -> None: ...

    def close(self) -> None: ...


class Truth:
    """True perception of all robots from the beginning of an episode; the food has the default type.

    Args:
        lab: The laboratory with the bodies.
        foragers: Those of the episode, at its beginning.
    """

    def __init__(self, lab: VirtualLaboratory, foragers: Sequence[Forager]) -> None:
        self._lab = lab
        self._reported = foragers
        self._foragers: list[Forager] = []
        for body, arena, reported in zip(lab.simulation.robots, lab.arenas, foragers, strict=True):
            arena_map = arena_map_of(arena)
            tracker = tracker_of(arena.foods, arena_map)
            draw_food_types(tracker.foods, 0, food_odds(None))
            self._foragers.append(
                Forager(_Body(body), arena_map, reported.holes, tracker, reported.decisions)
            )
        perceive_all(self._foragers, lab.camera.look())
        self._before = self._senses()

    def end_round(self) -> tuple[bool, bool]:
        """Perceive at the end of a round.

        Returns:
            Whether a driver reported a proximity, object presence, arm or jaw that was not its body's; and whether it
            reported a wrong turn of the wheels in this round.
        """
        for reported, true in zip(self._reported, self._foragers, strict=True):
            true.applied = reported.applied
        perceive_all(self._foragers, self._lab.camera.look())
        before, self._before = self._before, self._senses()
        misread = any(_rest(reported) != _rest(true) for reported, true in self._before)
        turned = [
            [_turned(*pair) for pair in zip(*robot, strict=True)]
            for robot in zip(before, self._before, strict=True)
        ]
        return misread, any(reported != true for reported, true in turned)

    def vector(self, robot: int) -> StateVector:
        """The true state vector, as an environment shows it."""
        forager = self._foragers[robot]
        presence, home, food_type, arm, food = forager.vector
        diagonal = forager.arena.diagonal
        return StateVector(presence, min(home, diagonal), food_type, arm, min(food, diagonal))

    def _senses(self) -> list[tuple[Senses, Senses]]:
        """Reported and true senses of all robots."""
        pairs = zip(self._reported, self._foragers, strict=True)
        return [(reported.senses, true.senses) for reported, true in pairs]


def _turned(before: Senses, after: Senses) -> tuple[int, int]:
    """Pulses of both wheels in a round."""
    return after.left_pulses - before.left_pulses, after.right_pulses - before.right_pulses


def _rest(senses: Senses) -> Senses:
    """All but the counters, whose start values differ."""
    return senses._replace(left_pulses=0, right_pulses=0)


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
