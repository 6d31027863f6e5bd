"""`step_worlds`: one round in all blocks of worlds, called from Python."""

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from khepera_forage.compilation.separate import machine_code
from khepera_forage.compilation.threads import BLOCKS_A_THREAD, share_out, threads_for
from khepera_forage.envs.compiled.prepared_arenas import PreparedArenas
from khepera_forage.envs.compiled.results import Results
from khepera_forage.envs.compiled.rounds import step_all
from khepera_forage.envs.compiled.worlds import Worlds
from khepera_forage.sim.compiled.stepping import advance_address

_step_all: dict[tuple[int, bool], Callable[..., None]] = {}
"""Machine code of `step_all` in this process, by number of lanes, and whether worlds are in several arenas."""


def step_worlds(
    worlds: Worlds,
    arenas: PreparedArenas,
    actions: ArrayLike,
    waiting: ArrayLike,
    start: NDArray[Any],
    places: NDArray[Any],
    results: Results,
) -> bool:
    """One round in every world.

    Args:
        worlds: The records of all blocks.
        arenas: In which the worlds are.
        actions: One behaviour a world, shape (worlds,), or four numbers in -1..1, shape (worlds, 4).
        waiting: Worlds that begin a new episode instead.
        start: As for `rounds.begin_world`.
        places: As for `rounds.begin_world`.
        results: Where to write what the round has brought.

    Returns:
        Whether all new episodes had room.
    """
    blocks, lanes = worlds.trackers.shape
    taken, free = np.zeros(1, np.int64), np.ones(1, np.bool_)
    common = (
        worlds,
        taken,
        free,
        arenas.parameters,
        arenas.task,
        _padded(actions, np.float64, blocks * lanes).reshape(blocks * lanes, -1),
        _padded(waiting, np.bool_, blocks * lanes).reshape(blocks * lanes),
        start,
        places,
        results,
    )
    several = arenas.several
    arguments = (*common, advance_address(lanes, step_all, 0, *common, 0, several=several))
    if (lanes, several) not in _step_all:
        _step_all[lanes, several] = machine_code(step_all, (0, *arguments))
    share_out(_step_all[lanes, several], threads_for(blocks // BLOCKS_A_THREAD), *arguments)
    return bool(free[0])


def _padded(array: ArrayLike, kind: type[np.generic], lanes: int) -> NDArray[Any]:
    """An array over worlds as the kernel takes it, with zeros for the lanes that no world uses."""
    given: NDArray[Any] = np.ascontiguousarray(array, kind)
    if len(given) == lanes:
        return given
    padded = np.zeros((lanes, *given.shape[1:]), kind)
    padded[: len(given)] = given
    return padded
