"""`Corridor-v1` and the other recall environments, thousands at a time, as one `gymnasium.vector.VectorEnv`."""

from abc import abstractmethod
from collections.abc import Callable
from typing import Any

import gymnasium as gym
import numpy as np
from gymnasium.envs.registration import EnvSpec
from gymnasium.error import ResetNeeded
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space
from numpy.typing import ArrayLike, NDArray

from khepera_forage.envs.arguments import COMPILED, Arenas, FoodOdds, Settings, whole_number
from khepera_forage.envs.backends import check_compiled
from khepera_forage.envs.behaviours_env import BehavioursEnv
from khepera_forage.envs.compiled.batch import CompiledBatch, bodies_of, forager_of
from khepera_forage.envs.layouts import checked_options
from khepera_forage.envs.recall import episode_info
from khepera_forage.envs.rendering import Screen, View, recall_view
from khepera_forage.envs.wheels_env import WheelsEnv, raw_data_of
from khepera_forage.noise import Noise
from khepera_forage.policies.teacher import APPLICABLE
from khepera_forage.robots.model import KHEPERA
from khepera_forage.sim.arena import Arena
from khepera_forage.task.arena_map import whole_pixels
from khepera_forage.task.decisions import Decisions
from khepera_forage.task.states import StateVector

Observation = dict[str, NDArray[Any]]
Infos = dict[str, Any]


_DRAWN = 16
"""Worlds of which `render` draws pictures."""


class RecallVectorEnv(VectorEnv):
    """Recalls in many worlds at once; spaces, rewards, ends and infos are those of the environment it stands for.

    World i of a seed is the same whatever the number of worlds. Every array that is returned is fresh. Arguments that
    are not listed are those of the single environment.

    Args:
        num_envs: How many worlds.
        autoreset_mode: An `AutoresetMode`, or its value: what happens where an episode has ended. By default the next
            step begins a new one.
        render_mode: None, or "rgb_array": `render` then returns pictures.
        backend: Must be "compiled"; `vectorization_mode="sync"` makes worlds of pymunk.
        max_episode_steps: Truncates episodes without another effect, as Gymnasium's `TimeLimit` does; none by default.

    Raises:
        ValueError: An argument out of range.
    """

    backend = COMPILED
    _spec: EnvSpec | None = None

    def __init__(
        self,
        num_envs: int = 1,
        arena: Arenas = "corridor",
        foods: int = 1,
        limit: int = 500,
        noise: Noise | str | None = "laboratory",
        food_types: FoodOdds = None,
        autoreset_mode: AutoresetMode | str = AutoresetMode.NEXT_STEP,
        render_mode: str | None = None,
        decisions: Decisions | None = None,
        backend: str = COMPILED,
        max_episode_steps: int | None = None,
        robot: str = KHEPERA.name,
    ) -> None:
        check_compiled(backend)
        if render_mode not in (None, "rgb_array"):
            raise ValueError(f"render_mode is {render_mode!r}; allowed for a batch: None, 'rgb_array'")
        self.num_envs = whole_number("num_envs", num_envs, 1)
        settings = Settings.of(arena, noise, food_types, decisions, robot)
        self.batch = CompiledBatch(self.num_envs, settings, foods, limit)
        modes = [mode.value for mode in AutoresetMode]
        if autoreset_mode not in (*modes, *AutoresetMode):
            raise ValueError(
                f"autoreset_mode is {autoreset_mode!r}; allowed: AutoresetMode, or {', '.join(map(repr, modes))}"
            )
        self.autoreset_mode = AutoresetMode(autoreset_mode)
        duration = settings.decisions.round_duration
        self.metadata = {
            "autoreset_mode": self.autoreset_mode,
            "render_modes": ["rgb_array"],
            "render_fps": 1 / duration,
        }
        self.render_mode = render_mode
        self._screen = Screen(render_mode, duration)
        single = self._single(arena=arena, foods=foods, limit=limit, decisions=decisions, backend=COMPILED)
        self.single_observation_space, self.single_action_space = (single.observation_space, single.action_space)
        self.observation_space = batch_space(self.single_observation_space, self.num_envs)
        self.action_space = batch_space(self.single_action_space, self.num_envs)
        longest = -1 if max_episode_steps is None else max_episode_steps
        self._longest = None if longest == -1 else whole_number("max_episode_steps", longest, 1)
        self._over = np.ones(self.num_envs, np.bool_)
        self._seeded = False
        self._generator: np.random.Generator | None = None
        """The `np_random` that the worlds were seeded from."""

    def reset(
        self, *, seed: int | list[int | None] | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observation, Infos]:
        """Begin new episodes in all worlds, or in those of `options["reset_mask"]`.

        Args:
            seed: World i has the episodes of a single environment with seed + i, as in Gymnasium's own vector
                environments; or one seed a world. Without a seed, worlds go on with their random numbers; at the
                first reset, and after `np_random` was set, they are seeded by that.
            options: `reset_mask`, one bool a world; `start` and `foods` as for the single environment.

        Raises:
            ValueError: A seed or an option out of range, or an arena with no room. The present episodes then go on.
            ResetNeeded: A mask before the first reset.
        """
        options = checked_options(options)
        mask = self._mask(options.pop("reset_mask", None))
        worlds = np.flatnonzero(mask)
        given: dict[int, int] = {}
        if isinstance(seed, list):
            if len(seed) != self.num_envs:
                raise ValueError(f"{len(seed)} seeds for {self.num_envs} worlds; allowed: one each")
            given = {world: whole_number("seed", s, 0) for world in worlds.tolist() if (s := seed[world]) is not None}
        elif seed is not None:
            super().reset(seed=seed)
            self._generator = self.np_random
            given = {world: seed + world for world in worlds.tolist()}
        if self.np_random is not self._generator:
            self._generator = self.np_random
            first = int(self.np_random.integers(2**62))
            self.batch.seed({world: first + world for world in worlds.tolist()})
        self.batch.seed(given)
        self.batch.restart(worlds, options)
        self._seeded, self._over[worlds] = True, False
        return self._observation(), self._infos(mask)

    def step(
        self, actions: ArrayLike
    ) -> tuple[Observation, NDArray[np.float64], NDArray[np.bool_], NDArray[np.bool_], Infos]:
        """One round in every world.

        Raises:
            ResetNeeded: Before the first reset; with autoreset disabled also where an episode has ended.
            ValueError: Actions that are not in the action space; or an arena has no room for a new episode, and all
                worlds need a reset.
        """
        self._require_first_reset()
        if self.autoreset_mode == AutoresetMode.DISABLED and self._over.any():
            raise ResetNeeded(
                f"the episode of world {np.flatnonzero(self._over)[0]} has ended; call "
                "reset(options={'reset_mask': terminations | truncations})"
            )
        checked, self._seeded = self._checked(actions), False
        shown = self._step(checked)
        self._seeded = True
        return shown

    def _step(self, actions: NDArray[Any]) -> tuple[Any, ...]:
        self.batch.step(actions, self._over)
        episode = self.batch.foragers.episode
        rewards, terminated, truncated = (
            np.array(getattr(episode, name)) for name in ("reward", "terminated", "truncated")
        )
        if self._longest is not None:
            truncated |= episode.steps >= self._longest
        self._over = over = terminated | truncated
        observation, every = self._observation(), np.ones(self.num_envs, np.bool_)
        if self.autoreset_mode != AutoresetMode.SAME_STEP or not over.any():
            return observation, rewards, terminated, truncated, self._infos(every)
        final_infos, worlds = self._infos(over), np.flatnonzero(over)
        self.batch.restart(worlds)
        self._over = ~every
        single = np.full(self.num_envs, None, dtype=object)
        for world in worlds.tolist():
            single[world] = {name: values[world] for name, values in observation.items()}
        infos = self._infos(every) | {"final_obs": single, "_final_obs": over}
        infos |= {"final_info": final_infos, "_final_info": over.copy()}
        return self._observation(), rewards, terminated, truncated, infos

    def render(self) -> tuple[NDArray[np.uint8], ...] | None:
        """A picture of each world; None without a `render_mode`, with a warning.

        A picture takes about 10 ms. Only the first 16 worlds are drawn, and the pictures of the others are black.
        Gymnasium's `RecordVideo` tiles all of them: with more than a few worlds, use its `record_first_only=True`.

        Raises:
            ResetNeeded: Before the first reset.
        """
        self._require_first_reset()
        first = self._picture(0)
        if first is None:
            return None
        drawn = [first, *map(self._picture, range(1, min(self.num_envs, _DRAWN)))]
        return (*drawn, *[np.zeros_like(first)] * (self.num_envs - len(drawn)))  # type: ignore[arg-type]

    @property
    def spec(self) -> EnvSpec | None:
        """What `gym.make_vec` made the environment of."""
        return self._spec

    @spec.setter
    def spec(self, spec: EnvSpec | None) -> None:
        self._spec = spec
        if spec is not None and "autoreset_mode" in spec.kwargs:
            spec.kwargs["autoreset_mode"] = self.autoreset_mode.value  # which JSON can store

    def _picture(self, world: int) -> NDArray[np.uint8] | None:
        return self._screen.show(lambda: self.view(world))

    def view(self, world: int) -> View:
        """What a picture of one world shows."""
        batch = self.batch
        records, arena = batch.world(world), batch.arenas[world]
        bodies = bodies_of(records, arena, batch.settings)
        forager = forager_of(records, arena, batch.settings.decisions)
        return recall_view(arena, bodies, forager, batch.limit)

    def get_attr(self, name: str) -> tuple[Any, ...]:
        """An attribute of the single environment, one value a world; see `call`."""
        return self.call(name)

    def call(self, name: str) -> tuple[Any, ...]:
        """What an attribute or a method of the single environment would give, one value a world.

        Raises:
            AttributeError: A batch of compiled worlds does not know it.
        """
        of_arenas: dict[str, Callable[[Arena], Any]] = {
            "arena": lambda arena: arena,
            "home_radius": lambda arena: whole_pixels(arena.home_radius),
            "diagonal": lambda arena: whole_pixels(arena.diagonal),
        }
        of_all = {
            "action_space": self.single_action_space,
            "observation_space": self.single_observation_space,
            **{name: getattr(self.batch, name) for name in ("foods", "limit", "largest_diagonal")},
            "decisions": self.batch.settings.decisions,
            **{name: getattr(self, name) for name in ("backend", "metadata", "render_mode", "spec")},
        }
        if name in of_arenas:
            return tuple(map(of_arenas[name], self.batch.arenas))
        if name not in of_all:
            known = ", ".join([*of_arenas, *of_all])
            raise AttributeError(f"compiled worlds have no {name!r}; allowed: {known}, and action_masks of behaviours")
        return (of_all[name],) * self.num_envs

    @abstractmethod
    def _single(self, **kwargs: Any) -> gym.Env[Any, Any]:
        """The environment that this stands for."""

    @abstractmethod
    def _checked(self, actions: ArrayLike) -> NDArray[Any]:
        """Actions as `CompiledBatch.step` takes them.

        Raises:
            ValueError: Actions that are not in the action space.
        """

    @abstractmethod
    def _observation(self) -> Observation:
        """What the policy gets to know, in fresh arrays."""

    def _require_first_reset(self) -> None:
        if not self._seeded:
            raise ResetNeeded("no episode is under way; call reset() before anything else")

    def _mask(self, mask: Any) -> NDArray[np.bool_]:
        if mask is None:
            return np.ones(self.num_envs, np.bool_)
        if not self._seeded:
            raise ResetNeeded("a reset_mask before the first reset(); the first must be of all worlds")
        form = (self.num_envs,), np.dtype(np.bool_)
        if not isinstance(mask, np.ndarray) or (mask.shape, mask.dtype) != form or not mask.any():
            raise ValueError(
                f"reset_mask is {mask!r}; allowed: an array of {self.num_envs} bools, at least one of them True"
            )
        return mask

    def _infos(self, mask: NDArray[np.bool_]) -> Infos:
        """The infos of the single environment in Gymnasium's vector form, of the worlds of a mask."""
        infos = {name: values.copy() for name, values in episode_info(self.batch.foragers).items()}
        if not mask.all():
            for values in infos.values():
                values[~mask] = 0
        return infos | {f"_{name}": mask.copy() for name in infos}


class BehavioursVectorEnv(RecallVectorEnv):
    """`BehavioursEnv` in many worlds: one behaviour a world in, state vectors out."""

    def _single(self, **kwargs: Any) -> gym.Env[Any, Any]:
        return BehavioursEnv(**kwargs)

    def _checked(self, actions: ArrayLike) -> NDArray[Any]:
        given, count = np.asarray(actions), int(self.single_action_space.n)  # type: ignore[attr-defined]
        fine = given.shape == (self.num_envs,) and given.dtype.kind in "iu"
        if not fine or given.min() < 0 or given.max() >= count:
            raise ValueError(
                f"actions are {actions!r}; allowed: {self.num_envs} whole numbers from 0 to {count - 1}, one "
                "behaviour each"
            )
        return given

    def action_masks(self) -> NDArray[np.bool_]:
        """Which behaviours apply now, one row a world; see `BehavioursEnv.action_masks`.

        Raises:
            ResetNeeded: Before the first reset.
        """
        self._require_first_reset()
        vector = self.batch.foragers.vector
        masks: NDArray[np.bool_] = APPLICABLE[vector.object_presence, vector.food_type]
        return masks

    def call(self, name: str) -> tuple[Any, ...]:  # noqa: D102 (that of the class above)
        return tuple(self.action_masks()) if name == "action_masks" else super().call(name)

    def _observation(self) -> Observation:
        vector = self.batch.foragers.vector
        observation = {name: getattr(vector, name).copy() for name in StateVector._fields}
        for name in ("robot_home_distance", "arms_height", "robot_food_distance"):
            observation[name] = observation[name][:, None]
        return observation


class WheelsVectorEnv(RecallVectorEnv):
    """`WheelsEnv` in many worlds: four numbers a world in, raw data out."""

    def _single(self, **kwargs: Any) -> gym.Env[Any, Any]:
        return WheelsEnv(**kwargs)

    def _checked(self, actions: ArrayLike) -> NDArray[np.float64]:
        given = np.ascontiguousarray(actions, np.float64)
        if given.shape != (self.num_envs, 4) or not np.all(np.abs(given) <= 1.0):
            raise ValueError(
                f"actions are {actions!r}; allowed: numbers in -1..1, {self.num_envs} rows of left, right, arm, jaw"
            )
        return given

    def _observation(self) -> Observation:
        return raw_data_of(self.batch.raw)
