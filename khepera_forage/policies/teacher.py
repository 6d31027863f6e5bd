"""The teacher: a hand-written classifier of state vectors and a rule for every state (section 4.4)."""

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from khepera_forage.policies.policy import SEPARATED, Observation, is_training, state_vector_of
from khepera_forage.task.arena_map import whole_pixels
from khepera_forage.task.decisions import DEFAULT_DECISIONS, Decisions, DecisionValues
from khepera_forage.task.states import Behaviour, behaviour_for, classify


@dataclass(frozen=True, init=False)
class Teacher:
    """Decides by the tree of figure 4.2 and the IF-THEN rules of 4.4.1; never by chance.

    In training it waits, in silence, for a learner that got separated (4.5).

    Args:
        home_radius: Of the home of the arena foraged in, in pixels of 5 mm; above 0. That of the decisions by default.
        decisions: Thresholds of the tree, and whatever else the thesis leaves open.

    Attributes:
        home_radius: See above.
        decisions: See above.

    Raises:
        ValueError: A radius that is not above 0.
    """

    home_radius: int
    decisions: Decisions
    _values: DecisionValues = field(repr=False, compare=False)

    def __init__(self, home_radius: int | None = None, decisions: Decisions = DEFAULT_DECISIONS) -> None:
        if home_radius is None:
            home_radius = whole_pixels(decisions.home_radius)
        if not home_radius > 0:
            raise ValueError(f"home_radius is {home_radius!r} pixels; allowed: above 0")
        # A frozen dataclass allows no plain assignment.
        object.__setattr__(self, "home_radius", home_radius)
        object.__setattr__(self, "decisions", decisions)
        object.__setattr__(self, "_values", decisions.values())

    @classmethod
    def of(cls, env: Any) -> "Teacher":
        """The teacher for an environment: for its home, under its decisions.

        Args:
            env: One of ours, wrapped or not.
        """
        env = env.unwrapped
        return cls(env.home_radius, env.decisions)

    def act(self, observation: Observation, rng: np.random.Generator | None = None) -> Behaviour:
        """The behaviour for the state that the observed state vector stands for; WAIT for a separated learner.

        Args:
            observation: What the robot perceives; see `state_vector_of`. That of the training environment has
                seven integers, the last of which says whether a learner is separated.
            rng: Not used.

        Raises:
            ValueError: The observation holds no state vector.
        """
        if type(observation) is not dict and is_training(observation) and observation[SEPARATED]:
            return Behaviour.WAIT
        return behaviour_for(classify(state_vector_of(observation), self.home_radius, self._values))
