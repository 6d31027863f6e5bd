"""Policies that the thesis rejected: behaviours that run until their goal is reached, and state labels."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import groupby

import numpy as np

from khepera_forage.experience import Experience
from khepera_forage.policies import Observation, Policy
from khepera_forage.policies.policy import state_vector_of
from khepera_forage.task.decisions import Decisions
from khepera_forage.task.states import (
    BEHAVIOURS,
    Behaviour,
    FoodType,
    State,
    StateVector,
    classify,
    is_raised,
)

DECISIONS = Decisions().values()
PATIENCE = 100
"""Steps after which a behaviour without success ends: ten seconds. Our decision (4.2.1)."""


def goal_reached(behaviour: int, vector: StateVector, home_radius: int) -> bool:
    """Whether the local goal of a behaviour is reached (4.2.1): the robot is where the next behaviour begins.

    Args:
        behaviour: A `Behaviour`.
        vector: The present state vector.
        home_radius: In pixels.
    """
    presence, home, food_type, arm, food = vector
    if behaviour == Behaviour.SEARCH_FOR_FOOD:
        return bool(food <= DECISIONS.close_to_food)
    if behaviour == Behaviour.MOVE_SLOWLY:
        return bool(food <= DECISIONS.next_to_food)
    if behaviour == Behaviour.ORIENT_WITH_FOOD:
        return bool(presence)
    if behaviour == Behaviour.EXPLORE_FOOD:
        return food_type != FoodType.UNKNOWN
    if behaviour == Behaviour.PICK_UP_FOOD:
        return bool(presence) and is_raised(arm, DECISIONS)
    if behaviour in (Behaviour.PUSH_FOOD, Behaviour.GO_HOME):
        return home <= home_radius
    if behaviour == Behaviour.AVOID_HOME:
        return home > home_radius
    return not presence  # RELEASE FOOD and AVOID FOOD


@dataclass
class UntilGoal:
    """A policy whose behaviours run until their goal is reached or `PATIENCE` steps have passed.

    It remembers the running behaviour, so every episode needs a new copy.

    Attributes:
        policy: Decides on the next behaviour.
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


def first_vectors(experience: Experience) -> Experience:
    """The first vector of every behaviour that the teacher began: the one perceptual experience of 4.2.1."""
    first = [next(run) for _, run in groupby(experience, key=lambda pair: pair[1])]
    return Experience([vector for vector, _ in first], [heard for _, heard in first], arena=experience.arena)


@dataclass(frozen=True, slots=True)
class StateLabels:
    """The learner of the first draft (4.5.1): it classifies states, and learns which behaviour belongs to which.

    Attributes:
        home_radius: Of the arena it forages in, in pixels.
        counts: How often each behaviour was heard in each state.
    """

    home_radius: int
    counts: Mapping[State, Mapping[Behaviour, int]]

    @classmethod
    def heard(cls, files: Sequence[Experience], home_radius: int) -> "StateLabels":
        """The learner of these files: behaviours tell the states, as the two correspond one to one (4.4.1)."""
        heard: dict[State, dict[Behaviour, int]] = {}
        for experience in files:
            for behaviour in experience.behaviours:
                counts = heard.setdefault(State(int(behaviour)), {})
                counts[behaviour] = counts.get(behaviour, 0) + 1
        return cls(home_radius, heard)

    def act(self, observation: Observation, rng: np.random.Generator | None = None) -> Behaviour:
        """A behaviour heard in the present state, drawn with its share; any behaviour if none was heard.

        Raises:
            TypeError: `rng` is not a NumPy generator.
        """
        if not isinstance(rng, np.random.Generator):
            raise TypeError(f"rng is {rng!r}; allowed: a numpy.random.Generator, to draw behaviours from")
        state = classify(state_vector_of(observation), self.home_radius, DECISIONS)
        counts = self.counts.get(state)
        if counts is None:
            return BEHAVIOURS[int(rng.integers(len(BEHAVIOURS) - 1))]
        behaviours = list(counts)
        shares = np.cumsum(list(counts.values()))
        return behaviours[int(np.searchsorted(shares, rng.random() * shares[-1], side="right"))]
