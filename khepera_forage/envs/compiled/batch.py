"""`CompiledBatch`: bodies and task of many worlds, one robot each, advanced together."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from khepera_forage.counter_rng import key_of, keys_of
from khepera_forage.envs.arena_pool import Arenas
from khepera_forage.envs.arguments import FoodOdds, checked_decisions, whole_number
from khepera_forage.envs.compiled.prepared_arenas import enter_arenas, recall_arenas
from khepera_forage.envs.compiled.records import place_dtype, start_dtype
from khepera_forage.envs.compiled.results import Results, empty_results
from khepera_forage.envs.compiled.rounds import read_results
from khepera_forage.envs.compiled.stepping import step_worlds
from khepera_forage.envs.compiled.worlds import kept
from khepera_forage.envs.layouts import given_places, no_room
from khepera_forage.noise import Noise
from khepera_forage.sim.arena import Arena
from khepera_forage.sim.compiled.records import LANES
from khepera_forage.task.decisions import Decisions


class CompiledBatch:
    """Recalls in many worlds. Each has one episode after another, with random numbers of its own.

    Args:
        num_worlds: How many.
        arena: As for the environments.
        foods: Food objects in each, 1 to 16.
        limit: Steps after which an episode ends.
        noise: The laboratory's troubles by default.
        food_types: One type, or odds by type.
        decisions: Ours by default.

    Raises:
        ValueError: An argument out of range.
    """

    def __init__(
        self,
        num_worlds: int,
        arena: Arenas = "corridor",
        foods: int = 1,
        limit: int = 500,
        noise: Noise | str | None = None,
        food_types: FoodOdds = None,
        decisions: Decisions | None = None,
    ) -> None:
        self.num_worlds = whole_number("num_worlds", num_worlds, 1)
        self.decisions = checked_decisions(decisions)
        self._arenas = recall_arenas(arena, foods, limit, noise, food_types, self.decisions)
        self.foods, self.limit = foods, limit
        self._blocks = -(-self.num_worlds // LANES)
        self.worlds = self._arenas.empty_worlds(self._blocks)
        self._random_places = as_records(None, None, self.foods)

    @property
    def bytes_per_world(self) -> float:
        """Memory of a world, without what threads work in."""
        arrays = (*kept(self.worlds), *self.worlds.bodies.near)
        return float(sum(array.nbytes for array in arrays) / self._blocks / LANES)

    @property
    def arenas(self) -> list[Arena]:
        """The arena in which each world is."""
        return [self._arenas[index] for index in self._indices.tolist()]

    @property
    def diagonals(self) -> NDArray[np.int64]:
        """Of the arena in which each world is, in pixels."""
        return self._of_arenas("map_diagonal", np.int64)

    @property
    def homes(self) -> NDArray[np.float64]:
        """x, y and radius of the home of each world, in pixels, shape (worlds, 3)."""
        return np.stack([self._of_arenas(f"map_home_{name}") for name in ("x", "y", "radius")], axis=1)

    def seed(self, seeds: list[int], worlds: NDArray[np.int64]) -> None:
        """Seed some worlds, each with its own seed: it then has the episodes of a single environment with that seed.

        Args:
            seeds: One a world, each at least 0.
            worlds: Numbers of the worlds.
        """
        if max(seeds) < 1 << 63:  # else they do not fit into 64 bits
            keys = keys_of(np.array(seeds, np.uint64))
        else:
            keys = np.array([key_of(seed) for seed in seeds], np.uint64)
        robots, here = self.worlds.bodies.robots, (worlds // LANES, worlds % LANES)
        robots["key"][here], robots["round"][here] = keys, 0
        self.worlds.episodes["number"][here] = 0

    def restart(self, worlds: NDArray[np.int64], options: Mapping[str, Any] | None = None) -> None:
        """Begin new episodes in some worlds, up to their first observation; the others stay unchanged.

        Args:
            worlds: Their numbers.
            options: `start` and `foods` as for the environments; what is left out is random.

        Raises:
            ValueError: Options that are unknown or place something off the free floor, or an arena with no room.
        """
        indices = self._next_arenas(worlds)
        for index in np.unique(indices).tolist():
            places = given_places(self._arenas[index], self.foods, options or {})
        given = as_records(*places, self.foods)
        # New episodes begin in blocks of their own, whose records are then copied to where they belong.
        blocks = -(-len(worlds) // LANES)
        begun = self._arenas.empty_worlds(blocks)
        new = np.arange(len(worlds))
        there, here = (new // LANES, new % LANES), (worlds // LANES, worlds % LANES)
        for name in ("key", "round"):
            begun.bodies.robots[name][there] = self.worlds.bodies.robots[name][here]
        begun.episodes["number"][there] = self.worlds.episodes["number"][here]
        enter_arenas(begun, there, indices)
        lanes = blocks * LANES
        waiting = np.arange(lanes) < len(worlds)
        if not step_worlds(begun, self._arenas, np.zeros(lanes), waiting, *given, empty_results(0)):
            raise self._no_room(indices)
        for array, source in zip(kept(self.worlds), kept(begun), strict=True):
            _copy_worlds(array, here, source, there)
        enter_arenas(self.worlds, here, indices)

    def step(self, actions: ArrayLike, waiting: ArrayLike) -> Results:
        """One round in every world, and what it has brought.

        Args:
            actions: One behaviour a world, shape (worlds,), or four numbers in -1..1, shape (worlds, 4).
            waiting: Worlds that begin a new episode instead.

        Raises:
            ValueError: An arena has no room for a new episode.
        """
        new = np.flatnonzero(waiting)
        if len(new) and self._arenas.several:
            indices = self._next_arenas(new)  # may replace `worlds` by larger records
            enter_arenas(self.worlds, (new // LANES, new % LANES), indices)
        results, random = empty_results(self.num_worlds), self._random_places
        if not step_worlds(self.worlds, self._arenas, actions, waiting, *random, results):
            raise self._no_room(self._indices[new])
        return results

    def results(self) -> Results:
        """What the last step or restart has brought, in fresh arrays."""
        results = empty_results(self.num_worlds)
        read_results(results, self.worlds)
        return results

    def task(self, name: str, kind: type[np.generic] = np.float64) -> NDArray[Any]:
        """A field of the task's records, one number a world, as a fresh array of some type."""
        return self._over_worlds(self.worlds.tasks[name]).astype(kind)

    def robot(self, name: str, kind: type[np.generic] = np.float64) -> NDArray[Any]:
        """A field of the robots' records, one number a world, as a fresh array of some type."""
        return self._over_worlds(self.worlds.bodies.robots[name]).astype(kind)

    @property
    def proximity(self) -> NDArray[np.int64]:
        """The eight infra-reds of each world, shape (worlds, 8)."""
        readings: NDArray[Any] = self.worlds.bodies.robots["proximity"].swapaxes(1, 2).reshape(-1, 8)
        return readings[: self.num_worlds].astype(np.int64)

    @property
    def _indices(self) -> NDArray[np.int64]:
        """Index of the arena in which each world is."""
        near = self.worlds.bodies.near
        return self._over_worlds(near.lists["arena"]) if near else np.zeros(self.num_worlds, np.int64)

    def _of_arenas(self, name: str, kind: type[np.generic] = np.float64) -> NDArray[Any]:
        """A field of the arena in which each world is, one number a world, as a fresh array of some type."""
        values: NDArray[Any] = self._arenas.task.arena[name].astype(kind)
        return values[self._indices] if self._arenas.several else np.full(self.num_worlds, values[0])

    def _next_arenas(self, worlds: NDArray[np.int64]) -> NDArray[np.int64]:
        """Indices of the arenas of the next episodes of some worlds. There is then room for their records."""
        if not self._arenas.several:
            return np.zeros(len(worlds), np.int64)
        here = (worlds // LANES, worlds % LANES)
        keys, episodes = self.worlds.bodies.robots["key"][here], self.worlds.episodes["number"][here]
        self._arenas.forget(self.worlds)
        indices = self._arenas.next(keys, episodes)
        self.worlds = self._arenas.with_room(self.worlds)
        return indices

    def _no_room(self, indices: NDArray[np.int64]) -> ValueError:
        """The error of new episodes in arenas, one of which had no room."""
        names = sorted({self._arenas[index].name for index in indices.tolist()})
        return no_room(", ".join(names[:3]) + (", ..." if len(names) > 3 else ""), self.foods)

    def _over_worlds(self, array: NDArray[Any]) -> NDArray[Any]:
        return array.reshape(-1)[: self.num_worlds]


def as_records(start: Any, places: Any, foods: int) -> tuple[NDArray[Any], NDArray[Any]]:
    """Given start and food places as kernels take them; not a number where they are random.

    Args:
        start: A `Pose`, or None.
        places: One `Point` a food object, or None.
        foods: Number of food objects.
    """
    starts = np.full(1, np.nan, start_dtype) if start is None else np.array([tuple(start)], start_dtype)
    if places is None:
        return starts, np.full(foods, np.nan, place_dtype)
    return starts, np.array([tuple(place) for place in places], place_dtype)


def _copy_worlds(array: NDArray[Any], here: Any, source: NDArray[Any], there: Any) -> None:
    """Copy some worlds from one array of `kept` to another of the same kind."""
    if array.dtype.names is None or not array.dtype[0].shape:
        array[here] = source[there]
        return
    for name in array.dtype.names or ():
        # A field over lanes, which are its last axis.
        np.moveaxis(array[name], -1, 1)[here] = np.moveaxis(source[name], -1, 1)[there]
