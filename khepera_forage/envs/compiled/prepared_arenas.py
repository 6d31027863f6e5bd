"""The arenas of compiled worlds as kernels read them, each prepared when a world first enters it."""

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from khepera_forage.envs.arena_pool import ArenaPool, Arenas
from khepera_forage.envs.arguments import FoodOdds
from khepera_forage.envs.compiled.joined_arenas import JoinedArenas
from khepera_forage.envs.compiled.parameters import TaskParameters, recall_parameters
from khepera_forage.envs.compiled.records import MAP, PARTS
from khepera_forage.envs.compiled.worlds import Worlds, empty_worlds
from khepera_forage.noise import Noise
from khepera_forage.sim.arena import Arena
from khepera_forage.sim.compiled.near_walls import empty_lists
from khepera_forage.sim.compiled.parameters import Parameters
from khepera_forage.sim.compiled.records import LANES
from khepera_forage.task.decisions import Decisions
from khepera_forage.task.placement import arena_number

MOST_ARENAS = 1 << 14
"""Prepared arenas of a batch, at which those in which no world is are forgotten; 2 to 16 kB each."""


class PreparedArenas:
    """The arenas of a batch of worlds.

    With one arena, kernels read its records. With several, they read one array of each kind, in which the records of
    one arena follow those of another; a world has the index of its arena among them.

    Args:
        pool: All arenas.
        prepare: Parameters of one arena, those of all others with other walls.

    Attributes:
        parameters: Of the bodies, in all arenas prepared so far.
        task: Of the task, likewise.
    """

    def __init__(
        self, pool: ArenaPool, prepare: Callable[[Arena], tuple[Parameters, TaskParameters]]
    ) -> None:
        self._pool, self._prepare = pool, prepare
        self.several = len(pool) > 1
        self._numbers: list[int] = []
        self._index_of: dict[int, int] = {}
        self._pieces = JoinedArenas()
        self._most = 0, 0, 0
        """Most walls, corners and waypoints of an arena. Every step needs them, and there may be 16,384 arenas."""
        self.parameters: Parameters
        self.task: TaskParameters
        if self.several:
            self.indices(np.zeros(1, np.int64))
        else:
            self._numbers = [0]
            self.parameters, self.task = prepare(pool[0])

    def __getitem__(self, index: int) -> Arena:
        """The arena with this index among those prepared."""
        return self._pool[self._numbers[index]]

    def indices(self, numbers: NDArray[Any]) -> NDArray[np.int64]:
        """Indices of the arenas with these numbers in the pool. New arenas are prepared.

        Raises:
            ValueError: An arena that is too narrow, or that the camera does not see.
        """
        listed = numbers.tolist()
        new = sorted(set(listed).difference(self._index_of))
        for number in new:
            self._pieces.add(*self._prepare(self._pool[number]))
            self._index_of[number] = len(self._numbers)
            self._numbers.append(number)
        if new:
            self._join()
        return np.array([self._index_of[number] for number in listed], np.int64)

    def next(self, keys: NDArray[np.uint64], episodes: NDArray[np.int64]) -> NDArray[np.int64]:
        """Indices of the arenas of episodes, see `task.placement.arena_number`; new arenas are prepared.

        Args:
            keys: Of worlds.
            episodes: Number of an episode of each.
        """
        return self.indices(arena_number(keys, episodes.astype(np.uint64), len(self._pool)))

    def forget(self, worlds: Worlds | None = None) -> None:
        """Forget the arenas in which no world is, if there are many.

        Args:
            worlds: All of them; None between rollouts. The indices of their arenas change.
        """
        if not self.several or len(self._numbers) < MOST_ARENAS:
            return
        kept = np.zeros(1, np.int64)
        if worlds is not None:
            lists = worlds.bodies.near.lists
            kept, indices = np.unique(lists["arena"], return_inverse=True)
            lists["arena"], lists["listed_arena"] = indices.reshape(lists["arena"].shape), -1
        before, self._pieces = self._pieces, JoinedArenas()
        for index in kept.tolist():
            self._pieces.add(*before[index])
        self._numbers = [self._numbers[index] for index in kept.tolist()]
        self._index_of = {number: index for index, number in enumerate(self._numbers)}
        self._join()
        if worlds is not None:
            self._enter_maps(worlds)

    def with_room(self, worlds: Worlds) -> Worlds:
        """Worlds with room for all arenas prepared so far: these ones, or a copy if they have too little."""
        near, lengths, ways = worlds.bodies.near, worlds.food_lengths, worlds.to_waypoints
        present = near.walls.shape[1], near.corners.shape[1], lengths.shape[3]
        if all(size >= most for size, most in zip(present, self._most, strict=True)):
            return worlds
        larger = self.empty_worlds(len(worlds.tasks), worlds.trackers.shape[1])
        larger.bodies.near.lists["arena"] = near.lists["arena"]  # the lists are made again
        larger.food_lengths[..., : lengths.shape[3]] = lengths
        larger.to_waypoints[..., : lengths.shape[3]] = ways
        return worlds._replace(
            bodies=worlds.bodies._replace(near=larger.bodies.near),
            to_waypoints=larger.to_waypoints,
            food_lengths=larger.food_lengths,
        )

    def empty_worlds(self, blocks: int, lanes: int = LANES) -> Worlds:
        """Records for some blocks of worlds, with room for all arenas prepared so far."""
        foods = self.parameters.foods
        if not self.several:
            return empty_worlds(blocks, foods, len(self.task.waypoints), lanes)
        walls, corners, waypoints = self._most
        worlds = empty_worlds(blocks, foods, waypoints, lanes, empty_lists(blocks, lanes, walls, corners))
        self._enter_maps(worlds)
        return worlds

    def _enter_maps(self, worlds: Worlds) -> None:
        """Copy what each round reads of the arena of each world, as `arena_maps.enter_map` does in one world."""
        arenas = worlds.bodies.near.lists["arena"][:, 0]
        for name in (*MAP, *PARTS):
            worlds.tasks[name] = self.task.arena[name][arenas]

    def _join(self) -> None:
        """Let kernels read all arenas prepared so far."""
        self.parameters, self.task = self._pieces.joined()
        walls, corners, waypoints = (
            int(self.task.arena[name].max()) for name in ("walls", "corners", "waypoints")
        )
        self._most = walls, corners, waypoints


def recall_arenas(
    arenas: Arenas,
    foods: int,
    limit: int,
    noise: Noise | str | None,
    food_types: FoodOdds,
    decisions: Decisions,
    wheel_speed: float = 1.0,
) -> PreparedArenas:
    """The arenas of recalls; arguments and errors as for `recall_parameters`."""
    prepare = partial(
        recall_parameters,
        foods=foods,
        limit=limit,
        noise=noise,
        food_types=food_types,
        decisions=decisions,
        wheel_speed=wheel_speed,
    )
    return PreparedArenas(ArenaPool(arenas, decisions), prepare)


def enter_arenas(worlds: Worlds, here: Any, indices: NDArray[np.int64]) -> None:
    """Move some worlds to other arenas, for their next episodes.

    Args:
        worlds: All of them.
        here: Block and lane of these worlds.
        indices: Of the arenas among those prepared.
    """
    if worlds.bodies.near:
        lists = worlds.bodies.near.lists[:, 0]
        lists["arena"][here], lists["listed_arena"][here] = indices, -1
