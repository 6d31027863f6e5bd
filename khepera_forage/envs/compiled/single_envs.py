"""The recall environments on the backend "compiled": `gym.make(..., backend="compiled")`."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from khepera_forage.envs.arguments import motor_action
from khepera_forage.envs.behaviours_env import BehavioursEnv, observation_of
from khepera_forage.envs.compiled.records import SHOWN, VECTOR
from khepera_forage.envs.compiled.single import CompiledRecallEnv
from khepera_forage.envs.recall import Observation, RecallEnv
from khepera_forage.envs.wheels_env import WheelsEnv
from khepera_forage.task.states import BEHAVIOURS, NUM_BEHAVIOURS, behaviour_number

_FOOD_SEEN, _FOOD_X, _FOOD_Y, _FOOD_TYPE, _WALL_DISTANCE, _WALL_BEARING = map(
    SHOWN.index, ("food_seen", "food_x", "food_y", "food_type", "wall_distance", "wall_bearing")
)
"""Where these fields are among those that environments show: reading by number is several times as fast as by name."""


class CompiledBehavioursEnv(CompiledRecallEnv[int]):
    """`BehavioursEnv` on the backend "compiled"."""

    _numbers = 1

    def _like(self, **kwargs: Any) -> RecallEnv[int]:
        return BehavioursEnv(**kwargs)

    def _command(self, action: int, row: NDArray[np.float64]) -> None:
        behaviour = behaviour_number(action, NUM_BEHAVIOURS)
        self._executed = BEHAVIOURS[behaviour]
        row[0, 0] = behaviour

    def _observation(self, task: Sequence[float]) -> Observation:
        return observation_of([int(number) for number in task[: len(VECTOR)]], self.diagonal)


class CompiledWheelsEnv(CompiledRecallEnv[NDArray[np.float64]]):
    """`WheelsEnv` on the backend "compiled"."""

    _numbers = 4

    def _like(self, **kwargs: Any) -> RecallEnv[NDArray[np.float64]]:
        return WheelsEnv(**kwargs)

    def _command(self, action: NDArray[np.float64], row: NDArray[np.float64]) -> None:
        row[0] = motor_action(action)

    def _observation(self, task: Sequence[float]) -> Observation:
        robot = self._robot
        return {
            "proximity": robot["proximity"][:6, 0].astype(np.int64),
            "arm": robot["arm_reading"].astype(np.int64),
            "jaw": robot["jaw_reading"].astype(np.int64),
            "object_presence": np.int64(robot["object_presence"][0] != 0),
            "pose": self._pose.copy(),
            "tracked": np.int64(robot["marker_found"][0]),
            "food_seen": np.int64(task[_FOOD_SEEN]),
            "food": np.array((task[_FOOD_X], task[_FOOD_Y])),
            "food_type": np.int64(task[_FOOD_TYPE]),
            "home": self._home.copy(),
            "wall": np.array((task[_WALL_DISTANCE], task[_WALL_BEARING])),
        }
