"""Models of stable-baselines3 as policies (extra `baselines`); `rollouts.reinforcement` trains them."""

import io
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from khepera_forage.policies.features import state_vector_features, wheels_features
from khepera_forage.policies.policy import Observation, state_vector_of
from khepera_forage.task.states import Behaviour, StateVector

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


@dataclass
class _Trained:
    """A trained model; it is pickled the way stable-baselines3 saves it.

    A decision may hold for several rounds, as it did in training. It holds for one generator: another one means another
    episode, and a new decision.

    Attributes:
        model: Trained on the features of `policies.features`.
        hold: Rounds that a decision holds.
        sample: Whether decisions are drawn with their probabilities (PPO only), or the best one carried out.
    """

    model: Any
    hold: int = 1
    sample: bool = False
    _held: tuple[np.random.Generator | None, int, Any] = field(
        default=(None, 0, None), init=False, repr=False
    )
    """For whom, for how many more rounds, and what."""

    def _decided(self, rng: np.random.Generator | None, decide: Callable[[], Any]) -> Any:
        """What was decided on, as long as it holds; then what `decide` says."""
        if self.sample and not isinstance(rng, np.random.Generator):
            raise TypeError(f"rng is {rng!r}; allowed: a numpy.random.Generator, to draw decisions from")
        whose, left, decision = self._held
        if whose is not rng or left == 0:
            left, decision = self.hold, decide()
        self._held = rng, left - 1, decision
        return decision

    def _distribution(self, features: NDArray[np.float32]) -> Any:
        """What decisions are drawn from, as torch has it."""
        rows, _ = self.model.policy.obs_to_tensor(features)
        return self.model.policy.get_distribution(rows).distribution

    def __getstate__(self) -> dict[str, Any]:
        file = io.BytesIO()
        self.model.save(file)
        saved = type(self.model).__name__, file.getvalue()
        return {**self.__dict__, "model": saved, "_held": (None, 0, None)}

    def __setstate__(self, state: dict[str, Any]) -> None:
        name, saved = state["model"]
        model = algorithm_named(name).load(io.BytesIO(saved), device="cpu")
        self.__dict__.update(state, model=model)


@dataclass
class BaselinePolicy(_Trained):
    """Executes a behaviour that a trained PPO or DQN chooses; attributes as all trained models have them."""

    def act(self, observation: Observation, rng: np.random.Generator | None = None) -> Behaviour:
        """The behaviour chosen.

        Args:
            observation: What the robot perceives; see `policies.policy.state_vector_of`.
            rng: Must be given if behaviours are drawn: one number is drawn at every decision.

        Raises:
            TypeError: A behaviour is to be drawn and `rng` is not a NumPy generator.
            ValueError: The observation holds no state vector.
        """
        vector = state_vector_of(observation)
        behaviour: Behaviour = self._decided(rng, lambda: self._chosen(vector, rng))
        return behaviour

    def _chosen(self, vector: StateVector, rng: np.random.Generator | None) -> Behaviour:
        features = state_vector_features(np.array([vector]))
        if not self.sample:
            chosen, _ = self.model.predict(features, deterministic=True)
            return Behaviour(int(chosen[0]))
        assert rng is not None
        steps = np.cumsum(self._distribution(features).probs[0].tolist())
        return Behaviour(int(steps.searchsorted(rng.random() * steps[-1], side="right")))


@dataclass
class WheelsPolicy(_Trained):
    """Commands wheels, arm and jaw as a trained PPO or SAC says; attributes as all trained models have them."""

    def act(
        self, observation: Mapping[str, Any], rng: np.random.Generator | None = None
    ) -> NDArray[np.float32]:
        """The motors, as `CorridorWheels-v0` takes them.

        Args:
            observation: The raw data that `CorridorWheels-v0` and `RectangleWheels-v0` show.
            rng: Must be given if motors are drawn: four numbers are drawn at every decision.

        Returns:
            Four numbers, -1..1.

        Raises:
            TypeError: Motors are to be drawn and `rng` is not a NumPy generator.
            ValueError: Part of the raw data is missing, at a decision.
        """
        motors: NDArray[np.float32] = self._decided(rng, lambda: self._commanded(observation, rng))
        return motors.copy()

    def _commanded(
        self, observation: Mapping[str, Any], rng: np.random.Generator | None
    ) -> NDArray[np.float32]:
        features = wheels_features(observation)
        if not self.sample:
            return np.asarray(self.model.predict(features, deterministic=True)[0][0], np.float32)
        assert rng is not None
        normal = self._distribution(features)
        motors = np.clip(rng.normal(normal.mean[0].tolist(), normal.stddev[0].tolist()), -1.0, 1.0)
        return np.asarray(motors, np.float32)
