"""How a batch keeps its worlds between rounds: what the coming round needs or somebody reads, no wider than it must be.

A round is worked out in the rows of one block, which stay in a core's cache. Thousands of worlds do not: they come from
memory and go back, and with enough of them that is what a step costs.
"""

from functools import cache
from typing import Any, NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray

from khepera_forage.envs.batch import rows as at
from khepera_forage.envs.batch.worlds import Worlds, empty_worlds, worlds_of
from khepera_forage.worlds.batch import rows as body
from khepera_forage.worlds.batch.compiling import inline
from khepera_forage.worlds.batch.rows import LANES

_ROBOT = np.array(
    (
        *(body.X, body.Y, body.HEADING, body.COS, body.SIN, body.ARM, body.JAW, body.GRIP_X, body.GRIP_Y),
        *(body.BIAS_LEFT, body.BIAS_RIGHT, body.PULSES_LEFT, body.PULSES_RIGHT, body.OWN_X, body.OWN_Y),
        *(body.LAST_FORWARD, body.LAST_TURN),
    )
)
_ROBOT_SHORT = np.array(
    (
        *(
            body.HELD,
            body.LEFT,
            body.RIGHT,
            body.ARM_TO,
            body.JAW_TO,
            body.PRESENT,
            body.ARM_READ,
            body.JAW_READ,
        ),
        *range(body.PROXIMITY, body.PROXIMITY + 8),
        *(body.OWN_DEGREES, body.OWN_FOUND, body.OWN_LOST, body.NEXT_LABEL, body.GHOSTS, body.NEW),
    )
)
_TASK = np.array(
    (
        *(at.FOOD_X, at.FOOD_Y, at.WALL_DISTANCE, at.WALL_BEARING, at.REWARD),
        *(at.HOME_WAY, at.HOME_BEARING, at.FOOD_WAY, at.FOOD_BEARING),
    )
)
_TASK_SHORT = np.array(
    (
        *(at.HELD, at.DELIVERED, at.POISON_HOME, at.DELIVERABLE, at.FOOD_SEEN, at.FOOD_TYPE),
        *range(at.PRESENCE, at.STATE + 1),
        *(at.BEHAVIOUR, at.STEPS, at.CORRECT, at.TERMINATED, at.TRUNCATED),
    )
)
_FOOD = np.array((body.FOOD_X, body.FOOD_Y, body.TRACK_X, body.TRACK_Y, body.GHOST_X, body.GHOST_Y))
_FOOD_SHORT = np.array((body.LOST, body.TRACK, body.TRACK_FOUND, body.NOTE, body.GHOST, body.GHOST_NOTE))
_REGISTER = np.array((at.PLACE_X, at.PLACE_Y))
_REGISTER_SHORT = np.array((at.TYPE, at.KNOWN, at.HOME, at.CARRIED, at.SETTLED))


def _places(
    long: NDArray[np.int64], long_at: int, short: NDArray[np.int64], short_at: int
) -> dict[int, tuple[int, int]]:
    """In which part of `Stored`, and there as which row, each row stands."""
    return {
        row: (part, first + k)
        for part, (rows, first) in enumerate(((long, long_at), (short, short_at)))
        for k, row in enumerate(rows.tolist())
    }


_ROBOTS_AT = _places(_ROBOT, 0, _ROBOT_SHORT, 0)
_TASKS_AT = _places(_TASK, _ROBOT.size, _TASK_SHORT, _ROBOT_SHORT.size)
_N = TypeVar("_N", bound=np.generic)


class Stored(NamedTuple):
    """Worlds between two rounds, one row of an array a block.

    Attributes:
        long: What needs a float64.
        short: Whole numbers and flags, which a float32 holds exactly.
        keys: As in `Bodies`.
    """

    long: NDArray[np.float64]
    short: NDArray[np.float32]
    keys: NDArray[np.uint64]


def empty_stored(blocks: int, foods: int) -> Stored:
    """Room for some blocks, as `empty_worlds` has it."""
    new = _new_block(foods)
    return Stored(
        np.tile(new.long, (blocks, 1)), np.tile(new.short, (blocks, 1)), np.tile(new.keys, (blocks, 1))
    )


@cache
def _new_block(foods: int) -> Stored:
    long = _ROBOT.size + _TASK.size + foods * (_FOOD.size + _REGISTER.size)
    short = _ROBOT_SHORT.size + _TASK_SHORT.size + foods * (_FOOD_SHORT.size + _REGISTER_SHORT.size)
    keys = np.zeros(body.KEY_ROWS * LANES, np.uint64)
    new = Stored(np.empty(long * LANES), np.empty(short * LANES, np.float32), keys)
    store(worlds_of(empty_worlds(1, foods), 0), new, foods)
    return new


@inline
def stored_of(stored: Stored, block: int) -> Stored:
    """Those of one block."""
    return Stored(stored.long[block], stored.short[block], stored.keys[block])


@inline
def fetch(stored: Stored, worlds: Worlds, foods: int) -> None:
    """Write what is stored of a block into its rows; the rows that are not stored stay as they are."""
    s, f, t, q = worlds.bodies.robots, worlds.bodies.food, worlds.tasks, worlds.registers
    long = _read(s, 0, _ROBOT, stored.long, 0)
    long = _read(t, 0, _TASK, stored.long, long)
    short = _read(s, 0, _ROBOT_SHORT, stored.short, 0)
    short = _read(t, 0, _TASK_SHORT, stored.short, short)
    for food in range(foods):
        long = _read(f, food * body.FOOD_ROWS, _FOOD, stored.long, long)
        long = _read(q, food * at.TASK_FOOD_ROWS, _REGISTER, stored.long, long)
        short = _read(f, food * body.FOOD_ROWS, _FOOD_SHORT, stored.short, short)
        short = _read(q, food * at.TASK_FOOD_ROWS, _REGISTER_SHORT, stored.short, short)
    for k in range(body.KEY_ROWS * LANES):
        worlds.bodies.keys[k] = stored.keys[k]


@inline
def store(worlds: Worlds, stored: Stored, foods: int) -> None:
    """Write of a block's rows what is to be stored."""
    s, f, t, q = worlds.bodies.robots, worlds.bodies.food, worlds.tasks, worlds.registers
    long = _write(s, 0, _ROBOT, stored.long, 0)
    long = _write(t, 0, _TASK, stored.long, long)
    short = _write(s, 0, _ROBOT_SHORT, stored.short, 0)
    short = _write(t, 0, _TASK_SHORT, stored.short, short)
    for food in range(foods):
        long = _write(f, food * body.FOOD_ROWS, _FOOD, stored.long, long)
        long = _write(q, food * at.TASK_FOOD_ROWS, _REGISTER, stored.long, long)
        short = _write(f, food * body.FOOD_ROWS, _FOOD_SHORT, stored.short, short)
        short = _write(q, food * at.TASK_FOOD_ROWS, _REGISTER_SHORT, stored.short, short)
    for k in range(body.KEY_ROWS * LANES):
        stored.keys[k] = worlds.bodies.keys[k]


@inline
def _line(rows: NDArray[Any], row: int) -> NDArray[Any]:
    """One row. A view: of an index that might be negative, for all the compiler knows, every use would be checked."""
    return rows[row * LANES : (row + 1) * LANES]


@inline
def _read(
    rows: NDArray[np.float64],
    base: int,
    kept: NDArray[np.int64],
    stored: NDArray[np.float64] | NDArray[np.float32],
    first: int,
) -> int:
    for k in range(kept.shape[0]):
        row, line = _line(rows, base + kept[k]), _line(stored, first + k)
        for i in range(LANES):
            row[i] = line[i]
    return first + int(kept.shape[0])


@inline
def _write(
    rows: NDArray[np.float64],
    base: int,
    kept: NDArray[np.int64],
    stored: NDArray[np.float64] | NDArray[np.float32],
    first: int,
) -> int:
    for k in range(kept.shape[0]):
        row, line = _line(rows, base + kept[k]), _line(stored, first + k)
        for i in range(LANES):
            line[i] = row[i]
    return first + int(kept.shape[0])


def robots_row(stored: Stored, row: int, kind: type[_N]) -> NDArray[_N]:
    """A row of the robots, one number a lane, as a fresh array of some type.

    Raises:
        KeyError: It is not stored.
    """
    return _row(stored, _ROBOTS_AT, row, kind)


def tasks_row(stored: Stored, row: int, kind: type[_N]) -> NDArray[_N]:
    """A row of the task, one number a lane, as a fresh array of some type.

    Raises:
        KeyError: It is not stored.
    """
    return _row(stored, _TASKS_AT, row, kind)


def _row(stored: Stored, places: dict[int, tuple[int, int]], row: int, kind: type[_N]) -> NDArray[_N]:
    if row not in places:
        raise KeyError(f"row {row} is not stored between rounds")
    part, there = places[row]
    return stored[part][:, there * LANES : (there + 1) * LANES].astype(kind).reshape(-1)


def worlds_from(stored: Stored, foods: int) -> Worlds:
    """All rows of all blocks, copied; those that are not stored are as in `empty_worlds`."""
    worlds = empty_worlds(stored.keys.shape[0], foods)
    for block in range(stored.keys.shape[0]):
        fetch(stored_of(stored, block), worlds_of(worlds, block), foods)
    return worlds
