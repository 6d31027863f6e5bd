"""Vector environments side by side as one, for worlds that differ in more than their arena."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from gymnasium.vector import VectorEnv
from gymnasium.vector.utils import batch_space
from numpy.typing import NDArray

from khepera_forage.envs.compiled.vector_env import BehavioursVectorEnv

Arrays = dict[str, Any]
"""Observations or infos of a vector environment: arrays with one element a world, infos also dicts of them."""


class JoinedVectorEnv(VectorEnv):
    """The worlds of several vector environments, in their order; so are observations, rewards, ends and infos.

    A compiled vector environment has one number of food objects, one step limit, one noise and one set of food types.
    Procedural arenas of several difficulties need several of them.

    Args:
        parts: All with the same `AutoresetMode`.
    """

    def __init__(self, parts: Sequence[BehavioursVectorEnv]) -> None:
        self.parts = list(parts)
        self._sizes = [part.num_envs for part in parts]
        self._starts = np.cumsum([0, *self._sizes[:-1]])
        self._shown: list[Arrays] = [{} for _ in parts]
        self.num_envs = sum(self._sizes)
        self.metadata, self.render_mode = dict(parts[0].metadata), None
        # Distances have the bounds of the largest arena.
        largest = max(parts, key=_largest_distance)
        self.single_observation_space = largest.single_observation_space
        self.single_action_space = largest.single_action_space
        self.observation_space = batch_space(self.single_observation_space, self.num_envs)
        self.action_space = batch_space(self.single_action_space, self.num_envs)

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Arrays, Arrays]:
        """Begin new episodes in all worlds, or in those of `options["reset_mask"]`.

        Args:
            seed: World i has the episodes of a single environment with seed + i.
            options: As for the parts.
        """
        options = dict(options or {})
        mask = options.pop("reset_mask", None)
        infos: list[Arrays] = [{} for _ in self.parts]
        for number, (part, start) in enumerate(zip(self.parts, self._starts.tolist(), strict=True)):
            if mask is not None:
                options["reset_mask"] = own = mask[start : start + part.num_envs]
                if not own.any():
                    continue
            first = None if seed is None else seed + start
            self._shown[number], infos[number] = part.reset(seed=first, options=options)
        return _joined(self._shown, self._sizes), _joined(infos, self._sizes)

    def step(
        self, actions: NDArray[np.int64]
    ) -> tuple[Arrays, NDArray[np.float64], NDArray[np.bool_], NDArray[np.bool_], Arrays]:
        """One round in every world."""
        shares = np.split(np.asarray(actions), self._starts[1:])
        done = [part.step(own) for part, own in zip(self.parts, shares, strict=True)]
        self._shown, rewards, terminated, truncated, infos = (
            list(column) for column in zip(*done, strict=True)
        )
        ends = np.concatenate(terminated), np.concatenate(truncated)
        shown = _joined(self._shown, self._sizes)
        return shown, np.concatenate(rewards), *ends, _joined(infos, self._sizes)

    def close_extras(self, **kwargs: Any) -> None:
        """Close all parts."""
        for part in self.parts:
            part.close(**kwargs)


def _largest_distance(env: BehavioursVectorEnv) -> int:
    """The bound of distances in pixels."""
    space: Any = env.single_observation_space
    return int(space["robot_home_distance"].high[0])


def _joined(parts: Sequence[Mapping[str, Any]], sizes: Sequence[int]) -> Arrays:
    """Arrays of all worlds; zeros, and None among objects, where a part has no such array."""
    found: Arrays = {}
    for name in dict.fromkeys(name for part in parts for name in part):
        known = next(part[name] for part in parts if name in part)
        if isinstance(known, Mapping):
            found[name] = _joined([part.get(name, {}) for part in parts], sizes)
            continue
        nothing = None if known.dtype == object else 0
        found[name] = np.concatenate(
            [
                part[name] if name in part else np.full((size, *known.shape[1:]), nothing, known.dtype)
                for part, size in zip(parts, sizes, strict=True)
            ]
        )
    return found
