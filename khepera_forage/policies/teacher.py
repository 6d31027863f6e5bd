"""The teacher: a hand-written classifier of state vectors and a rule for every state (section 4.4)."""

from dataclasses import dataclass
from functools import cached_property
from itertools import product
from typing import Any

import numpy as np
from numpy.typing import NDArray

from khepera_forage.policies.policy import SEPARATED, Observation, is_training, state_vector_of
from khepera_forage.robots.khepera import ARM_DOWN, ARM_RAISED
from khepera_forage.task.arena_map import whole_pixels
from khepera_forage.task.decisions import DEFAULT_DECISIONS, Decisions, DecisionValues
from khepera_forage.task.states import NUM_BEHAVIOURS, Behaviour, FoodType, StateVector, behaviour_for, classify


@dataclass(frozen=True)
class Teacher:
    """Decides by the tree of figure 4.2 and the IF-THEN rules of 4.4.1; never by chance.

    In training it waits, in silence, for a learner that got separated (4.5).

    What it decides depends on its environment. `Teacher.of(env)` is the teacher of an environment; `recall`, `train`
    and `dagger` take what is not given from theirs.

    Args:
        home_radius: Of the home of the arena foraged in, in pixels of 5 mm; above 0. That of the decisions by default.
        decisions: Thresholds of the tree, and whatever else the thesis leaves open; by default `Decisions()`.

    Raises:
        ValueError: A radius that is not above 0.
    """

    home_radius: int | None = None
    decisions: Decisions | None = None

    def __post_init__(self) -> None:
        if self.home_radius is not None and not self.home_radius > 0:
            raise ValueError(f"home_radius is {self.home_radius!r} pixels; allowed: above 0")

    @classmethod
    def of(cls, env: Any) -> "Teacher":
        """The teacher of an environment: for its home, under its decisions.

        Args:
            env: One of ours, wrapped or not. If it has several arenas, for that of the present episode.

        Raises:
            TypeError: Another environment, or a batch.
        """
        own = getattr(env, "unwrapped", env)
        if not hasattr(own, "home_radius"):
            raise TypeError(f"env is {env!r}; allowed: one environment of this package, not a batch")
        return cls(own.home_radius, own.decisions)

    def act(self, observation: Observation, rng: np.random.Generator | None = None) -> Behaviour:
        """The behaviour for the state that the observed state vector stands for; WAIT for a separated learner.

        Raises:
            ValueError: As `Policy.act`; or neither home radius nor decisions were given.
        """
        if type(observation) is not dict and is_training(observation) and observation[SEPARATED]:
            return Behaviour.WAIT
        return behaviour_for(classify(state_vector_of(observation), *self._known))

    @cached_property
    def _known(self) -> tuple[int, DecisionValues]:
        if self.home_radius is None and self.decisions is None:
            raise ValueError(
                "Teacher() knows no environment; allowed: Teacher.of(env), Teacher(home_radius, decisions)"
            )
        used = self.decisions or DEFAULT_DECISIONS
        return self.home_radius or whole_pixels(used.home_radius), used.values()


def _applicable() -> NDArray[np.bool_]:
    """Which behaviours the tree of figure 4.2 can choose, by object presence and food type."""
    decisions = DEFAULT_DECISIONS.values()
    found = np.zeros((2, len(FoodType), NUM_BEHAVIOURS), np.bool_)
    foods = (0, round(decisions.close_to_food) - 1, 999)
    for presence, home, food_type, arm, food in product((0, 1), (0, 999), FoodType, (ARM_RAISED, ARM_DOWN), foods):
        vector = StateVector(presence, home, food_type, arm, food)
        found[presence, food_type, classify(vector, 1.0, decisions)] = True
    return found


APPLICABLE = _applicable()
"""By object presence, food type and behaviour: whether the tree can choose it, whatever distances and arm are."""
