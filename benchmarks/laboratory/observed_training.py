"""A training in the virtual laboratory that records what the learner was shown, and whether it was true.

Every robot has a second perception on the same camera scene, with senses from the simulated body instead of the line.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from khepera_forage.envs.arguments import food_odds
from khepera_forage.envs.forager import Forager, perceive_all
from khepera_forage.envs.layouts import arena_map_of, known_food
from khepera_forage.envs.training import TEACHER, TrainingEnv
from khepera_forage.lab.virtual_laboratory import VirtualLaboratory
from khepera_forage.noise import Noise
from khepera_forage.policies import Teacher
from khepera_forage.policies.policy import HEARD
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
class ObservedAttempt:
    """A record of one attempt.

    Attributes:
        seed: Of the attempt.
        perceived: What the learner was shown whenever it heard a behaviour: the experience.
        wrong: For each of these vectors, whether it differs from what the learner's body senses, or its behaviour from
            what the teacher would have called on its own body's senses.
        outdated: For each of them, whether teacher or learner were elsewhere than the camera reported.
        lost: What was lost in the last round; empty if nothing was.
        complete: Whether it was complete.
        discarded: Whether it ended incomplete, with nothing lost (5.2).
    """

    seed: int | None
    perceived: list[Vector] = field(default_factory=list)
    wrong: list[bool] = field(default_factory=list)
    outdated: list[bool] = field(default_factory=list)
    lost: str = ""
    complete: bool = False
    discarded: bool = False


class ObservedTraining(TrainingEnv):
    """`TrainingEnv` in a virtual laboratory, with a record of every attempt.

    Args:
        lab: The laboratory.
        attempts: Receives the record of every attempt at its beginning.
        on_round: Called after every round.
    """

    def __init__(
        self,
        lab: VirtualLaboratory,
        attempts: list[ObservedAttempt],
        on_round: Callable[["ObservedTraining"], None] = lambda _: None,
    ) -> None:
        super().__init__(num_learners=len(lab.markers) - 1, world=lab, noise=Noise.none())
        self.attempts = attempts
        self._lab, self._on_round = lab, on_round
        self._true: list[Forager] = []

    def reset(self, seed: int | None = None, options: dict[str, Any] | None = None) -> None:
        """Start an attempt with a new record; see `TrainingEnv.reset`."""
        self.attempts.append(ObservedAttempt(seed))
        super().reset(seed, options)
        self._true = []
        for body, arena, told in zip(self._lab.simulation.robots, self._lab.arenas, self.foragers, strict=True):
            arena_map = arena_map_of(arena)
            food = known_food(arena.foods)
            draw_food_types(food.objects, 0, food_odds(None))
            self._true.append(Forager(body, arena_map, told.holes, food, told.decisions))
        perceive_all(self._true, self._lab.camera.look())

    def observe(self, agent: str) -> NDArray[np.int64]:
        """Observe as in any training; what the learner hears is recorded and compared with the truth."""
        observation: NDArray[np.int64] = super().observe(agent)
        if agent == LEARNER and observation[HEARD] != Behaviour.WAIT:
            attempt = self.attempts[-1]
            shown, behaviour = StateVector(*observation[:5].tolist()), Behaviour(int(observation[HEARD]))
            attempt.perceived.append((shown, behaviour))
            teacher = super().observe(TEACHER)
            teacher[:5] = self._true[0].vector
            called = Teacher.of(self).act(teacher)
            attempt.wrong.append((shown, behaviour) != (self._true[1].vector, called))
            pairs = zip(self._lab.poses()[:2], self._lab.simulation.poses()[:2], strict=True)
            attempt.outdated.append(any(math.dist(seen[:2], true[:2]) > _OUTDATED for seen, true in pairs))
        return observation

    def step(self, action: int | None) -> None:
        """Step as in any training; the last robot's step ends the round, which is recorded."""
        ends_round = self.agent_selection == self.possible_agents[-1] and bool(self.agents)
        super().step(action)
        if not ends_round:
            return
        attempt = self.attempts[-1]
        attempt.lost = self.infos[TEACHER].get("robot_lost", "")
        attempt.complete = self.terminations[TEACHER]
        attempt.discarded = self.truncations[TEACHER] and not attempt.lost
        if not attempt.lost:
            for told, true in zip(self.foragers, self._true, strict=True):
                true.applied = told.applied
            perceive_all(self._true, self._lab.camera.look())
        self._on_round(self)


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
