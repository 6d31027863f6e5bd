"""Foragers as the thesis first had them: behaviours that run until their goal is reached, and state labels."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import groupby

import numpy as np

from khepera_forage.experience import Experience
from khepera_forage.policies import Observation, Policy
from khepera_forage.policies.policy import state_vector_of
from khepera_forage.task.states import (
    BEHAVIOURS,
    CARRY_HEIGHT,
    CLOSE_TO_FOOD,
    NEXT_TO_FOOD,
    Behaviour,
    FoodType,
    State,
    StateVector,
    classify,
)

PATIENCE = 100
"""Steps after which a behaviour that has not reached its goal has failed: ten seconds. Our decision (4.2.1)."""


def goal_reached(behaviour: int, vector: StateVector, home_radius: int) -> bool:
    """Whether the local goal of a behaviour is reached (4.2.1): the robot is where the next behaviour begins.

    Args:
        behaviour: A `Behaviour`.
        vector: What is perceived now.
        home_radius: In pixels.
    """
    presence, home, food_type, arm, food = vector
    if behaviour == Behaviour.SEARCH_FOR_FOOD:
        return food <= CLOSE_TO_FOOD
    if behaviour == Behaviour.MOVE_SLOWLY:
        return food <= NEXT_TO_FOOD
    if behaviour == Behaviour.ORIENT_WITH_FOOD:
        return bool(presence)
    if behaviour == Behaviour.EXPLORE_FOOD:
        return food_type != FoodType.UNKNOWN
    if behaviour == Behaviour.PICK_UP_FOOD:
        return bool(presence) and arm <= CARRY_HEIGHT
    if behaviour in (Behaviour.PUSH_FOOD, Behaviour.GO_HOME):
        return home <= home_radius
    if behaviour == Behaviour.AVOID_HOME:
        return home > home_radius
    return not presence  # RELEASE FOOD and AVOID FOOD


@dataclass
class UntilGoal:
    """Perceives, decides, and runs the behaviour until its goal is reached or `PATIENCE` steps have passed.

    It remembers what it is doing: every episode needs one of its own.

    Attributes:
        policy: Who decides what to do next.
        home_radius: In pixels.
    """

    policy: Policy
    home_radius: int
    _running: int | None = field(default=None, init=False)
    _steps: int = field(default=0, init=False)

    def act(self, observation: Observation, rng: np.random.Generator | None = None) -> int:
        """The behaviour that runs, or the next one."""
        vector = state_vector_of(observation)
        running = self._running
        if running is None or self._steps >= PATIENCE or goal_reached(running, vector, self.home_radius):
            running = self._running = self.policy.act(observation, rng)
            self._steps = 0
        self._steps += 1
        return running


def beginnings(experience: Experience) -> Experience:
    """The one perceptual experience for every behaviour that 4.2.1 speaks of: where the teacher began it."""
    first = [next(run) for _, run in groupby(experience, key=lambda pair: pair[1])]
    return Experience([vector for vector, _ in first], [heard for _, heard in first], arena=experience.arena)


@dataclass(frozen=True, slots=True)
class StateLabels:
    """The learner of the first draft (4.5.1): it can classify states, and learns which behaviour goes with which.

    Attributes:
        home_radius: Of the arena foraged in, in pixels.
        shouted: How often each behaviour was shouted with each state.
    """

    home_radius: int
    shouted: Mapping[State, Mapping[Behaviour, int]]

    @classmethod
    def heard(cls, files: Sequence[Experience], home_radius: int) -> "StateLabels":
        """From what the teacher shouted: state and behaviour, which stand one to one (4.4.1)."""
        shouted: dict[State, dict[Behaviour, int]] = {}
        for experience in files:
            for behaviour in experience.behaviours:
                counts = shouted.setdefault(State(int(behaviour)), {})
                counts[behaviour] = counts.get(behaviour, 0) + 1
        return cls(home_radius, shouted)

    def act(self, observation: Observation, rng: np.random.Generator | None = None) -> Behaviour:
        """A behaviour heard with the present state, drawn with its share; any, if none was ever heard.

        Raises:
            TypeError: `rng` is not a NumPy generator.
        """
        if not isinstance(rng, np.random.Generator):
            raise TypeError(f"rng is {rng!r}; allowed: a numpy.random.Generator, to draw behaviours from")
        state = classify(state_vector_of(observation), self.home_radius)
        counts = self.shouted.get(state)
        if counts is None:
            return BEHAVIOURS[int(rng.integers(len(BEHAVIOURS) - 1))]
        left = rng.random() * sum(counts.values())
        for behaviour, count in counts.items():  # noqa: B007 - the last one looked at is the one drawn
            left -= count
            if left < 0:
                break
        return behaviour
