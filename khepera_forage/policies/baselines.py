"""Models of stable-baselines3 as policies (extra `baselines`); `experiments.reinforcement` trains them."""

import io
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from khepera_forage.foraging.states import Behaviour, StateVector
from khepera_forage.policies.features import behaviour_features, wheels_features
from khepera_forage.policies.policy import Observation, state_vector_of

ALGORITHMS = ("PPO", "DQN", "SAC")
"""Names of classes in stable-baselines3."""


def algorithm_named(name: str) -> Any:
    """A class of stable-baselines3.

    Raises:
        ValueError: Not one of `ALGORITHMS`.
        ImportError: stable-baselines3 is not installed; the message says how to install it.
    """
    if name not in ALGORITHMS:
        raise ValueError(f"algorithm is {name!r}; allowed: {', '.join(ALGORITHMS)}")
    try:
        import stable_baselines3
    except ImportError as error:
        raise ImportError(
            f"{name} needs stable-baselines3: pip install 'khepera-forage[baselines]'"
        ) from error
    return getattr(stable_baselines3, name)


@dataclass(frozen=True)
class _Trained:
    """A trained model; it is pickled the way stable-baselines3 saves it.

    Attributes:
        model: Trained on the features of `policies.features`.
    """

    model: Any

    def __getstate__(self) -> dict[str, Any]:
        file = io.BytesIO()
        self.model.save(file)
        return {**self.__dict__, "model": (type(self.model).__name__, file.getvalue())}

    def __setstate__(self, state: dict[str, Any]) -> None:
        name, saved = state["model"]
        model = algorithm_named(name).load(io.BytesIO(saved), device="cpu")
        self.__dict__.update(state, model=model)


@dataclass(frozen=True)
class BaselinePolicy(_Trained):
    """Executes a behaviour that a trained PPO or DQN chooses.

    Attributes:
        model: Trained on `policies.features.behaviour_features`.
        sample: Whether a behaviour is drawn with its probability (PPO only), or the best one executed.
    """

    sample: bool = False

    def act(self, observation: Observation, rng: np.random.Generator | None = None) -> Behaviour:
        """The behaviour chosen.

        Args:
            observation: What the robot perceives; see `policies.policy.state_vector_of`.
            rng: Must be given if behaviours are drawn: one number is drawn at every call.

        Raises:
            TypeError: A behaviour is to be drawn and `rng` is not a NumPy generator.
            ValueError: The observation holds no state vector.
        """
        if self.sample and not isinstance(rng, np.random.Generator):
            raise TypeError(f"rng is {rng!r}; allowed: a numpy.random.Generator, to draw behaviours from")
        vector = state_vector_of(observation)
        features = behaviour_features(StateVector._asdict(vector))
        if not self.sample:
            chosen, _ = self.model.predict(features, deterministic=True)
            return Behaviour(int(chosen[0]))
        assert rng is not None
        rows, _ = self.model.policy.obs_to_tensor(features)
        levels = self.model.policy.get_distribution(rows).distribution.probs[0].tolist()
        steps = np.cumsum(levels)
        return Behaviour(int(steps.searchsorted(rng.random() * steps[-1], side="right")))


@dataclass(frozen=True)
class WheelsPolicy(_Trained):
    """Commands wheels, arm and jaw as a trained PPO or SAC says, always the mean of what it would draw.

    Attributes:
        model: Trained on `policies.features.wheels_features`.
    """

    def act(
        self, observation: Mapping[str, Any], rng: np.random.Generator | None = None
    ) -> NDArray[np.float32]:
        """The motors, as `CorridorWheels-v0` takes them.

        Args:
            observation: The raw data that `CorridorWheels-v0` and `RectangleWheels-v0` show.
            rng: Not used.

        Returns:
            Four numbers, -1..1.

        Raises:
            ValueError: Part of the raw data is missing.
        """
        action, _ = self.model.predict(wheels_features(observation), deterministic=True)
        motors: NDArray[np.float32] = action[0]
        return motors
