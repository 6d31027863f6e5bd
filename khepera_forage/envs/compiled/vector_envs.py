"""The two kinds of vector environment: behaviours in and state vectors out, or motors in and raw data out."""

from typing import Any

import gymnasium as gym
import numpy as np
from numpy.typing import ArrayLike, NDArray

from khepera_forage.envs.behaviours_env import BehavioursEnv
from khepera_forage.envs.compiled import rows as at
from khepera_forage.envs.compiled.batch import TaskBatch
from khepera_forage.envs.compiled.vector_env import Observation, RecallVectorEnv
from khepera_forage.envs.wheels_env import WheelsEnv
from khepera_forage.robots.khepera import ARM_DOWN, ARM_RAISED, JAW_CLOSED, JAW_OPEN, MAX_SPEED
from khepera_forage.sim.arena import Arena
from khepera_forage.sim.compiled import rows as body

EVERY = slice(None)


class BehavioursVectorEnv(RecallVectorEnv):
    """`BehavioursEnv` in many worlds: one behaviour a world in, state vectors out."""

    def _single(self, arena: Arena | str, foods: int, limit: int) -> gym.Env[Any, Any]:
        return BehavioursEnv(arena=arena, foods=foods, limit=limit)

    def _commands(self, actions: ArrayLike) -> NDArray[np.float64]:
        given = np.asarray(actions)
        if (
            given.shape != (self.num_envs,)
            or given.dtype.kind not in "iu"
            or given.min() < 0
            or given.max() > 9
        ):
            raise ValueError(
                f"actions are {actions!r}; allowed: {self.num_envs} whole numbers from 0 to 9, one behaviour each"
            )
        return given.astype(np.float64)

    def _observation(self) -> Observation:
        rows = (at.PRESENCE, at.HOME_DISTANCE, at.VECTOR_TYPE, at.VECTOR_ARM, at.FOOD_DISTANCE)
        presence, home, food_type, arm, food = (self.batch.task(row, np.int64) for row in rows)
        return {
            "object_presence": presence,
            "robot_home_distance": np.minimum(home, self.batch.diagonal)[:, None],
            "food_type": food_type,
            "arms_height": arm[:, None],
            "robot_food_distance": np.minimum(food, self.batch.diagonal)[:, None],
        }


class WheelsVectorEnv(RecallVectorEnv):
    """`WheelsEnv` in many worlds: four motor values a world in, raw data out."""

    def _single(self, arena: Arena | str, foods: int, limit: int) -> gym.Env[Any, Any]:
        return WheelsEnv(arena=arena, foods=foods, limit=limit)

    def _commands(self, actions: ArrayLike) -> NDArray[np.float64]:
        given = np.asarray(actions, np.float64)
        if given.shape != (self.num_envs, 4) or not np.all(np.abs(given) <= 1.0):
            raise ValueError(
                f"actions are {actions!r}; allowed: numbers in -1..1, {self.num_envs} rows of left, right, arm, jaw"
            )
        return motors_of(given)

    def _observation(self) -> Observation:
        return raw_data_of(self.batch)


def motors_of(actions: NDArray[np.float64]) -> NDArray[np.float64]:
    """Numbers in -1..1 as `Motors`, one row a world; see `WheelsEnv`."""
    motors = np.empty_like(actions)
    motors[:, :2] = actions[:, :2] * MAX_SPEED
    motors[:, 2] = np.rint((ARM_DOWN + ARM_RAISED) / 2 - actions[:, 2] * (ARM_DOWN - ARM_RAISED) / 2)
    motors[:, 3] = np.where(actions[:, 3] > 0, JAW_CLOSED, JAW_OPEN)
    return motors


def raw_data_of(batch: TaskBatch, worlds: NDArray[np.int64] | slice = EVERY) -> Observation:
    """What `WheelsEnv` shows, of some worlds of a batch."""

    def task(row: int) -> NDArray[np.float64]:
        return batch.task(row, np.float64)[worlds]

    def robot(row: int) -> NDArray[np.int64]:
        return batch.body(row, np.int64)[worlds]

    pose = (batch.body(row, np.float64)[worlds] for row in (body.OWN_X, body.OWN_Y, body.OWN_DEGREES))
    seen, food_type = (batch.task(row, np.int64)[worlds] for row in (at.FOOD_SEEN, at.FOOD_TYPE))
    return {
        "proximity": np.stack([robot(body.PROXIMITY + n) for n in range(6)], axis=1),
        "arm": robot(body.ARM_READ)[:, None],
        "jaw": robot(body.JAW_READ)[:, None],
        "object_presence": (robot(body.PRESENT) != 0).astype(np.int64),
        "pose": np.stack(list(pose), axis=1),
        "tracked": robot(body.OWN_FOUND),
        "food_seen": seen,
        "food": np.stack((task(at.FOOD_X), task(at.FOOD_Y)), axis=1),
        "food_type": food_type,
        "home": np.tile(batch.home, (len(seen), 1)),
        "wall": np.stack((task(at.WALL_DISTANCE), task(at.WALL_BEARING)), axis=1),
    }
