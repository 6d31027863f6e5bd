"""Lists of the walls near each robot, for blocks whose worlds are in different arenas.

Kernels loop over walls and, for each wall, over the worlds of a block. With one arena for all worlds, the walls are
those of the arena, and a field of a wall is a number. With several arenas, wall number j is another one in each world:
its fields have one number for each lane (`listed_walls` reads them). So that few walls have to be looked at, a list
holds those that the robot could touch or sense in the coming rounds (a Verlet list, Verlet 1967). It is made again when
the robot has moved on.

Functions with a `variant` do nothing, or return what they are given, in blocks of one arena. Those that return several
arrays return a tuple: compiled functions return no array that they were not given.
"""

import math
from typing import Any, NamedTuple

from khepera_forage.compilation.aligned import aligned_zeros
from khepera_forage.compilation.decorators import inline, kernel, types, variant
from khepera_forage.compilation.packing import pack
from khepera_forage.sim.broad_phase import PUSHED
from khepera_forage.sim.compiled.parameters import Parameters
from khepera_forage.sim.compiled.records import lists_dtype, near_corner_dtype, near_wall_dtype

_SLACK = 30.0
"""mm that a robot may move before its lists are made again: 4 rounds at most, and mostly many more."""
_FAR = 1e9
"""mm: coordinates of walls and corners behind the end of a list, which touch nothing."""


class Near(NamedTuple):
    """The lists of all blocks; `lists_of` gives those of one block.

    Attributes:
        lists: `lists_dtype`, shape (blocks, 1); of one block shape (1,).
        walls: `near_wall_dtype`, shape (blocks, most walls of an arena); of one block an array.
        corners: `near_corner_dtype`, shape (blocks, most corners of an arena); of one block an array.
    """

    lists: Any
    walls: Any
    corners: Any


def empty_lists(blocks: int, lanes: int, walls: int, corners: int) -> Near:
    """Lists without walls. Worlds are in arena 0 until `lists["arena"]` says otherwise.

    Args:
        blocks: How many.
        lanes: Worlds in a block.
        walls: Most walls of an arena.
        corners: Most corners of an arena.
    """
    near = Near(
        aligned_zeros((blocks, 1), lists_dtype(lanes)),
        aligned_zeros((blocks, walls), near_wall_dtype(lanes)),
        aligned_zeros((blocks, corners), near_corner_dtype(lanes)),
    )
    near.lists["listed_arena"] = -1
    for name, value in _FAR_WALL.items():
        near.walls[name] = value
    near.corners["x"] = near.corners["y"] = _FAR
    return near


_FAR_WALL = {
    "x1": _FAR,
    "y1": _FAR,
    "ex": 1.0,
    "ey": 0.0,
    "share": 1.0,
    "normal_x": 0.0,
    "normal_y": 1.0,
    "offset": _FAR,
}


def several(near: Any) -> bool:
    """Whether this is numba's type of the lists of several arenas, and not that of the empty tuple."""
    return isinstance(near, types.BaseNamedTuple)


def lists_of(near: Any, block: int) -> Any:
    """The lists of one block."""
    return near


@variant(lists_of, several)
def _lists_of(near: Any, block: int) -> Any:
    return Near(near.lists[block], near.walls[block], near.corners[block])


def enter(near: Any, i: int, arenas: Any, number: int) -> None:
    """Move one world to the arena with this number among `arenas`, for its next episode."""


@variant(enter, several)
def _enter(near: Any, i: int, arenas: Any, number: int) -> None:
    near.lists[0].arena[i] = arenas[number]


def near_walls(near: Any, parameters: Parameters) -> tuple[Any, Any]:
    """Walls and corners that kernels have to look at in a block."""
    return parameters.walls, parameters.corners


@variant(near_walls, several)
def _near_walls(near: Any, parameters: Parameters) -> tuple[Any, Any]:
    lists = near.lists[0]
    return near.walls[: most_listed(lists.walls)], near.corners[: most_listed(lists.corners)]


@inline
def most_listed(counts: Any) -> int:
    """The largest number of walls, or of corners, in the lists of a block."""
    most = 0
    for i in range(counts.shape[0]):
        most = max(most, counts[i])
    return most


def cable_anchors(near: Any, constants: Any) -> tuple[Any, Any]:
    """The point from which cables hang: x and y, as `at` reads them."""
    return constants[0].anchor_x, constants[0].anchor_y


@variant(cable_anchors, several)
def _cable_anchors(near: Any, constants: Any) -> tuple[Any, Any]:
    return near.lists[0].anchor_x, near.lists[0].anchor_y


def list_walls(near: Any, robot: Any, scratch: Any, parameters: Parameters) -> None:
    """Make the lists again where the robot could leave their range in this round, or has another arena."""


@variant(list_walls, several)
def _list_walls(near: Any, robot: Any, scratch: Any, parameters: Parameters) -> None:
    _make_lists(near, robot, scratch, parameters)


@kernel
def _make_lists(near: Any, robot: Any, scratch: Any, parameters: Parameters) -> None:
    lists = near.lists[0]
    for i in range(robot.x.shape[0]):
        dx, dy = robot.x[i] - lists.x[i], robot.y[i] - lists.y[i]
        left = lists.range[i] - 2.0 * scratch.travel[i]
        stays = left >= 0.0 and dx * dx + dy * dy <= left * left
        scratch.marked[i] = 0.0 if stays and lists.listed_arena[i] == lists.arena[i] else 1.0
    for n in range(pack(scratch.marked, scratch.lane, 0)):
        i = scratch.lane[n]
        x, y = robot.x[i], robot.y[i]
        lists.listed_arena[i] = lists.arena[i]
        lists.x[i], lists.y[i], lists.range[i] = x, y, 2.0 * scratch.travel[i] + _SLACK
        # All that the kernels examine is within PUSHED of where the robot is or gets.
        reach = PUSHED + lists.range[i]
        arena = parameters.arenas[lists.arena[i]]
        walls = parameters.walls[arena.first_wall : arena.first_wall + arena.walls]
        corners = parameters.corners[arena.first_corner : arena.first_corner + arena.corners]
        lists.anchor_x[i], lists.anchor_y[i] = arena.anchor_x, arena.anchor_y
        count = 0
        for k in range(walls.shape[0]):
            wall = walls[k]
            off = abs(wall.normal_x * x + wall.normal_y * y - wall.offset)
            squared = wall.ex * wall.ex + wall.ey * wall.ey
            along, beyond = (x - wall.x1) * wall.ex + (y - wall.y1) * wall.ey, reach * math.sqrt(squared)
            if off < reach and along > -beyond and along < squared + beyond:
                _put_wall(near.walls[count], i, wall)
                count += 1
        for k in range(count, lists.walls[i]):
            near.walls[k].x1[i] = near.walls[k].y1[i] = near.walls[k].offset[i] = _FAR
            near.walls[k].ex[i], near.walls[k].ey[i], near.walls[k].share[i] = 1.0, 0.0, 1.0
            near.walls[k].normal_x[i], near.walls[k].normal_y[i] = 0.0, 1.0
        lists.walls[i] = count
        count = 0
        for k in range(corners.shape[0]):
            dx, dy = corners[k].x - x, corners[k].y - y
            if dx * dx + dy * dy < reach * reach:
                near.corners[count].x[i], near.corners[count].y[i] = corners[k].x, corners[k].y
                count += 1
        for k in range(count, lists.corners[i]):
            near.corners[k].x[i] = near.corners[k].y[i] = _FAR
        lists.corners[i] = count


@inline
def _put_wall(entry: Any, i: int, wall: Any) -> None:
    entry.x1[i], entry.y1[i], entry.ex[i], entry.ey[i] = wall.x1, wall.y1, wall.ex, wall.ey
    entry.share[i], entry.offset[i] = wall.share, wall.offset
    entry.normal_x[i], entry.normal_y[i] = wall.normal_x, wall.normal_y
