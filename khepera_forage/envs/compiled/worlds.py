"""The records of worlds: one array for each kind of record, with a row for each world.

The number of food objects is the length of rows. So worlds of any number have one type.
"""

from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np

from khepera_forage.compilation import rule
from khepera_forage.geometry.paths import ChosenWaypoint
from khepera_forage.records import dtype_of
from khepera_forage.sim.compiled.world import detection_dtype, food_dtype, robot_dtype, track_dtype
from khepera_forage.task.episode import Episode
from khepera_forage.task.food_tracking import FoodObject, FoodTracker, Link
from khepera_forage.task.perception import RawData
from khepera_forage.task.placement import Place, Start
from khepera_forage.task.states import StateVector


@dataclass(slots=True)
class ForagerState:
    """One robot at its task.

    Attributes:
        raw: The raw data of the last round.
        vector: The state vector of the last round.
        state: What the teacher classifies the state vector as.
        behaviour: What was decided on.
        correct: Whether the teacher would have decided the same.
        begins: Whether the last frame was the first of its episode.
        number: Episodes of this world that began since it was seeded.
        presence_before: What the robot sensed when the round began; also the next two.
        arm_before: Likewise.
        jaw_before: Likewise.
        episode: The account of its episode.
        tracker: The food tracker of its arena.
    """

    raw: RawData
    vector: StateVector
    state: int = 0
    behaviour: int = 0
    correct: bool = False
    begins: bool = False
    number: int = 0
    presence_before: int = 0
    arm_before: int = 0
    jaw_before: int = 0
    episode: Episode = field(default_factory=Episode)
    tracker: FoodTracker = field(default_factory=FoodTracker)


forager_dtype, object_dtype, link_dtype, chosen_dtype, start_dtype, place_dtype = map(
    dtype_of, (ForagerState, FoodObject, Link, ChosenWaypoint, Start, Place)
)


class World(NamedTuple):
    """The records of one world; or of many, with one row a world.

    Attributes:
        robots: `RobotState`, its one robot.
        foragers: `ForagerState`, that robot at its task.
        starts: `Start`, where it stood at the beginning of the episode.
        foods: `FoodState` records.
        objects: `FoodObject` records: what is known of the food.
        places: `Place` records: where food lay at the beginning of the episode.
        detections: `FoodDetection` records, which hold nothing between rounds.
        tracks: `Track` records, twice as many as food objects.
        links: `Link` records, as many as tracks.
        chosen: `ChosenWaypoint` records: on the way home, and to each food object.
    """

    robots: Any
    foragers: Any
    starts: Any
    foods: Any
    objects: Any
    places: Any
    detections: Any
    tracks: Any
    links: Any
    chosen: Any


def new_worlds(count: int, foods: int) -> World:
    """Worlds without an episode, with room for this many food objects."""
    return World(
        np.zeros((count, 1), robot_dtype),
        np.zeros((count, 1), forager_dtype),
        np.zeros((count, 1), start_dtype),
        np.zeros((count, foods), food_dtype),
        np.zeros((count, foods), object_dtype),
        np.zeros((count, foods), place_dtype),
        np.zeros((count, foods), detection_dtype),
        np.zeros((count, 2 * foods), track_dtype),
        np.zeros((count, 2 * foods), link_dtype),
        np.zeros((count, 1 + foods), chosen_dtype),
    )


@rule
def world_of(worlds: World, i: int) -> World:
    """The records of one world."""
    return World(
        worlds.robots[i],
        worlds.foragers[i],
        worlds.starts[i],
        worlds.foods[i],
        worlds.objects[i],
        worlds.places[i],
        worlds.detections[i],
        worlds.tracks[i],
        worlds.links[i],
        worlds.chosen[i],
    )
