"""`OneWorld`: a compiled world on its own, advanced by the kernels of a batch with one lane.

A call of a kernel takes a tenth of a microsecond for every array among its arguments, and a step of the kernel takes
less than one microsecond. So all arrays are handed over as one: their addresses and lengths.
"""

from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from khepera_forage.compilation.addresses import array_at
from khepera_forage.compilation.decorators import entrance
from khepera_forage.envs.compiled.parameters import TaskParameters
from khepera_forage.envs.compiled.records import (
    arena_dtype,
    decisions_dtype,
    episode_dtype,
    food_object_dtype,
    link_dtype,
    nearest_wall_dtype,
    place_dtype,
    start_dtype,
    straight_way_dtype,
    task_dtype,
    tracker_dtype,
    wall_dtype,
    way_corner_dtype,
)
from khepera_forage.envs.compiled.rounds import step_block
from khepera_forage.envs.compiled.worlds import Worlds, empty_worlds, known_ways, worlds_of
from khepera_forage.sim.compiled import records as bodies
from khepera_forage.sim.compiled.bodies import Bodies
from khepera_forage.sim.compiled.parameters import Parameters
from khepera_forage.sim.compiled.stepping import advance_address

_ROBOT, _FOOD, _SCRATCH, _TASK = (
    bodies.robot_dtype(1),
    bodies.food_dtype(1),
    bodies.scratch_dtype(1),
    task_dtype(1),
)
_TRACK, _DETECTION = bodies.track_dtype, bodies.detection_dtype
_WALL, _CORNER, _CONSTANTS = bodies.wall_dtype, bodies.corner_dtype, bodies.constants_dtype
_FLOAT, _FLAG = np.dtype(np.float64), np.dtype(np.bool_)
FOODS, WALLS, CORNERS, WAYPOINTS, NUMBERS, ADVANCE, HEAD = range(7)
"""What the table begins with: counts, how many numbers an action has, and the address of `advance_block`."""


class OneWorld:
    """One world of recalls: what `CompiledBatch` is for many. The world of a seed is the same in both.

    Args:
        parameters: Of the bodies.
        task: Of the task.
        numbers: How many an action has: 1, a behaviour, or 4, numbers in -1..1.

    Attributes:
        worlds: The records of one block with one lane.
        action: The coming action, shape (1, numbers).
        begins: Whether a new episode begins instead, shape (1,).
        start: Where the robot then starts; not a number for a random start.
        places: Where food then lies; not a number for random places.
        has_room: Whether the last new episode had room, shape (1,).
    """

    def __init__(self, parameters: Parameters, task: TaskParameters, numbers: int) -> None:
        foods = parameters.foods
        self.parameters, self.task = parameters, task
        self.worlds = empty_worlds(1, foods, len(task.waypoints), lanes=1)
        self.action = np.zeros((1, numbers))
        self.begins, self.has_room = np.zeros(1, np.bool_), np.ones(1, np.bool_)
        self.start, self.places = np.full(1, np.nan, start_dtype), np.full(foods, np.nan, place_dtype)

    def enter(self, parameters: Parameters, task: TaskParameters) -> None:
        """Let the coming episodes take place in another arena.

        Args:
            parameters: Of the bodies, with as many food objects as before.
            task: Of the task.
        """
        self.parameters, self.task = parameters, task
        ways, to_waypoints, lengths = known_ways(1, 1, parameters.foods, len(task.waypoints))
        self.worlds = self.worlds._replace(
            straight_ways=ways, to_waypoints=to_waypoints, food_lengths=lengths
        )
        self.__dict__.pop("table", None)

    @cached_property
    def table(self) -> NDArray[np.int64]:
        """All that `_step_one` needs; valid in this process."""
        counts = (
            self.parameters.foods,
            len(self.parameters.walls),
            len(self.parameters.corners),
            len(self.task.waypoints),
            self.action.shape[1],
            0,
        )
        arrays = (
            *self.worlds.bodies[:5],
            *self.worlds[1:],
            *self.parameters[1:4],
            *self.task,
            self.action,
            self.begins,
            self.start,
            self.places,
            self.has_room,
        )
        table = np.array((*counts, *(array.ctypes.data for array in arrays)), np.int64)
        table[ADVANCE] = advance_address(1, _step_one, table)
        return table

    def __getstate__(self) -> dict[str, Any]:
        return {name: value for name, value in self.__dict__.items() if name != "table"}

    def __setstate__(self, state: dict[str, Any]) -> None:
        # Copies: a pickle may be loaded in this process too, and must not share arrays with what it was made of.
        for name, value in state.items():
            setattr(self, name, value)

    def step(self) -> None:
        """One round, or the start of an episode, as `action` and `begins` say."""
        _step_one(self.table)


@entrance
def _step_one(table: NDArray[np.int64]) -> None:
    foods, numbers = table[FOODS], table[NUMBERS]
    walls, corners, waypoints = table[WALLS], table[CORNERS], table[WAYPOINTS]
    a = table[HEAD:]
    blocks = Bodies(
        array_at(a[0], (1,), _ROBOT),
        array_at(a[1], (1, foods), _FOOD),
        array_at(a[2], (1, 1, 2 * foods), _TRACK),
        array_at(a[3], (1,), _SCRATCH),
        array_at(a[4], (1, foods), _DETECTION),
        (),
    )
    worlds = Worlds(
        blocks,
        array_at(a[5], (1,), _TASK),
        array_at(a[6], (1, 1), tracker_dtype),
        array_at(a[7], (1, 1, foods), food_object_dtype),
        array_at(a[8], (1, 1), nearest_wall_dtype),
        array_at(a[9], (1, 1, 1 + foods), straight_way_dtype),
        array_at(a[10], (1, 1, waypoints), straight_way_dtype),
        array_at(a[11], (1, 1, foods, waypoints), _FLOAT),
        array_at(a[12], (1, 1, 2 * foods), link_dtype),
        array_at(a[13], (1, 1), episode_dtype),
        array_at(a[14], (1, 1), start_dtype),
        array_at(a[15], (1, foods), place_dtype),
    )
    parameters = Parameters(
        foods,
        array_at(a[16], (walls,), _WALL),
        array_at(a[17], (corners,), _CORNER),
        array_at(a[18], (1,), _CONSTANTS),
        (),
    )
    task = TaskParameters(
        array_at(a[19], (1,), arena_dtype),
        array_at(a[20], (walls,), wall_dtype),
        array_at(a[21], (walls,), wall_dtype),
        array_at(a[22], (corners,), way_corner_dtype),
        array_at(a[23], (waypoints,), place_dtype),
        array_at(a[24], (waypoints * waypoints,), _FLOAT),
        array_at(a[25], (waypoints,), _FLOAT),
        array_at(a[26], (waypoints,), _FLOAT),
        array_at(a[27], (1,), decisions_dtype),
    )
    action = array_at(a[28], (1, numbers), _FLOAT)
    begins = array_at(a[29], (1,), _FLAG)
    start = array_at(a[30], (1,), start_dtype)
    places = array_at(a[31], (foods,), place_dtype)
    has_room = array_at(a[32], (1,), _FLAG)
    block, advance = worlds_of(worlds, 0, 0), table[ADVANCE]
    has_room[0] = step_block(block, parameters, task, action, begins, start, places, advance)
