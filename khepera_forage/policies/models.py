"""Models of stable-baselines3, and whatever else can decide, as policies.

`rollouts.reinforcement` trains such models (extra `baselines`).
"""

import copy
import inspect
import io
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial, reduce
from numbers import Integral
from typing import Any

import gymnasium as gym
import numpy as np
from gymnasium import spaces
from numpy.random import Generator

from khepera_forage.extras import require
from khepera_forage.policies.classifiers import policy_of
from khepera_forage.policies.features import raw_data_space, state_vector_space
from khepera_forage.policies.policy import Observation, Policy, checked_generator, draw_label, state_vector_of
from khepera_forage.policies.teacher import APPLICABLE, Teacher
from khepera_forage.task.states import Behaviour, behaviour_number

Form = Callable[[Any], Any]
"""From an observation to what a model is shown."""
_TRANSPARENT = {
    *("DummyVecEnv", "SubprocVecEnv", "SyncVectorEnv", "AsyncVectorEnv", "VecMonitor", "VecCheckNan"),
    *("VecVideoRecorder", "Monitor", "PassiveEnvChecker", "OrderEnforcing", "TimeLimit", "RecordVideo"),
    *("RecordEpisodeStatistics", "HumanRendering", "Autoreset", "FlattenObservation", "DtypeObservation"),
    *("NormalizeReward", "ActionMasker"),
}
"""Classes around an environment that leave observations as they are, or change them as its space says."""
_ALLOWED = (
    "allowed: a model with the environments that it was trained in, which show observations of a recall environment "
    "as they are, by FlattenObservation, or by VecEnvAdapter, also behind VecNormalize; for others make "
    "ModelPolicy(model, features=..., hold=...) with what the model was shown in training, and the rounds that each "
    "action held"
)
ALGORITHMS = ("PPO", "DQN", "SAC")
"""Names of classes in stable-baselines3."""
_NOTHING = None, 0, None, None


@dataclass
class ModelPolicy:
    """Executes the actions of a trained model: behaviours, or motors.

    An action may hold for several rounds, as it did in training. It holds for one generator: another generator means
    another episode, and a new action. A recurrent model, whose `predict` returns a state, likewise forgets its state
    with another generator. A model whose `predict` takes `action_masks`, such as sb3-contrib's MaskablePPO, gets those
    of `BehavioursEnv.action_masks`. A model of one of `ALGORITHMS` is pickled the way stable-baselines3 saves it.

    Attributes:
        model: With the `predict` of stable-baselines3, trained on what `features` makes of observations.
        features: From an observation to one row of numbers, as in `policies.features`; by default the model gets the
            environment's observations unchanged.
        hold: Rounds that an action holds.
        sample: Whether actions are drawn from the model's distribution with the policy's `rng` (PPO only). If not, the
            most probable action is taken.
    """

    model: Any
    features: Callable[[Any], Any] | None = None
    hold: int = 1
    sample: bool = False
    _last: tuple[Generator | None, int, Any, Any] = field(default=_NOTHING, init=False, repr=False)
    """The generator of the last action, how many more rounds it holds, the action, and a recurrent model's state."""
    _takes: frozenset[str] = field(init=False, repr=False)
    """Arguments of the model's `predict`."""

    def __post_init__(self) -> None:
        if not isinstance(self.hold, Integral) or self.hold < 1:
            raise ValueError(f"hold is {self.hold!r}; allowed: a whole number of at least 1")
        self._takes = frozenset(inspect.signature(self.model.predict).parameters)

    def act(self, observation: Any, rng: Generator | None = None) -> Any:
        """The model's action; with `sample` one number is drawn for a behaviour, and four for motors.

        Returns:
            A `Behaviour`, or motors: four numbers in -1..1, as `CorridorWheels-v1` takes them.

        Raises:
            TypeError: `rng` is not a NumPy generator, with `sample` or with a recurrent model.
            ValueError: The observation lacks what `features` needs, or the model's action is not a behaviour.
        """
        if self.sample:
            checked_generator(rng)
        generator, rounds, action, state = self._last
        if generator is not rng:
            rounds, state = 0, None
        if rounds == 0:
            rounds = self.hold
            action, state = self._action(observation, rng, state)
        self._last = rng, rounds - 1, action, state
        return action.copy() if isinstance(action, np.ndarray) else action

    def _action(self, observation: Any, rng: Generator | None, state: Any) -> tuple[Any, Any]:
        """A behaviour or motors, and the new state of a recurrent model."""
        try:
            shown = observation if self.features is None else self.features(observation)
        except KeyError as error:
            raise ValueError(f"the observation has no {error}, on which the model was trained") from None
        if self.sample:
            action = _drawn(self.model, shown, checked_generator(rng))
        else:
            options: dict[str, Any] = {"deterministic": True}
            recurs = {"state", "episode_start"} <= self._takes
            if "action_masks" in self._takes:
                vector = state_vector_of(observation)
                options["action_masks"] = APPLICABLE[vector.object_presence, vector.food_type]
            if recurs:
                options |= {"state": state, "episode_start": np.array([state is None])}
            action, state = self.model.predict(shown, **options)
            if recurs and state is not None and rng is None:
                raise TypeError(
                    "rng is None; allowed for a recurrent model: a numpy.random.Generator, another one for each episode"
                )
        if np.size(action) == 1:
            return Behaviour(behaviour_number(np.asarray(action), who=type(self.model).__name__)), state
        return np.ravel(action).astype(np.float32), state

    def __getstate__(self) -> dict[str, Any]:
        model: Any = self.model
        name = type(model).__name__
        if name in ALGORITHMS:
            file = io.BytesIO()
            model.save(file)
            model = name, file.getvalue()
        return {**self.__dict__, "model": model, "_last": _NOTHING}

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


def _drawn(model: Any, shown: Any, rng: Generator) -> Any:
    """An action, drawn from the distribution of a model of PPO."""
    tensor, _ = model.policy.obs_to_tensor(shown)
    distribution = model.policy.get_distribution(tensor).distribution
    if isinstance(model.action_space, spaces.Discrete):
        levels = distribution.probs[0].tolist()
        return draw_label(levels, sum(levels), rng.random())
    return np.clip(rng.normal(distribution.mean[0].tolist(), distribution.stddev[0].tolist()), -1.0, 1.0)


def training_of(model: Any) -> tuple[Form | None, int]:
    """What a model was shown in its training, and for how many rounds its actions held.

    Both follow from the environments that a model of stable-baselines3 was trained in, with all their wrappers, and
    from its observation space. What does not follow from them is an error, and never guessed.

    Args:
        model: Of stable-baselines3, with its environments; or with an `observation_space`, whose actions then hold for
            one round. A model without one gets observations as they are.

    Returns:
        From an observation to what the model is shown, or None if that is the observation as it is; and the rounds.

    Raises:
        ValueError: It is not known what the model was trained on.
    """
    space: Any = getattr(model, "observation_space", None)
    if not hasattr(model, "get_env"):
        return None if space is None else form_of(space), 1
    kind, env = type(model).__name__, model.get_env()
    if env is None:
        raise ValueError(
            f"{kind} was loaded without the environments that it was trained in; {_ALLOWED} "
            f"({kind}.load(path, env=...) gives it environments)"
        )
    forms: list[Form] = []
    hold = 1
    for name, layer in _layers(env):
        if name == "VecNormalize":
            forms.insert(0, layer.normalize_obs)
        elif name == "VecEnvAdapter":
            if layer.features is not None:
                forms.insert(0, layer.features)
                space = None  # of what the features make of observations
        elif name in ("ActionRepeat", "VectorActionRepeat"):
            hold *= layer["rounds"] if isinstance(layer, Mapping) else layer.rounds
        elif name not in _TRANSPARENT and not isinstance(layer, gym.RewardWrapper | gym.vector.VectorRewardWrapper):
            raise ValueError(f"{kind} was trained behind {name}; {_ALLOWED}")
    form = None if space is None else form_of(space)
    if form is not None:
        forms.insert(0, form)
    return partial(_one_after_another, forms) if forms else None, hold


def _one_after_another(forms: Sequence[Form], observation: Any) -> Any:
    return reduce(lambda shown, form: form(shown), forms, observation)


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
            return partial(_flattened, plain)
    raise ValueError(f"model was trained on observations {space}; {_ALLOWED}")


def _flattened(space: spaces.Space[Any], observation: Observation) -> Any:
    """One observation in one row, as Gymnasium's `FlattenObservation` shows it; categories are one-hot."""
    if not isinstance(observation, Mapping):
        observation = state_vector_of(observation)._asdict()
    return spaces.flatten(space, observation)


@dataclass(frozen=True, slots=True)
class AgentPolicy:
    """Executes the behaviours of an agent whose `act` takes no `rng`, but the observation alone, unchanged."""

    agent: Any

    def act(self, observation: Observation, rng: np.random.Generator | None = None) -> Behaviour:
        """The agent's behaviour."""
        return Behaviour(behaviour_number(self.agent.act(observation), who=type(self.agent).__name__))


def as_policy(learner: Any) -> Policy:
    """A policy made of any learner that can decide.

    Args:
        learner: One of these, the first that fits: something with `act(observation, rng)`, which is a policy
            already; with `act(observation)`; a fitted classifier with `predict_proba`, whose behaviours are drawn
            with their probabilities (the policy copies the classifier, so that later learning does not change it); a
            trained model with `predict(observation, deterministic=...)`, which is shown what it was trained on, and
            whose actions hold as long as in training. For other choices make `ClassifierPolicy` or `ModelPolicy`
            yourself.

    Raises:
        TypeError: The learner is none of these, or a class where an instance is needed.
        ValueError: A classifier has no `classes_` or was not fitted on five columns; or it is not known how a model
            was trained.
    """
    if not isinstance(learner, type):
        if callable(getattr(learner, "act", None)):
            return learner if _takes_rng(learner.act) else AgentPolicy(learner)
        if callable(getattr(learner, "predict_proba", None)):
            return policy_of(copy.deepcopy(learner))
        predict = getattr(learner, "predict", None)
        if callable(predict) and "deterministic" in inspect.signature(predict).parameters:
            return ModelPolicy(learner, *training_of(learner))
    raise TypeError(
        f"learner is {learner!r}; allowed: an instance with act(observation), act(observation, rng), "
        "predict_proba(rows) or predict(observation, deterministic=...)"
    )


def _takes_rng(act: Any) -> bool:
    """Whether an `act` can be called with two arguments in a row."""
    try:
        inspect.signature(act).bind(0, 1)
    except TypeError:
        return False
    return True


def completed(policy: Any, env: Any) -> Policy:
    """A policy that knows what it needs of an environment: others stay.

    `Teacher()` becomes `Teacher.of(env)`. An imitator whose `diagonal` was not given has that of the arena.

    Args:
        policy: Of a robot, or what `as_policy` makes a policy of.
        env: One of ours, wrapped or not, after the reset, which chooses the arena.

    Raises:
        TypeError: As `as_policy`, like ValueError.
    """
    if getattr(policy, "diagonal", 0) is None:
        policy = copy.copy(policy)
        policy.diagonal = getattr(env.unwrapped, "diagonal", None)
    found = as_policy(policy)
    if isinstance(found, Teacher):
        own = Teacher.of(env)
        return Teacher(found.home_radius or own.home_radius, found.decisions or own.decisions)
    return found
