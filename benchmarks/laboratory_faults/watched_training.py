"""A training that records each attempt and calls the campaign after every round."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from lab_comparison.observed_training import LEARNER, ObservedTraining, Vector
from numpy.typing import NDArray

from khepera_forage.envs.training import TEACHER
from khepera_forage.lab.virtual_laboratory import VirtualLaboratory
from khepera_forage.policies.policy import HEARD
from khepera_forage.task.states import Behaviour

MAX_ROUNDS = 200
"""Rounds after which an attempt is out of time: most complete ones are shorter."""
OUTDATED = 15.0
"""mm between the pose that the camera has reported and the true one. A robot drives 8 mm in a round."""


@dataclass(slots=True)
class WatchedAttempt:
    """One attempt.

    Attributes:
        seed: Of the attempt.
        perceived: The learner's state vectors with the behaviours that it heard.
        wrong: For each of them, whether it is wrong.
        outdated: For each of them, whether teacher or learner were elsewhere.
        rounds: Begun rounds.
        lost: What was lost; empty if nothing was.
        complete: Whether it was complete.
        discarded: Whether it ended incomplete, with nothing lost (5.2).
    """

    seed: int
    perceived: list[Vector]
    wrong: list[bool]
    outdated: list[bool]
    rounds: int = 0
    lost: str = ""
    complete: bool = False
    discarded: bool = False


class WatchedTraining(ObservedTraining):
    """`TrainingEnv` in a virtual laboratory, with a record of every attempt.

    Args:
        lab: The laboratory.
        attempts: Receives the record of every attempt at its beginning.
        on_round: Called after every round.
    """

    def __init__(
        self,
        lab: VirtualLaboratory,
        attempts: list[WatchedAttempt],
        on_round: Callable[["WatchedTraining"], None],
    ) -> None:
        super().__init__(lab, None, lambda: self._end_round(on_round))
        self.max_cycles = MAX_ROUNDS
        self.lab = lab
        self.attempts = attempts

    def reset(self, seed: int | None = None, options: dict[str, Any] | None = None) -> None:
        """Start an attempt with a new record; see `TrainingEnv.reset`."""
        assert seed is not None
        self.attempts.append(WatchedAttempt(seed, [], [], []))
        super().reset(seed, options)

    def observe(self, agent: str) -> NDArray[np.int64]:
        """Observe as in any training; what the learner hears is recorded."""
        wrong = self.records[-1].wrong
        observation = super().observe(agent)
        if agent == LEARNER and observation[HEARD] != Behaviour.WAIT:
            attempt = self.attempts[-1]
            attempt.perceived.append(self.records[-1].heard[-1])
            attempt.wrong.append(self.records[-1].wrong > wrong)
            pairs = zip(self.lab.poses()[:2], self.lab.simulation.poses()[:2], strict=True)
            attempt.outdated.append(any(math.dist(seen[:2], true[:2]) > OUTDATED for seen, true in pairs))
        return observation

    def _end_round(self, on_round: Callable[["WatchedTraining"], None]) -> None:
        attempt = self.attempts[-1]
        attempt.rounds += 1
        attempt.lost = self.infos[TEACHER].get("robot_lost", "")
        attempt.complete = self.terminations[TEACHER]
        attempt.discarded = self.truncations[TEACHER] and not attempt.lost
        on_round(self)
