"""The backends: what simulates the bodies. Entry points of `gym.make` and `gym.make_vec`."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import fields
from importlib import import_module
from typing import Any

import gymnasium as gym
from gymnasium.vector import VectorEnv

from khepera_forage.envs.arena_settings import procedural_settings
from khepera_forage.envs.arguments import BACKENDS, COMPILED, PYMUNK, check_backend
from khepera_forage.envs.behaviours_env import BehavioursEnv
from khepera_forage.envs.recall import RecallEnv
from khepera_forage.envs.wheels_env import WheelsEnv
from khepera_forage.noise import Noise
from khepera_forage.sim.arena import Arena, Point, Pose
from khepera_forage.sim.arenas.difficulty import Difficulty
from khepera_forage.sim.arenas.procedural import ProceduralArenas
from khepera_forage.task.decisions import DEFAULT_DECISIONS, Decisions

__all__ = ["BACKENDS", "COMPILED", "PYMUNK", "EntryPoint", "VectorEntryPoint", "check_backend", "check_compiled"]

VectorWrapping = Callable[[VectorEnv[Any, Any, Any]], VectorEnv[Any, Any, Any]]
"""Wraps a vector environment, such as `khepera_forage.wrappers.VectorActionRepeat`."""


class EntryPoint:
    """What `gym.make` calls.

    Args:
        kind: The class of environments.
        decisions: Of the environment's version, for users that give none.
    """

    metadata = RecallEnv.metadata

    def __init__(self, kind: type[RecallEnv[Any]], decisions: Decisions) -> None:
        self._kind = kind
        self._decisions = decisions

    def __call__(self, decisions: Any = None, **kwargs: Any) -> gym.Env[Any, Any]:
        """Make the environment.

        Args:
            decisions: `Decisions`, or those of a stored spec; by default those of the environment's version.
            kwargs: Other arguments of its class.
        """
        return self._kind(**_arguments(kwargs, decisions, self._decisions))


class VectorEntryPoint:
    """What `gym.make_vec` calls: makes compiled worlds, whatever their number.

    Args:
        compiled: Name of the class in `envs.compiled.vector_env`.
        decisions: Of the environment's version, for users that give none.
    """

    def __init__(self, compiled: str, decisions: Decisions) -> None:
        self._compiled = compiled
        self._decisions = decisions

    def __call__(
        self,
        num_envs: int = 1,
        backend: str = COMPILED,
        decisions: Any = None,
        vector_wrappers: Sequence[VectorWrapping] = (),
        **kwargs: Any,
    ) -> VectorEnv[Any, Any, Any]:
        """Make the vector environment.

        Args:
            num_envs: How many worlds.
            backend: Must be "compiled".
            decisions: `Decisions`, or those of a stored spec; by default those of the environment's version.
            vector_wrappers: Wrappers of vector environments, the innermost first. `gym.make_vec` has an argument
                `wrappers` too, but those are for single environments, and Gymnasium refuses them here.
            kwargs: Other arguments of its class.

        Raises:
            ValueError: Another backend, or a wrapper that makes no vector environment.
            ImportError: numba is not installed.
        """
        check_compiled(backend)
        arguments = _arguments(kwargs, decisions, self._decisions)
        made = getattr(import_module("khepera_forage.envs.compiled.vector_env"), self._compiled)
        env: VectorEnv[Any, Any, Any] = made(num_envs, **arguments)
        for wrapper in vector_wrappers:
            env = wrapper(env)
            if not isinstance(env, VectorEnv):
                raise ValueError(
                    f"vector_wrappers has {wrapper!r}, which returns {env!r}; allowed: functions that return a "
                    "gymnasium.vector.VectorEnv"
                )
        return env


def check_compiled(backend: Any) -> None:
    """Complain about a backend other than "compiled" where worlds are compiled.

    Raises:
        ValueError: Another backend.
        ImportError: numba is not installed.
    """
    if check_backend(backend) != COMPILED:
        raise ValueError(
            f"backend is {backend!r}; allowed here: {COMPILED!r} (make_vec with vectorization_mode='sync' or 'async' "
            "makes worlds of pymunk)"
        )


def _arguments(kwargs: Mapping[str, Any], decisions: Any, default: Decisions) -> dict[str, Any]:
    """The arguments of an environment's class.

    Args:
        kwargs: From the user or the spec. A spec that was stored as JSON has a mapping for every dataclass. With a
            `difficulty`, each episode takes place in one of many procedural arenas.
        decisions: Likewise; None for those of the environment's version.
        default: Decisions of the environment's version.

    Raises:
        ValueError: A value in a mapping is not allowed. Whatever is no such mapping is checked by the class.
    """
    given = {name: restored(value) for name, value in kwargs.items()}
    if "difficulty" in given:
        given = _procedural(**given)
    return given | {"decisions": restored(default if decisions is None else decisions)}


def _procedural(
    difficulty: str | Difficulty, split: str = "train", num_levels: int = 200, start_level: int = 0, **others: Any
) -> dict[str, Any]:
    """The arguments of environments in some `ProceduralArenas`: those of the difficulty, unless others are given.

    Raises:
        ValueError: As `ProceduralArenas`; or an arena or a number of food objects is given.
    """
    for name in ("arena", "foods"):
        if name in others:
            raise ValueError(f"{name} is {others[name]!r}; allowed here: none, because difficulty determines it")
    return procedural_settings(difficulty, split, num_levels, start_level) | others


def restored(value: Any) -> Any:
    """An argument as it was before a spec was stored as JSON, which makes mappings and lists of it."""
    if isinstance(value, list):
        return [restored(one) for one in value]
    if isinstance(value, Mapping):
        for kind in _STORED:
            if value.keys() == {field.name for field in fields(kind) if field.init}:
                return kind(**{name: _RESTORE.get(name, restored)(part) for name, part in value.items()})
    return value


def _points(places: Any) -> tuple[Point, ...]:
    return tuple(Point(*place) for place in places)


_STORED: tuple[Any, ...] = (Arena, ProceduralArenas, Difficulty, Noise, Decisions)
_RESTORE: dict[str, Callable[[Any], Any]] = {
    "walls": _points,
    "home": lambda place: Point(*place),
    "start": lambda pose: Pose(*pose),
    "foods": lambda foods: foods if isinstance(foods, int) else _points(foods),
    "obstacles": lambda outlines: tuple(map(_points, outlines)),
    **dict.fromkeys(("length", "width", "notches", "partitions", "blocks"), tuple),
}
"""How attributes of these classes are restored, where a list of them was a tuple."""


behaviours = EntryPoint(BehavioursEnv, Decisions.v0_1())
wheels = EntryPoint(WheelsEnv, Decisions.v0_1())
behaviours_vector = VectorEntryPoint("BehavioursVectorEnv", Decisions.v0_1())
wheels_vector = VectorEntryPoint("WheelsVectorEnv", Decisions.v0_1())
"""Of the environments v0. Stored specs contain these names, which therefore stay without a version."""

behaviours_v1 = EntryPoint(BehavioursEnv, DEFAULT_DECISIONS)
wheels_v1 = EntryPoint(WheelsEnv, DEFAULT_DECISIONS)
behaviours_vector_v1 = VectorEntryPoint("BehavioursVectorEnv", DEFAULT_DECISIONS)
wheels_vector_v1 = VectorEntryPoint("WheelsVectorEnv", DEFAULT_DECISIONS)
