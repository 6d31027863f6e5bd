"""One attempt at a training episode, round by round: what `TrainingEnv` wraps in PettingZoo's form (4.5, 5.3)."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from khepera_forage.envs.forager import Forager
from khepera_forage.robots.khepera import Motors
from khepera_forage.sim.world import World
from khepera_forage.task.pairing import Company
from khepera_forage.task.scoring import score
from khepera_forage.task.states import CARRY_HEIGHT, Behaviour, FoodType

MAX_ATTEMPTS = 200
"""Attempts after which a training episode counts as hopeless. Our decision."""


class Demonstration:
    """Robots side by side in copies of one arena, the teacher first, and the account of what they do.

    Args:
        world: Already reset.
        foragers: Each in its own copy of the arena; they perceive the world's first frame here.

    Attributes:
        foragers: As given.
        company: Who is beside whom.
        actions: What each robot decided on last; WAIT before its first decision.
        steps: Rounds that are over.
    """

    def __init__(self, world: World, foragers: Sequence[Forager]) -> None:
        self._world = world
        self.foragers = list(foragers)
        scene = world.camera.look()
        for forager in self.foragers:
            forager.perceive(scene)
        self.company = Company(self.foragers)
        self.actions = [int(Behaviour.WAIT)] * len(self.foragers)
        self.steps = 0
        self._correct = [0] * len(self.foragers)

    @property
    def complete(self) -> bool:
        """Whether every robot has done its part (5.3)."""
        return all(map(_is_done, self.foragers))

    def observe(self, i: int) -> NDArray[np.int64]:
        """What a robot perceives: its state vector, what it hears, whether it is separated; a fresh array."""
        presence, home, food_type, arm, food = self.foragers[i].vector
        diagonal = self.foragers[i].site.diagonal
        heard = self.actions[0] if i else Behaviour.WAIT
        apart = self.company.apart[i] if i else any(self.company.apart)
        return np.array(
            (presence, min(home, diagonal), food_type, arm, min(food, diagonal), heard, apart), np.int64
        )

    def round(self) -> list[int]:
        """Everybody's commands take effect together.

        Returns:
            Food that each robot has delivered in this round, less the poison it has brought home.
        """
        before = [_worth(forager) for forager in self.foragers]
        self.steps += 1
        for i, forager in enumerate(self.foragers):
            self._correct[i] += self.actions[i] == forager.state
            forager.drive(self._motors_of(i, forager))
        self._world.advance()
        scene = self._world.camera.look()
        for forager in self.foragers:
            forager.perceive(scene)
        self.company.update()
        return [_worth(forager) - old for forager, old in zip(self.foragers, before, strict=True)]

    def info(self, i: int, complete: bool = False) -> dict[str, Any]:
        """How a robot is getting on, in plain numbers."""
        forager = self.foragers[i]
        register, raw, state = forager.register, forager.raw, int(forager.state)
        delivered = register.delivered_food
        return {
            "state": state,
            "correct_behaviour": state,
            "x": raw.x,
            "y": raw.y,
            "orientation": raw.orientation,
            "score": score(self._correct[i], self.steps, delivered, register.deliverable),
            "correct": self._correct[i],
            "steps": self.steps,
            "delivered": delivered,
            "poison_home": register.poison_home,
            "complete": int(complete),
            "separated_rounds": self.company.rounds[i],
            "separations": self.company.separations[i],
        }

    def _motors_of(self, i: int, forager: Forager) -> Motors:
        motors = forager.motors_for(self.actions[i])
        return motors if i == 0 else self.company.lead(i, motors, silent=self.actions[i] == Behaviour.WAIT)


def _worth(forager: Forager) -> int:
    return forager.register.delivered_food - forager.register.poison_home


def _is_done(forager: Forager) -> bool:
    """Whether a robot has done its part of a training episode (5.3)."""
    register, vector = forager.register, forager.vector
    if FoodType.POISONOUS in register.known and (vector.object_presence or vector.arms_height > CARRY_HEIGHT):
        return False  # Poison is avoided, not just known: otherwise nobody would ever be shown how.
    return register.finished and vector.robot_home_distance > forager.site.home_radius
