"""The teacher: a hand-written classifier of state vectors and a rule for every state (section 4.4)."""

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from khepera_forage.policies.policy import SEPARATED, Observation, is_training, state_vector_of
from khepera_forage.task.decisions import Decisions, DecisionValues
from khepera_forage.task.states import Behaviour, behaviour_for, classify


@dataclass(frozen=True)
class Teacher:
    """Decides by the tree of figure 4.2 and the IF-THEN rules of 4.4.1; never by chance.

    In training it waits, in silence, for a learner that got separated (4.5).

    Attributes:
        home_radius: Of the home of the arena foraged in, in pixels of 5 mm; above 0.
        decisions: Thresholds of the tree, and whatever else the thesis leaves open.

    Raises:
        ValueError: A radius that is not above 0.
    """

    home_radius: int = 20
    decisions: Decisions = field(default_factory=Decisions)
    _values: DecisionValues = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        if not self.home_radius > 0:
            raise ValueError(f"home_radius is {self.home_radius!r} pixels; allowed: above 0")
        object.__setattr__(self, "_values", self.decisions.values())

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
