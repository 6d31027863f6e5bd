"""The recall environments on the backend "compiled": `gym.make(..., backend="compiled")`."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from khepera_forage.envs.arguments import motor_action
from khepera_forage.envs.behaviours_env import BehavioursEnv
from khepera_forage.envs.compiled.records import TASK, VECTOR
from khepera_forage.envs.compiled.single import CompiledRecallEnv
from khepera_forage.envs.recall import Observation, RecallEnv
from khepera_forage.envs.wheels_env import WheelsEnv
from khepera_forage.task.states import BEHAVIOURS, NUM_BEHAVIOURS, behaviour_number

_FOOD_SEEN, _FOOD_X, _FOOD_Y, _FOOD_TYPE, _WALL_DISTANCE, _WALL_BEARING = map(
    TASK.index, ("food_seen", "food_x", "food_y", "food_type", "wall_distance", "wall_bearing")
)
_VECTOR = slice(TASK.index(VECTOR[0]), TASK.index(VECTOR[-1]) + 1)
"""Where these fields are in the task's record: reading by number is several times as fast as by name."""


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
        presence, home, food_type, arm, food = task[_VECTOR]
        diagonal = self.diagonal
        return {
            "object_presence": np.int64(presence),
            "robot_home_distance": np.array((int(home if home < diagonal else diagonal),)),
            "food_type": np.int64(food_type),
            "arms_height": np.array((int(arm),)),
            "robot_food_distance": np.array((int(food if food < diagonal else diagonal),)),
        }


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
