"""The records that hold the task of compiled worlds, beside those of the bodies (`sim.compiled.records`).

What is computed for many worlds at once has fields over lanes. What the rules of the task remember is one record for
each world, with whole numbers no larger than they need to be: the records of a block then leave more of a processor's
nearest memory to the rest.
"""

from dataclasses import fields
from typing import Any

import numpy as np

from khepera_forage.geometry.walls import Wall
from khepera_forage.task.arena_map import ArenaMap, Floor
from khepera_forage.task.decisions import Decisions
from khepera_forage.task.states import FoodType

VECTOR = ("object_presence", "robot_home_distance", "vector_food_type", "arms_height", "robot_food_distance")
"""Fields of the state vector, in the thesis's order."""
SHOWN = (*VECTOR, "state", "food_seen", "food_x", "food_y", "food_type", "wall_distance", "wall_bearing")
"""Fields of the task that environments show: the state vector, the state that it stands for, and raw data."""
TASK = (
    *SHOWN,
    # What the robot sensed when the round began.
    *("presence_before", "arm_before", "jaw_before"),
    # Raw data beyond the senses and the robot's own region: pixels and degrees.
    *("wall_x", "wall_y", "wall_squared"),
    *("home_distance", "home_bearing", "home_path", "home_way_x", "home_way_y"),
    *("food_distance", "food_bearing", "food_path", "food_way_x", "food_way_y"),
    "behaviour",  # what was decided on
    "correct",  # whether the teacher would have decided the same
    "begins",  # whether the last frame was the first of its episode
)
"""Fields of the task of one world."""
MAP = (
    *(f"map_{name}" for name in ArenaMap._fields if name not in ("walls", "ways")),
    *("map_clearance", "map_berth"),
)
"""`task.arena_map.ArenaMap` in pixels without its walls, with the clearance and berth of its `Ways`."""
PARTS = (
    *("first_wall", "walls", "first_corner", "corners", "first_waypoint", "waypoints"),
    "first_length",
)
"""Which of the walls, corners and waypoints of all arenas are those of one, and where the lengths of its ways begin."""
NEAREST_WALLS = ("nearest_x1", "nearest_y1", "nearest_ex", "nearest_ey", "nearest_share")
"""Fields of the task of one world that hold the four nearest walls, if worlds are in different arenas."""

tracker_dtype = np.dtype(
    [
        *((name, "i2") for name in ("held", "type_in_gripper", "delivered", "poison_home", "deliverable")),
        ("food_seen", "?"),
        ("nearest", "i2"),
        *(
            (name, "f8")
            for name in ("food_x", "food_y", "food_way_x", "food_way_y", "food_path", "last_distance")
        ),
    ],
    align=True,
)
"""The fields of `task.food_tracking.FoodTracker` without its lists."""

food_object_dtype = np.dtype(
    [
        *(("x", "f8"), ("y", "f8"), ("type", "i1"), ("known", "i1")),
        *((name, "?") for name in ("delivered", "carried", "may_be_poisonous")),
        ("side", "i1"),
        *(("lengths_x", "f8"), ("lengths_y", "f8")),
    ],
    align=True,
)
"""`task.food_tracking.FoodObject`."""

link_dtype = np.dtype([("label", "i4"), ("food", "i2"), ("lost_rounds", "i4")], align=True)
"""`task.food_tracking.Link`."""

episode_dtype = np.dtype(
    [
        *((name, "i4") for name in ("steps", "correct", "value")),
        ("reward", "f8"),
        *((name, "?") for name in ("terminated", "truncated")),
        ("number", "i4"),  # episodes of this world that began since it was seeded
    ],
    align=True,
)
"""`task.episode.Episode`, and which episode of its world it is."""

start_dtype = np.dtype([("x", "f8"), ("y", "f8"), ("heading", "f8")])
"""`task.placement.Start`."""

place_dtype = np.dtype([("x", "f8"), ("y", "f8")])
"""`task.placement.Place` and `geometry.paths.Spot`."""

straight_way_dtype = np.dtype(
    [*((name, "f4") for name in ("x", "y", "to_x", "to_y", "room")), ("blocker", "i2"), ("waypoint", "i2")],
    align=True,
)
"""`geometry.known_ways.StraightWay`."""

nearest_wall_dtype = np.dtype(
    [
        *((name, "f4") for name in ("x", "y", "room_of_two", "room_of_four")),
        *((name, "i2") for name in ("first", "second", "third", "fourth")),
    ]
)
"""`geometry.nearest_wall.NearestWall`."""

way_corner_dtype = np.dtype([("x", "f8"), ("y", "f8"), ("before", "i8"), ("after", "i8")])
"""`geometry.paths.Corner`."""

wall_dtype = np.dtype([(name, "i8" if name == "polygon" else "f8") for name in Wall._fields])
"""`geometry.walls.Wall`."""

decisions_dtype = np.dtype([(field.name, "f8") for field in fields(Decisions)])
"""`task.decisions.DecisionValues`."""

arena_dtype = np.dtype(
    [(name, "f8") for name in MAP]
    + [(f"floor_{name}", "f8") for name in Floor._fields if name != "walls"]
    + [("odds", "f8", (len(FoodType) - 1,))]
    + [("limit", "i8")]
    + [(name, "i8") for name in PARTS]
)
"""One arena: `MAP`; `Floor` in mm without its walls; odds of food types, and the step limit; `PARTS`, if worlds are in
different arenas."""


def task_dtype(lanes: int, several: bool = False) -> np.dtype[Any]:
    """The task of one block of worlds, which are in one arena or in several.

    With several, it has a copy of what each round reads of the arena of each world: arenas lie anywhere in memory.
    """
    kinds: list[Any] = [(name, "f8", (lanes,)) for name in TASK]
    if several:
        kinds += [(name, "f8", (lanes,)) for name in MAP] + [(name, "i4", (lanes,)) for name in PARTS]
        kinds += [(name, "f8", (4, lanes)) for name in NEAREST_WALLS]
    return np.dtype(kinds)
