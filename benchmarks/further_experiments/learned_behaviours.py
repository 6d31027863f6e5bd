"""Learned behaviours: a regression from raw data to motors for each behaviour (action level, 4.8)."""

from collections.abc import Sequence
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray
from sklearn.ensemble import ExtraTreesRegressor

from khepera_forage.geometry.plane import bearing_of, length, turn_to
from khepera_forage.robots.khepera import ARM_DOWN, ARM_RAISED, JAW_CLOSED, JAW_OPEN, Motors
from khepera_forage.task.behaviours import wait
from khepera_forage.task.perception import RawData

RELATIONS = 17
TREES = 10
"""Of each ensemble."""
_ARM_HALF, _JAW_HALF = (ARM_DOWN + ARM_RAISED) / 2, (JAW_OPEN + JAW_CLOSED) / 2


def relations(raw: RawData) -> tuple[float, ...]:
    """Raw data relative to the robot, independent of the arena: distances as in section 4.3, and bearings.

    The 17 numbers are the six infra-reds, arm, jaw, object presence, whether food is seen, distance (pixels) and
    bearing (degrees) of food, home and nearest wall (those of food 0 if none is seen), and the type of the food.
    """
    food = bearing_of_food = 0.0
    if raw.food_seen:
        food = length(raw.food_x - raw.x, raw.food_y - raw.y)
        bearing_of_food = _bearing(raw, raw.food_x, raw.food_y)
    return (
        *raw.proximity,
        raw.arm,
        raw.jaw,
        raw.object_presence,
        raw.food_seen,
        food,
        bearing_of_food,
        length(raw.home_x - raw.x, raw.home_y - raw.y),
        _bearing(raw, raw.home_x, raw.home_y),
        raw.wall_distance,
        raw.wall_bearing,
        raw.food_type,
    )


def _bearing(raw: RawData, x: float, y: float) -> float:
    return turn_to(bearing_of(x - raw.x, y - raw.y), raw.orientation)


class LearnedBehaviours:
    """Motor commands of behaviours, learned from examples; replaces `task.behaviours.command`.

    For every behaviour an ensemble of scikit-learn's extremely randomised trees predicts wheels, arm and jaw from
    `relations`. Wheel speeds are the mean of the trees. Arm and jaw have two positions each; the majority of the trees
    decides, and a draw means raised and closed. A behaviour without examples stands still and keeps arm and jaw.

    Args:
        random_state: Seed of their splits.
    """

    def __init__(self, random_state: int = 0) -> None:
        self.random_state = random_state
        self._ensembles: dict[int, list[Any]] = {}

    def fit(self, raws: Sequence[RawData], behaviours: Sequence[int], motors: Sequence[Motors]) -> Self:
        """Learn from steps, forgetting earlier ones: what the robot perceived before each, and what it did."""
        rows = np.array([relations(raw) for raw in raws], np.float32).reshape(-1, RELATIONS)
        commands = np.array(motors, np.float64).reshape(-1, len(Motors._fields))
        labels = np.array(behaviours, np.int64)
        self._ensembles = {}
        for behaviour in np.unique(labels).tolist():
            own = labels == behaviour
            forest = ExtraTreesRegressor(TREES, random_state=self.random_state).fit(rows[own], commands[own])
            self._ensembles[behaviour] = [estimator.tree_ for estimator in forest.estimators_]
        return self

    def command(self, behaviour: int, raw: RawData) -> Motors:
        """Motors for one step of a behaviour, from what the robot perceives now."""
        ensemble = self._ensembles.get(int(behaviour))
        if ensemble is None:
            return wait(raw)
        row = np.array([relations(raw)], np.float32)
        # The trees themselves are thirty times as fast as `predict`, which validates its input.
        predicted: NDArray[np.float64] = np.concatenate([tree.predict(row)[..., 0] for tree in ensemble])
        left, right = predicted[:, :2].mean(axis=0).tolist()
        arm = ARM_DOWN if 2 * (predicted[:, 2] > _ARM_HALF).sum() > len(predicted) else ARM_RAISED
        jaw = JAW_OPEN if 2 * (predicted[:, 3] > _JAW_HALF).sum() > len(predicted) else JAW_CLOSED
        return Motors(left, right, arm, jaw)
