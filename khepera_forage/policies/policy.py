"""The Policy contract, and from what an environment shows to the state vector of section 4.3."""

from collections.abc import Mapping, Sequence
from operator import index
from typing import Any, Protocol, TypeAlias, TypeGuard

import numpy as np
from numpy.typing import NDArray

from khepera_forage.task.states import StateVector

Observation: TypeAlias = Mapping[str, Any] | Sequence[Any] | NDArray[Any]
"""What the recall environments show (a mapping) or the training environment (seven integers in a row)."""


HEARD, SEPARATED = 5, 6
"""Where an observation of the training environment has what is heard, and whether robots are separated."""


def is_training(observation: Observation) -> TypeGuard[Sequence[Any] | NDArray[Any]]:
    """Whether an observation is one of the training environment: a row that goes on after the state vector."""
    return isinstance(observation, Sequence | np.ndarray) and len(observation) > SEPARATED


class Policy(Protocol):
    """Who decides what a robot does next."""

    def act(self, observation: Observation, rng: np.random.Generator | None = None) -> int:
        """The behaviour to execute now, as its number in table 4.1.

        Args:
            observation: What the robot perceives; see `state_vector_of`.
            rng: Where a policy that decides by chance draws from; others take no notice of it.
        """
        ...


def state_vector_of(observation: Observation) -> StateVector:
    """The state vector in an observation, as plain integers.

    Ranges are not looked at: an environment's spaces state them, and this runs at every step.

    Args:
        observation: A mapping with the five attribute names as keys, or a sequence or one-dimensional array
            that starts with the five attributes in the order of `StateVector`; what follows is left out. A
            value is an integer of Python or NumPy, or an array that holds one.

    Raises:
        ValueError: A key is missing, the sequence is too short, or a value is not one integer.
    """
    if type(observation) is dict or isinstance(observation, Mapping):  # the first check is the faster one
        try:
            values: Sequence[Any] = (
                observation["object_presence"],
                observation["robot_home_distance"],
                observation["food_type"],
                observation["arms_height"],
                observation["robot_food_distance"],
            )
        except KeyError as error:
            needed = ", ".join(StateVector._fields)
            raise ValueError(
                f"observation lacks {error}, it has {list(observation)}; needed: {needed}"
            ) from None
    elif isinstance(observation, np.ndarray):
        if observation.ndim != 1:
            raise ValueError(f"observation has shape {observation.shape}; allowed: one dimension")
        values = observation[:5].tolist()
    elif isinstance(observation, Sequence):
        values = observation[:5]
    else:
        raise ValueError(f"observation is {observation!r}; allowed: a mapping, a sequence or an array")
    if len(values) != 5:
        raise ValueError(f"observation has {len(values)} values; allowed: at least 5, {StateVector._fields}")
    try:
        presence, home, food_type, arm, food = [
            v if type(v) is int else index(v.item() if type(v) is np.ndarray else v) for v in values
        ]
        return StateVector(presence, home, food_type, arm, food)
    except (TypeError, ValueError):
        raise ValueError(f"observation has the values {tuple(values)!r}; allowed: one integer each") from None
