"""Another prototype of the state vector, argued from where the thesis' own fails, and a learner with it."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np

from _further_work.witness import Moment
from khepera_forage.geometry.angles import length
from khepera_forage.policies import NearestNeighbourImitator, Observation
from khepera_forage.robots.khepera import FINGER_TIP
from khepera_forage.task.perception import RawData
from khepera_forage.task.states import Behaviour, StateVector
from khepera_forage.vision.scene import MM_PER_PIXEL

FULL = 1000
"""The whole range of AtHome and FoodNearness, in whole steps, so that ties are exact."""
REACH = FINGER_TIP / MM_PER_PIXEL
"""Pixels from the robot's centre to its finger tips: the length by which nearness is measured."""


def at_home(raw: RawData) -> bool:
    """Whether the robot is within the radius of its home, which it knows from the beginning (4.2.2)."""
    return length(raw.x - raw.home_x, raw.y - raw.home_y) <= raw.home_radius


def food_nearness(raw: RawData) -> float:
    """How near the food to be fetched is: 1 in the gripper, one half at its finger tips, 0 if there is none."""
    if raw.object_presence:
        return 1.0
    if not raw.food_seen:
        return 0.0
    return REACH / (REACH + length(raw.x - raw.food_x, raw.y - raw.food_y))


def redesigned(raw: RawData) -> StateVector:
    """ObjectPresence, AtHome, FoodType, ArmsHeight and FoodNearness, in the places of the five attributes of 4.3.

    With `FULL` for the diagonal the distances of 4.6.1 are then: 1 each if ObjectPresence, AtHome or FoodType differ,
    the difference of ArmsHeight by 55, and that of FoodNearness.
    """
    return StateVector(
        1 if raw.object_presence else 0,
        FULL * at_home(raw),
        raw.food_type,
        raw.arm,
        round(FULL * food_nearness(raw)),
    )


@dataclass(frozen=True, slots=True)
class RedesignedImitator:
    """The thesis' learner with the other prototype.

    Attributes:
        imitator: Taught with redesigned vectors.
        raw: What the robot perceives now.
    """

    imitator: NearestNeighbourImitator
    raw: Callable[[], RawData]

    @classmethod
    def taught(cls, lessons: Sequence[Sequence[Moment]], raw: Callable[[], RawData]) -> Self:
        """By what was perceived and heard in these lessons."""
        moments = [moment for lesson in lessons for moment in lesson]
        vectors = [redesigned(moment.raw) for moment in moments]
        heard = [int(moment.heard) for moment in moments]
        return cls(NearestNeighbourImitator(diagonal=FULL).fit(np.array(vectors), np.array(heard)), raw)

    def act(self, observation: Observation, rng: np.random.Generator | None = None) -> Behaviour:
        """A behaviour, drawn with its confidence level.

        Args:
            observation: Not used: the thesis' state vector.
            rng: Must be given.
        """
        return self.imitator.act(redesigned(self.raw()), rng)
