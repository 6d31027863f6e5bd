"""What a step of compiled worlds brings, as arrays over worlds, which `rounds.write_results` fills."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray


class Results(NamedTuple):
    """What the last step has brought in every world, one element a world.

    Attributes:
        reward: This and the next six are the fields of `task.episode.Episode`.
        terminated: Likewise.
        truncated: Likewise.
        score: Likewise.
        penalty: Likewise.
        correct: Likewise.
        steps: Likewise.
        delivered: Food brought home that is not poisonous.
        poison_home: Poisonous food brought home.
        state: What the teacher classifies the state vector as.
        pose: x and y in pixels and orientation in degrees, as the camera reports them; shape (worlds, 3).
        object_presence: This and the next four are the state vector, distances in pixels.
        robot_home_distance: Likewise.
        food_type: Likewise.
        arms_height: Likewise.
        robot_food_distance: Likewise.
    """

    reward: NDArray[np.float64]
    terminated: NDArray[np.bool_]
    truncated: NDArray[np.bool_]
    score: NDArray[np.float64]
    penalty: NDArray[np.float64]
    correct: NDArray[np.int64]
    steps: NDArray[np.int64]
    delivered: NDArray[np.int64]
    poison_home: NDArray[np.int64]
    state: NDArray[np.int64]
    pose: NDArray[np.float64]
    object_presence: NDArray[np.int64]
    robot_home_distance: NDArray[np.int64]
    food_type: NDArray[np.int64]
    arms_height: NDArray[np.int64]
    robot_food_distance: NDArray[np.int64]


def empty_results(worlds: int) -> Results:
    """Fresh arrays whose elements mean nothing yet."""

    def whole() -> NDArray[np.int64]:
        return np.empty(worlds, np.int64)

    return Results(
        reward=np.empty(worlds),
        terminated=np.empty(worlds, np.bool_),
        truncated=np.empty(worlds, np.bool_),
        score=np.empty(worlds),
        penalty=np.empty(worlds),
        correct=whole(),
        steps=whole(),
        delivered=whole(),
        poison_home=whole(),
        state=whole(),
        pose=np.empty((worlds, 3)),
        object_presence=whole(),
        robot_home_distance=whole(),
        food_type=whole(),
        arms_height=whole(),
        robot_food_distance=whole(),
    )
