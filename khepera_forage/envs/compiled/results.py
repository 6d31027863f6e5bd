"""What a step brings, as arrays over worlds: kernels write them while the records of a block are in the cache."""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from khepera_forage.compilation.decorators import entrance, kernel
from khepera_forage.envs.compiled.worlds import Worlds, worlds_of


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


@kernel
def write_results(results: Any, worlds: Worlds, block: int) -> None:
    """Write the results of one block.

    Args:
        results: `Results` of all worlds.
        worlds: The records of the block.
        block: Its number.
    """
    robot, task = worlds.bodies.robots, worlds.tasks
    lanes = robot.x.shape[0]
    first = block * lanes
    for i in range(min(lanes, results.reward.shape[0] - first)):
        world, episode, tracker = first + i, worlds.episodes[i], worlds.trackers[i]
        results.reward[world] = episode.reward
        results.terminated[world], results.truncated[world] = episode.terminated, episode.truncated
        results.score[world], results.penalty[world] = episode.score, episode.penalty
        results.correct[world], results.steps[world] = episode.correct, episode.steps
        results.delivered[world], results.poison_home[world] = tracker.delivered, tracker.poison_home
        results.state[world] = int(task.state[i])
        results.pose[world, 0], results.pose[world, 1] = robot.marker_x[i], robot.marker_y[i]
        results.pose[world, 2] = robot.marker_heading[i]
        results.object_presence[world] = int(task.object_presence[i])
        results.robot_home_distance[world] = int(task.robot_home_distance[i])
        results.food_type[world] = int(task.vector_food_type[i])
        results.arms_height[world] = int(task.arms_height[i])
        results.robot_food_distance[world] = int(task.robot_food_distance[i])


@entrance
def read_results(results: Results, worlds: Worlds) -> None:
    """Write the results of all blocks, without a step."""
    for block in range(worlds.tasks.shape[0]):
        write_results(results, worlds_of(worlds, block, 0), block)
