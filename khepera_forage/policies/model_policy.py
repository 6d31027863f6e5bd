"""Models of stable-baselines3 as policies; `rollouts.reinforcement` trains such models (extra `baselines`)."""

import inspect
import io
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, Protocol

import numpy as np
from gymnasium import spaces
from numpy.random import Generator
from numpy.typing import NDArray

from khepera_forage.extras import require
from khepera_forage.policies.policy import state_vector_of
from khepera_forage.policies.teacher import APPLICABLE
from khepera_forage.task.states import Behaviour

ALGORITHMS = ("PPO", "DQN", "SAC")
"""Names of classes in stable-baselines3."""


class Model(Protocol):
    """A trained model with the `predict` of stable-baselines3."""

    def predict(self, observation: Any, *, deterministic: bool) -> tuple[Any, Any]:
        """The action, and the state of a recurrent model."""
        ...


@dataclass
class ModelPolicy:
    """Executes the actions of a trained model: behaviours, or motors.

    An action may hold for several rounds, as it did in training. It holds for one generator: another generator means
    another episode, and a new action. A recurrent model, whose `predict` returns a state, likewise forgets its state
    with another generator. A model whose `predict` takes `action_masks`, such as sb3-contrib's MaskablePPO, gets those
    of `BehavioursEnv.action_masks`. A model of one of `ALGORITHMS` is pickled the way stable-baselines3 saves it.

    Attributes:
        model: Trained on what `features` makes of the environment's observations.
        features: From an observation to one row of numbers, as in `policies.features`; by default the model gets the
            environment's observations unchanged.
        hold: Rounds that an action holds.
        sample: Whether actions are drawn from the model's distribution with the policy's `rng` (PPO only).
        deterministic: Whether the model, without `sample`, takes its most probable action. If not, the model draws
            from its own random numbers, which are seeded where the model is made.
    """

    model: Model
    features: Callable[[Any], Any] | None = None
    hold: int = 1
    sample: bool = False
    deterministic: bool = True
    _held: tuple[Generator | None, int, Any] = field(default=(None, 0, None), init=False, repr=False)
    """The generator of the last action, for how many more rounds the action holds, and the action."""
    _memory: tuple[Generator | None, Any] = field(default=(None, None), init=False, repr=False)
    """The generator of the last prediction, and the state that a recurrent model returned with it."""
    _recurs: bool = field(init=False, repr=False)
    """Whether the model takes a state."""
    _masks: bool = field(init=False, repr=False)
    """Whether the model takes action masks."""

    def __post_init__(self) -> None:
        parameters = inspect.signature(self.model.predict).parameters
        self._recurs = {"state", "episode_start"} <= set(parameters)
        self._masks = "action_masks" in parameters

    def act(self, observation: Any, rng: Generator | None = None) -> Any:
        """The model's action.

        Args:
            observation: As the environment gives it.
            rng: Must be given with `sample`: one number is drawn for a behaviour, four for motors.

        Returns:
            A `Behaviour`, or motors: four numbers in -1..1, as `CorridorWheels-v1` takes them.

        Raises:
            TypeError: `rng` is not a NumPy generator, with `sample` or with a recurrent model.
            ValueError: The observation lacks what `features` needs, or the model's action is not a behaviour.
        """
        if self.sample and not isinstance(rng, Generator):
            raise TypeError(f"rng is {rng!r}; allowed: a numpy.random.Generator, to draw actions from")
        generator, rounds, action = self._held
        if generator is not rng or rounds == 0:
            rounds, action = self.hold, self._action(observation, rng)
        self._held = rng, rounds - 1, action
        return action.copy() if isinstance(action, np.ndarray) else action

    def _action(self, observation: Any, rng: Generator | None) -> Behaviour | NDArray[np.float32]:
        shown = observation if self.features is None else self.features(observation)
        if self.sample:
            assert rng is not None
            action = _drawn(self.model, shown, rng)
        else:
            action = self._predicted(shown, rng, observation)
        numbers = np.ravel(action)
        return Behaviour(int(numbers[0])) if len(numbers) == 1 else numbers.astype(np.float32)

    def _predicted(self, shown: Any, rng: Generator | None, observation: Any) -> Any:
        options: dict[str, Any] = {"deterministic": self.deterministic}
        if self._masks:
            vector = state_vector_of(observation)
            options["action_masks"] = APPLICABLE[vector.object_presence, vector.food_type]
        if not self._recurs:
            return self.model.predict(shown, **options)[0]
        generator, state = self._memory
        begins = generator is not rng or state is None
        options |= {"state": None if begins else state, "episode_start": np.array([begins])}
        action, state = self.model.predict(shown, **options)
        if state is not None and rng is None:
            raise TypeError(
                "rng is None; allowed for a recurrent model: a numpy.random.Generator, another one for each episode"
            )
        self._memory = rng, state
        return action

    def __getstate__(self) -> dict[str, Any]:
        model: Any = self.model
        name = type(model).__name__
        if name in ALGORITHMS:
            file = io.BytesIO()
            model.save(file)
            model = name, file.getvalue()
        return {**self.__dict__, "model": model, "_held": (None, 0, None), "_memory": (None, None)}

    def __setstate__(self, state: dict[str, Any]) -> None:
        model = state["model"]
        if isinstance(model, tuple):
            name, saved = model
            model = algorithm_named(name).load(io.BytesIO(saved), device="cpu")
        self.__dict__.update(state, model=model)


def algorithm_named(name: str) -> Any:
    """A class of stable-baselines3.

    Raises:
        ValueError: The name is not one of `ALGORITHMS`.
        ImportError: stable-baselines3 is not installed; the message says how to install it.
    """
    if name not in ALGORITHMS:
        raise ValueError(f"algorithm is {name!r}; allowed: {', '.join(ALGORITHMS)}")
    require(name, "baselines")
    import stable_baselines3

    return getattr(stable_baselines3, name)


def behaviour_probabilities(model: Any, shown: NDArray[np.float32]) -> NDArray[np.float64]:
    """How probable each behaviour is in the distribution of a model of PPO.

    Args:
        model: Trained with behaviours as actions.
        shown: Features, one row an observation.

    Returns:
        One row an observation.
    """
    probabilities = _distribution(model, shown).probs
    return np.array(probabilities.tolist(), np.float64)


def _drawn(model: Any, shown: Any, rng: Generator) -> Any:
    """An action, drawn from the distribution of a model of PPO."""
    if isinstance(model.action_space, spaces.Discrete):
        steps = np.cumsum(behaviour_probabilities(model, shown)[0])
        return int(steps.searchsorted(rng.random() * steps[-1], side="right"))
    distribution = _distribution(model, shown)
    return np.clip(rng.normal(distribution.mean[0].tolist(), distribution.stddev[0].tolist()), -1.0, 1.0)


def _distribution(model: Any, shown: Any) -> Any:
    """PyTorch's distribution of the actions of a model of PPO."""
    tensor, _ = model.policy.obs_to_tensor(shown)
    return model.policy.get_distribution(tensor).distribution
