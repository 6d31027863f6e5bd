"""A redesigned state vector, and a learner with it."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np

from further_experiments.observed_training import Moment
from khepera_forage.geometry.plane import length
from khepera_forage.policies import NearestNeighbourImitator, Observation
from khepera_forage.robots.khepera import FINGER_TIP
from khepera_forage.task.perception import RawData
from khepera_forage.task.states import Behaviour, StateVector
from khepera_forage.vision.scene import MM_PER_PIXEL

SCALE = 1000
"""The whole range of AtHome and FoodNearness, in integer steps, so that ties are exact."""
REACH = FINGER_TIP / MM_PER_PIXEL
"""Pixels from the robot's centre to its finger tips: the unit of length for nearness."""


def at_home(raw: RawData) -> bool:
    """Whether the robot is within the radius of its home, which is given from the beginning (4.2.2)."""
    return length(raw.x - raw.home_x, raw.y - raw.home_y) <= raw.home_radius


def food_nearness(raw: RawData) -> float:
    """Nearness of the food: 1 in the gripper, one half at the finger tips, 0 if there is none."""
    if raw.object_presence:
        return 1.0
    if not raw.food_seen:
        return 0.0
    return REACH / (REACH + length(raw.x - raw.food_x, raw.y - raw.food_y))


def redesigned(raw: RawData) -> StateVector:
    """ObjectPresence, AtHome, FoodType, ArmsHeight and FoodNearness, in the places of the five attributes of 4.3.

    With `SCALE` as the diagonal, the distances of 4.6.1 are: 1 each if ObjectPresence, AtHome or FoodType differ, the
    difference of ArmsHeight divided by 55, and the difference of FoodNearness.
    """
    return StateVector(
        1 if raw.object_presence else 0,
        SCALE * at_home(raw),
        raw.food_type,
        raw.arm,
        round(SCALE * food_nearness(raw)),
    )


@dataclass(frozen=True, slots=True)
class RedesignedImitator:
    """The thesis's learner with the redesigned state vector.

    Attributes:
        imitator: Trained with redesigned vectors.
        raw: Returns the robot's present raw data.
    """

    imitator: NearestNeighbourImitator
    raw: Callable[[], RawData]

    @classmethod
    def trained(cls, episodes: Sequence[Sequence[Moment]], raw: Callable[[], RawData]) -> Self:
        """The learner of some training episodes."""
        moments = [moment for episode in episodes for moment in episode]
        vectors = [redesigned(moment.raw) for moment in moments]
        heard = [int(moment.heard) for moment in moments]
        return cls(NearestNeighbourImitator(diagonal=SCALE).fit(np.array(vectors), np.array(heard)), raw)

    def act(self, observation: Observation, rng: np.random.Generator | None = None) -> Behaviour:
        """A behaviour, drawn with its confidence level.

        Args:
            observation: The thesis's state vector; not used.
            rng: Must be given.
        """
        return self.imitator.act(redesigned(self.raw()), rng)
