"""What a trained model is shown, and for how many rounds its actions hold: as in its training.

Both follow from the environments that a model of stable-baselines3 was trained in, with all their wrappers, and from
its observation space. What does not follow from them is an error, and never guessed.
"""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

import gymnasium as gym
import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray

from khepera_forage.policies.features import behaviour_features, observation_features
from khepera_forage.policies.policy import Observation, state_vector_of
from khepera_forage.robots.khepera import ARM_DOWN, ARM_RAISED, JAW_CLOSED, JAW_OPEN
from khepera_forage.task.states import FoodType, StateVector

Form = Callable[[Any], Any]
CATEGORIES = {"object_presence": 2, "tracked": 2, "food_seen": 2, "food_type": len(FoodType)}
"""Parts of an observation that are one of so many categories."""
_TRANSPARENT = {
    *("DummyVecEnv", "SubprocVecEnv", "SyncVectorEnv", "AsyncVectorEnv", "VecMonitor", "VecCheckNan"),
    *("VecVideoRecorder", "Monitor", "PassiveEnvChecker", "OrderEnforcing", "TimeLimit", "RecordVideo"),
    *("RecordEpisodeStatistics", "HumanRendering", "Autoreset", "FlattenObservation", "DtypeObservation"),
}
"""Classes around an environment that leave observations as they are, or change them as its space says."""
_ALLOWED = (
    "allowed: a model with the environments that it was trained in, which show observations of a recall environment "
    "as they are, by FlattenObservation, or by VecEnvAdapter, also behind VecNormalize; for others make "
    "ModelPolicy(model, features=..., hold=...) with what the model was shown in training, and the rounds that each "
    "action held"
)


def state_vector_space(diagonal: int) -> spaces.Dict:
    """The space of state vectors (4.3).

    Args:
        diagonal: The longest distance, in pixels.
    """
    return spaces.Dict(
        object_presence=spaces.Discrete(2),
        robot_home_distance=spaces.Box(0, diagonal, (1,), np.int64),
        food_type=spaces.Discrete(len(FoodType)),
        arms_height=spaces.Box(ARM_RAISED, ARM_DOWN, (1,), np.int64),
        robot_food_distance=spaces.Box(0, diagonal, (1,), np.int64),
    )


def raw_data_space() -> spaces.Dict:
    """The space of raw data (4.2.2)."""
    place = 2000.0  # pixels: further than any camera sees
    return spaces.Dict(
        proximity=spaces.Box(0, 1023, (6,), np.int64),
        arm=spaces.Box(ARM_RAISED, ARM_DOWN, (1,), np.int64),
        jaw=spaces.Box(JAW_CLOSED, JAW_OPEN, (1,), np.int64),
        object_presence=spaces.Discrete(2),
        pose=spaces.Box(np.array((-place, -place, 0.0)), np.array((place, place, 360.0)), (3,), np.float64),
        tracked=spaces.Discrete(2),
        food_seen=spaces.Discrete(2),
        food=spaces.Box(-place, place, (2,), np.float64),
        food_type=spaces.Discrete(len(FoodType)),
        home=spaces.Box(-place, place, (3,), np.float64),
        wall=spaces.Box(np.array((0.0, -180.0)), np.array((place, 180.0)), (2,), np.float64),
    )


class Training(NamedTuple):
    """How a model was trained.

    Attributes:
        form: From an observation to what the model is shown; None if that is the observation as it is.
        hold: Rounds that an action holds.
    """

    form: Form | None
    hold: int


def training_of(model: Any) -> Training:
    """How a model was trained.

    Args:
        model: Of stable-baselines3, with its environments; or with an `observation_space`, whose actions then hold for
            one round. A model without one gets observations as they are.

    Raises:
        ValueError: It is not known what the model was trained on.
    """
    space: Any = getattr(model, "observation_space", None)
    if not hasattr(model, "get_env"):
        return Training(None if space is None else form_of(space), 1)
    kind, env = type(model).__name__, model.get_env()
    if env is None:
        raise ValueError(
            f"{kind} was loaded without the environments that it was trained in; {_ALLOWED} "
            f"({kind}.load(path, env=...) gives it environments)"
        )
    features: Form | None = None
    normalized: list[Form] = []
    hold = 1
    for name, layer in _layers(env):
        if name == "VecNormalize":
            normalized.insert(0, layer.normalize_obs)
        elif name == "VecEnvAdapter":
            features = observation_features if layer.features is behaviour_features else layer.features
        elif name in ("HoldAction", "HoldVectorAction"):
            hold *= layer["rounds"] if isinstance(layer, Mapping) else layer.rounds
        elif name not in _TRANSPARENT and not isinstance(
            layer, gym.RewardWrapper | gym.vector.VectorRewardWrapper
        ):
            raise ValueError(f"{kind} was trained behind {name}; {_ALLOWED}")
    form = features or form_of(space)
    return Training(Forms((*filter(None, [form]), *normalized)) if normalized else form, hold)


@dataclass(frozen=True)
class Forms:
    """One form after another."""

    forms: tuple[Form, ...]

    def __call__(self, observation: Any) -> Any:
        """What the last form makes of an observation."""
        for form in self.forms:
            observation = form(observation)
        return observation


def _layers(env: Any) -> Iterator[tuple[str, Any]]:
    """What is around an environment, from the outside: names of classes, and instances or their arguments."""
    while True:
        inner = next((getattr(env, name) for name in ("venv", "env", "envs") if name in vars(env)), None)
        if inner is None:
            break
        yield type(env).__name__, env
        env = inner[0] if isinstance(inner, list | tuple) else inner
    if type(env).__name__ in ("SubprocVecEnv", "AsyncVectorEnv"):
        (spec, *_) = env.get_attr("spec")
        for wrapper in reversed(spec.additional_wrappers):
            yield wrapper.name, wrapper.kwargs or {}


def form_of(space: spaces.Space[Any]) -> Form | None:
    """How observations are shown to a model with an observation space: as they are (None), or flattened.

    Raises:
        ValueError: The space is of other observations.
    """
    # Of state vectors, flattened or not, the last number is a distance.
    last = space.spaces.get("robot_home_distance") if isinstance(space, spaces.Dict) else space
    is_box = isinstance(last, spaces.Box) and last.shape in ((1,), (9,)) and last.is_bounded()
    for plain in (state_vector_space(int(last.high[-1]) if is_box else 0), raw_data_space()):  # type: ignore[union-attr]
        flat = spaces.flatten_space(plain)
        if space == plain:
            return None
        if (
            isinstance(space, spaces.Box)
            and isinstance(flat, spaces.Box)
            and np.array_equal((space.low, space.high), (flat.low, flat.high))
        ):
            return flattened
    raise ValueError(f"model was trained on observations {space}; {_ALLOWED}")


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
