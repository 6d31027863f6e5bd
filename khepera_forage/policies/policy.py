"""The `Policy` contract, the state vector in an observation (4.3), votes, and two policies without experience."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from operator import index
from typing import Any, NamedTuple, Protocol, TypeAlias, TypeGuard

import numpy as np
from numpy.typing import ArrayLike, NDArray

from khepera_forage.task.states import Behaviour, StateVector

Observation: TypeAlias = Mapping[str, Any] | Sequence[Any] | NDArray[Any]
"""An observation of a recall environment (a mapping) or of the training environment (seven integers)."""

CACHE_SIZE = 32768
"""State vectors that a policy caches, some 15 MB. It sees a few thousand distinct ones in a corridor."""
HEARD, SEPARATED = 5, 6
"""Positions in an observation of the training environment: the behaviour heard, and whether robots are separated."""


def is_training(observation: Observation) -> TypeGuard[Sequence[Any] | NDArray[Any]]:
    """Whether an observation is of the training environment: a sequence longer than the state vector."""
    return isinstance(observation, Sequence | np.ndarray) and len(observation) > SEPARATED


class Policy(Protocol):
    """Decides what a robot does next. This is the contract of all policies."""

    def act(self, observation: Observation, rng: np.random.Generator | None = None) -> int:
        """The behaviour to execute now, as its number in table 4.1.

        Args:
            observation: What the robot perceives; see `state_vector_of`.
            rng: For policies that draw their behaviours, which need it; others ignore it.

        Raises:
            TypeError: A behaviour is to be drawn, and `rng` is not a NumPy generator.
            ValueError: The observation holds no state vector, or what was decided is no behaviour.
        """
        ...


def state_vector_of(observation: Observation) -> StateVector:
    """The state vector in an observation, as plain integers.

    Ranges are not checked: the environment's spaces state them, and this function runs at every step.

    Args:
        observation: A mapping with the five attribute names as keys, or a sequence or one-dimensional array
            that starts with the five attributes in the order of `StateVector`; the rest is ignored. A
            value is an integer of Python or NumPy, or an array that holds one.

    Raises:
        ValueError: A key is missing, the sequence is too short, or a value is not one integer.
    """
    if isinstance(observation, Mapping):
        try:
            values: Sequence[Any] = [observation[name] for name in StateVector._fields]
        except KeyError as error:
            needed = ", ".join(StateVector._fields)
            raise ValueError(f"observation lacks {error}, it has {list(observation)}; needed: {needed}") from None
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
        return StateVector(*[index(v.item() if isinstance(v, np.ndarray) else v) for v in values])
    except (TypeError, ValueError):
        raise ValueError(f"observation has the values {tuple(values)!r}; allowed: one integer each") from None


def checked_generator(rng: Any) -> np.random.Generator:
    """A generator that a policy draws its actions from.

    Raises:
        TypeError: `rng` is not a NumPy generator.
    """
    if not isinstance(rng, np.random.Generator):
        raise TypeError(f"rng is {rng!r}; allowed: a numpy.random.Generator, to draw actions from")
    return rng


def behaviours_of(labels: ArrayLike) -> list[Behaviour]:
    """The behaviours that a classifier's labels, its `classes_`, stand for.

    Raises:
        ValueError: One of them is no behaviour's number.
    """
    numbers = np.asarray(labels).tolist()
    try:
        return [Behaviour(number) for number in numbers]
    except ValueError:
        raise ValueError(f"labels learned are {numbers}; allowed: behaviours, 0 to {max(Behaviour):d}") from None


def remembered(cache: dict[Any, Any], key: Any, find: Callable[[], Any]) -> Any:
    """What belongs to a key: from the cache, which is emptied when it is full, or else found now."""
    if key not in cache:
        if len(cache) >= CACHE_SIZE:
            cache.clear()
        cache[key] = find()
    return cache[key]


@dataclass(frozen=True, slots=True)
class UniformPolicy:
    """Draws one of the ten behaviours and ignores the observation."""

    def act(self, observation: Observation, rng: np.random.Generator | None = None) -> Behaviour:
        """A random behaviour; draws one number from `rng`, which must be given."""
        return Behaviour(int(checked_generator(rng).integers(Behaviour.WAIT)))


@dataclass(frozen=True, slots=True)
class Listener:
    """Executes the behaviour it hears; silence makes it wait."""

    def act(self, observation: Observation, rng: np.random.Generator | None = None) -> Behaviour:
        """The behaviour heard; the observation must be one of the training environment, seven integers."""
        if not is_training(observation):
            raise ValueError(f"observation is {observation!r}; allowed: seven integers of a training environment")
        return Behaviour(int(observation[HEARD]))


def draw_label(votes: Sequence[float] | NDArray[Any], total: float, chance: float) -> int:
    """A label, drawn with its share of the votes as probability (4.6.2).

    Args:
        votes: Of each label.
        total: Their sum, above 0.
        chance: A uniform number in 0..1, 1 excluded.
    """
    left = chance * total
    drawn = 0
    for label, count in enumerate(votes):
        if count > 0:
            drawn = label
            left -= count
            if left < 0.0:
                break
    return drawn


class Neighbours(NamedTuple):
    """The experience vectors at the minimum distance from a state vector (with a threshold: near it).

    Attributes:
        behaviours: The behaviours heard with them, in increasing order.
        counts: How many of the vectors vote for each of these behaviours, above 0.
        tied: How many vectors vote; equal vectors count one by one.
        distance: The minimum distance of section 4.6.1.
    """

    behaviours: tuple[Behaviour, ...]
    counts: tuple[int, ...]
    tied: int
    distance: float

    @property
    def votes(self) -> tuple[tuple[Behaviour, int], ...]:
        """Each behaviour with the number of its votes."""
        return tuple(zip(self.behaviours, self.counts, strict=True))

    @property
    def tie(self) -> bool:
        """Whether more than one experience vector votes."""
        return self.tied > 1

    @property
    def conflict(self) -> bool:
        """Whether they vote for more than one behaviour."""
        return len(self.behaviours) > 1

    def confidence_levels(self) -> dict[Behaviour, float]:
        """The share of each behaviour in the votes; the shares sum to 1."""
        return {behaviour: count / self.tied for behaviour, count in self.votes}

    def draw(self, rng: np.random.Generator) -> Behaviour:
        """A behaviour, with its confidence level as probability. Draws exactly one number from `rng`."""
        return self.behaviours[draw_label(self.counts, self.tied, rng.random())]
