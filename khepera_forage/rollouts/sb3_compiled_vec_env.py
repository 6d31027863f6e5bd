"""The batch of worlds as stable-baselines3 takes it: a `VecEnv` and nothing between (extras `baselines` and `fast`)."""

from collections.abc import Iterable
from time import perf_counter
from typing import Any

import numpy as np
from gymnasium import spaces
from gymnasium.error import ResetNeeded
from numpy.typing import NDArray
from stable_baselines3.common.vec_env import VecEnv

from khepera_forage.envs.arguments import FoodOdds, whole_number
from khepera_forage.envs.compiled import rows as at
from khepera_forage.envs.compiled.batch import TaskBatch
from khepera_forage.envs.compiled.vector_envs import EVERY, motors_of, raw_data_of
from khepera_forage.noise import Noise
from khepera_forage.policies.features import (
    BEHAVIOUR_FEATURES,
    WHEELS_FEATURES,
    state_vector_features,
    wheels_features,
)
from khepera_forage.sim.arena import Arena
from khepera_forage.task.scoring import score
from khepera_forage.task.states import Behaviour, StateVector

Floats = NDArray[np.float32]
Indices = int | Iterable[int] | None


class BatchVecEnv(VecEnv):  # type: ignore[misc, unused-ignore]  # untyped where stable-baselines3 is not installed
    """`Corridor-v0` and its kin in many worlds, shown as the features that networks see.

    An episode that ends starts again in the same step. What `VecMonitor` would tell is told here: the info of an ended
    episode has `episode` with its return `r`, its length `l` in rounds and the time `t` since the start, in seconds.
    Beside it stand `terminal_observation`, `TimeLimit.truncated`, `is_success` (whether all food that may be delivered
    was), and the environment's `score`, `correct`, `steps`, `delivered` and `poison_home`.

    World i of a seed is the same whatever the number of worlds, and as in `gym.make_vec`. Arrays and infos are fresh.

    Args:
        num_envs: How many worlds.
        arena: As for the environments; so are the next four.
        foods: Food objects in each world, 1 to 16.
        limit: Rounds after which an episode is truncated.
        noise: The laboratory's troubles.
        food_types: One type, or odds by type.
        wheels: Whether motors are commanded, and not behaviours.
        hold: Rounds that a decision holds; what they bring is added up. An episode that ends in between starts
            again at the end.

    Raises:
        ValueError: An argument out of range.
    """

    def __init__(
        self,
        num_envs: int,
        arena: Arena | str = "corridor",
        foods: int = 1,
        limit: int = 500,
        noise: Noise | None = None,
        food_types: FoodOdds = None,
        *,
        wheels: bool = False,
        hold: int = 1,
    ) -> None:
        self.hold = whole_number("hold", hold, 1)
        self.batch = TaskBatch(num_envs, arena, foods, limit, noise, food_types)
        self._wheels = wheels
        self._own = [{"render_mode": None} for _ in range(self.batch.num_worlds)]
        """Attributes of each world that were set from outside."""
        actions: spaces.Space[Any] = spaces.Discrete(Behaviour.WAIT.value)
        if wheels:
            actions = spaces.Box(-1.0, 1.0, (4,), np.float32)
        width = WHEELS_FEATURES if wheels else BEHAVIOUR_FEATURES
        super().__init__(self.batch.num_worlds, spaces.Box(-np.inf, np.inf, (width,), np.float32), actions)
        self._seed: int | None = int(np.random.SeedSequence().generate_state(1)[0])
        self._commands = np.zeros((self.num_envs, 4) if wheels else self.num_envs)
        self._returns = np.zeros(self.num_envs)
        self._made, self._begun = perf_counter(), False

    def seed(self, seed: int | None = None) -> list[int | None]:
        """Seed the worlds at the next reset.

        Args:
            seed: At least 0; without, at random.
        """
        self._seed = int(np.random.SeedSequence().generate_state(1)[0]) if seed is None else seed
        return [self._seed] * self.num_envs

    def reset(self) -> Floats:
        """Start an episode in every world; places asked for by `set_options` hold for it.

        Raises:
            ValueError: Options that are unknown or place something off the free floor.
        """
        worlds = np.arange(self.num_envs)
        if self._seed is not None:
            self.batch.seed(self._seed, worlds)
        if all(options == self._options[0] for options in self._options):
            self.batch.restart(worlds, self._options[0])
        else:
            for world, options in enumerate(self._options):
                self.batch.restart(worlds[world : world + 1], options)
        self._seed, self._begun = None, True
        self._reset_options()
        self._returns[:] = 0.0
        return self._features()

    def step_async(self, actions: NDArray[Any]) -> None:
        """Take the actions of all worlds.

        Raises:
            ResetNeeded: Before the first reset.
            ValueError: Actions that are not in the action space.
        """
        if not self._begun:
            raise ResetNeeded("the environment was not reset yet; call reset() before anything else")
        given = np.asarray(actions)
        low, high, kinds = (-1, 1, "iuf") if self._wheels else (0, Behaviour.WAIT - 1, "iu")
        form = self._commands.shape
        if (
            given.dtype.kind not in kinds
            or given.shape != form
            or not ((given >= low) & (given <= high)).all()
        ):
            whole = "numbers" if self._wheels else "whole numbers"
            raise ValueError(
                f"actions are {actions!r}; allowed: {whole} from {low} to {high}, of shape {form}"
            )
        commands = given.astype(np.float64)
        self._commands = motors_of(commands) if self._wheels else commands

    def step_wait(self) -> tuple[Floats, Floats, NDArray[np.bool_], list[dict[str, Any]]]:
        """What came of them in all worlds."""
        task, never = self.batch.task, np.zeros(self.num_envs, np.bool_)
        infos: list[dict[str, Any]] = [{} for _ in range(self.num_envs)]
        rewards, ended = np.zeros(self.num_envs), never
        for _ in range(self.hold):
            # A world whose episode is over goes on, unheeded, until the others are ready too.
            self.batch.step(self._commands, never)
            rewards += np.where(ended, 0.0, task(at.REWARD))
            over = ~ended & ((task(at.TERMINATED) != 0) | (task(at.TRUNCATED) != 0))
            if over.any():
                self._tell(np.flatnonzero(over), infos)
                ended = ended | over
        self._returns += rewards
        if ended.any():
            now = perf_counter() - self._made
            worlds = np.flatnonzero(ended)
            for world, result in zip(worlds.tolist(), self._returns[worlds].tolist(), strict=True):
                infos[world]["episode"] = {"r": result, "l": infos[world]["steps"], "t": now}
            self.batch.restart(worlds)
            self._returns[worlds] = 0.0
        return self._features(), rewards.astype(np.float32), ended, infos

    def _tell(self, worlds: NDArray[np.int64], infos: list[dict[str, Any]]) -> None:
        """Fill in the infos of worlds whose episode has just ended."""
        rows = (at.CORRECT, at.STEPS, at.DELIVERED, at.DELIVERABLE, at.POISON_HOME, at.TRUNCATED)
        counts = np.stack([self.batch.task(row)[worlds] for row in rows], axis=1).astype(np.int64).tolist()
        shown = self._features(worlds)
        for world, last, (correct, steps, delivered, deliverable, poison, truncated) in zip(
            worlds.tolist(), shown, counts, strict=True
        ):
            infos[world].update(
                {
                    "terminal_observation": last,
                    "TimeLimit.truncated": bool(truncated),
                    "is_success": delivered == deliverable,
                    "score": score(correct, steps, delivered, deliverable),
                    "correct": correct,
                    "steps": steps,
                    "delivered": delivered,
                    "poison_home": poison,
                }
            )

    def _features(self, worlds: NDArray[np.int64] | slice = EVERY) -> Floats:
        if not self._wheels:
            vectors = np.stack(
                [self.batch.task(at.VECTOR + n)[worlds] for n in range(len(StateVector._fields))], axis=1
            )
            vectors[:, 1::3] = np.minimum(vectors[:, 1::3], self.batch.diagonal)
            return state_vector_features(vectors)
        return wheels_features(raw_data_of(self.batch, worlds))

    def close(self) -> None:
        """Nothing is open."""

    def get_attr(self, attr_name: str, indices: Indices = None) -> list[Any]:
        """An attribute of each world: one that was set, or what all have in common, such as `limit` and `arena`.

        Raises:
            AttributeError: There is no such attribute.
        """
        own = [self._own[world] for world in self._chosen(indices)]
        return [mine[attr_name] if attr_name in mine else getattr(self.batch, attr_name) for mine in own]

    def set_attr(self, attr_name: str, value: Any, indices: Indices = None) -> None:
        """Note something beside worlds.

        Raises:
            AttributeError: The name is that of what all worlds have in common and were made with.
        """
        if hasattr(self.batch, attr_name):
            raise AttributeError(f"{attr_name!r} is the same in all worlds, and fixed when they are made")
        for world in self._chosen(indices):
            self._own[world][attr_name] = value

    def env_method(self, method_name: str, *args: Any, indices: Indices = None, **kwargs: Any) -> list[Any]:
        """Not possible: worlds of a batch are not objects of their own.

        Raises:
            AttributeError: Always.
        """
        raise AttributeError(f"worlds of a batch have no method {method_name!r}, nor any other")

    def env_is_wrapped(self, wrapper_class: Any, indices: Indices = None) -> list[bool]:
        """No world is wrapped in anything, and none needs to be in `Monitor`."""
        return [False] * len(self._chosen(indices))

    def _chosen(self, indices: Indices) -> list[int]:
        return list(self._get_indices(indices))
