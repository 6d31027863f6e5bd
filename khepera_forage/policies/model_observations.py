"""What a trained model is shown: an observation in the form that its own observation space has."""

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray

from khepera_forage.policies.features import (
    BEHAVIOUR_FEATURES,
    WHEELS_FEATURES,
    observation_features,
    wheels_features,
)
from khepera_forage.policies.policy import Observation, state_vector_of
from khepera_forage.task.states import FoodType, StateVector

Form = Callable[[Any], NDArray[Any]]
CATEGORIES = {"object_presence": 2, "tracked": 2, "food_seen": 2, "food_type": len(FoodType)}
"""Parts of an observation that are one of so many categories."""
BEHAVIOUR_NUMBERS, WHEELS_NUMBERS = 9, 28
"""Numbers of a flattened observation."""


def form_for(model: Any) -> Form | None:
    """How observations are shown to a model.

    Args:
        model: With the `observation_space` that it was trained on, as models of stable-baselines3 have. A model
            without one gets observations as they are.

    Returns:
        A function of the observation; None if the model gets it as it is.

    Raises:
        ValueError: The model was trained on observations of another kind.
    """
    space = getattr(model, "observation_space", None)
    if space is None:
        return None
    if isinstance(space, spaces.Dict) and {"arms_height", "proximity"} & set(space.spaces):
        return None
    if isinstance(space, spaces.Box) and len(space.shape) == 1:
        if space.is_bounded() and space.shape[0] in (BEHAVIOUR_NUMBERS, WHEELS_NUMBERS):
            return flattened
        forms: dict[int, Form] = {BEHAVIOUR_FEATURES: observation_features, WHEELS_FEATURES: wheels_features}
        if not space.is_bounded() and space.shape[0] in forms:
            return forms[space.shape[0]]
    raise ValueError(
        f"model was trained on observations {space}; allowed: those of a recall environment as they are, by "
        "FlattenObservation, or by VecEnvAdapter; for others make ModelPolicy(model, features=...)"
    )


def flattened(observation: Observation) -> NDArray[Any]:
    """One observation in one row, as Gymnasium's `FlattenObservation` shows it.

    Args:
        observation: Of a recall environment, or a state vector.

    Returns:
        Of shape (9,) for behaviours and (28,) for wheels; categories are one-hot.

    Raises:
        ValueError: The observation is neither.
    """
    if isinstance(observation, Mapping) and "proximity" in observation:
        parts: Mapping[str, Any] = observation
    else:
        parts = dict(zip(StateVector._fields, state_vector_of(observation), strict=True))
    return np.concatenate(
        [
            np.eye(CATEGORIES[name], dtype=np.int64)[int(value)] if name in CATEGORIES else np.ravel(value)
            for name, value in parts.items()
        ]
    )
