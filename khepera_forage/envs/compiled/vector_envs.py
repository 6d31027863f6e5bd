"""The two kinds of vector environment: behaviours in and state vectors out, or motors in and raw data out."""

from typing import Any

import gymnasium as gym
import numpy as np
from numpy.typing import ArrayLike, NDArray

from khepera_forage.envs.behaviours_env import BehavioursEnv
from khepera_forage.envs.compiled.results import Results
from khepera_forage.envs.compiled.vector_env import Observation, RecallVectorEnv
from khepera_forage.envs.wheels_env import WheelsEnv


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

    def _observation(self, results: Results) -> Observation:
        diagonals = self.batch.diagonals
        return {
            "object_presence": results.object_presence,
            "robot_home_distance": np.minimum(results.robot_home_distance, diagonals)[:, None],
            "food_type": results.food_type,
            "arms_height": results.arms_height[:, None],
            "robot_food_distance": np.minimum(results.robot_food_distance, diagonals)[:, None],
        }


class WheelsVectorEnv(RecallVectorEnv):
    """`WheelsEnv` in many worlds: four numbers a world in, raw data out."""

    def _single(self, **kwargs: Any) -> gym.Env[Any, Any]:
        return WheelsEnv(**kwargs)

    def _checked(self, actions: ArrayLike) -> NDArray[Any]:
        given = np.asarray(actions, np.float64)
        if given.shape != (self.num_envs, 4) or not np.all(np.abs(given) <= 1.0):
            raise ValueError(
                f"actions are {actions!r}; allowed: numbers in -1..1, {self.num_envs} rows of left, right, arm, jaw"
            )
        return given

    def _observation(self, results: Results) -> Observation:
        task, robot = self.batch.task, self.batch.robot
        return {
            "proximity": self.batch.proximity[:, :6].copy(),
            "arm": robot("arm_reading", np.int64)[:, None],
            "jaw": robot("jaw_reading", np.int64)[:, None],
            "object_presence": (robot("object_presence") != 0).astype(np.int64),
            "pose": results.pose.copy(),
            "tracked": robot("marker_found", np.int64),
            "food_seen": task("food_seen", np.int64),
            "food": np.stack((task("food_x"), task("food_y")), axis=1),
            "food_type": task("food_type", np.int64),
            "home": self.batch.homes,
            "wall": np.stack((task("wall_distance"), task("wall_bearing")), axis=1),
        }
