"""`TaskBatch`: bodies and task of many worlds, one robot each, advanced together: what the vector environments wrap."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from khepera_forage.compilation.threads import BLOCKS_A_THREAD, share_out, threads_for
from khepera_forage.envs.arguments import FoodOdds, the_arena, whole_number
from khepera_forage.envs.compiled.parameters import rules_of
from khepera_forage.envs.compiled.rounds import play_all
from khepera_forage.envs.compiled.worlds import Worlds, empty_worlds
from khepera_forage.noise import Noise
from khepera_forage.sim.arena import Arena
from khepera_forage.sim.compiled import rows as body
from khepera_forage.sim.compiled.numbers import keys_of
from khepera_forage.sim.compiled.rows import LANES
from khepera_forage.sim.layout_checks import check_robot
from khepera_forage.task.placement import given_layout

Floats = NDArray[np.float64]


class TaskBatch:
    """Recalls in many worlds. Each plays one episode after another, by random numbers of its own.

    Args:
        num_worlds: How many.
        arena: As for the environments.
        foods: Food objects in each, 1 to 16.
        limit: Steps after which an episode ends.
        noise: The laboratory's troubles.
        food_types: One type, or odds by type.

    Raises:
        ValueError: An argument out of range.
    """

    def __init__(
        self,
        num_worlds: int,
        arena: Arena | str = "corridor",
        foods: int = 1,
        limit: int = 500,
        noise: Noise | None = None,
        food_types: FoodOdds = None,
    ) -> None:
        self.num_worlds = whole_number("num_worlds", num_worlds, 1)
        self.arena = the_arena(arena)
        self._setting, self._rules = rules_of(self.arena, foods, limit, noise, food_types)
        self.foods, self.limit = self._setting.foods, self._rules.limit
        self._blocks = -(-self.num_worlds // LANES)
        self.worlds = empty_worlds(self._blocks, self.foods)

    @property
    def bytes_per_world(self) -> float:
        """Memory that a world takes; what threads work in comes to it."""
        return float(sum(rows.nbytes for rows in _kept(self.worlds)) / self._blocks / LANES)

    @property
    def diagonal(self) -> int:
        """Of the arena, in pixels."""
        return int(self._rules.place[4])

    @property
    def home(self) -> Floats:
        """x, y and radius of the home, in pixels."""
        return self._rules.place[:3].copy()

    def seed(self, seed: int, worlds: NDArray[np.int64]) -> None:
        """Give worlds their random numbers: world i of a seed, whatever the size of the batch.

        Args:
            seed: At least 0.
            worlds: Numbers of those that are seeded.
        """
        self._key(worlds, keys_of(seed, worlds))

    def seed_each(self, seeds: list[int], worlds: NDArray[np.int64]) -> None:
        """Give each of some worlds a seed of its own, of which it is then world 0."""
        zero = np.zeros(1, np.int64)
        self._key(worlds, np.concatenate([keys_of(seed, zero) for seed in seeds]))

    def restart(self, worlds: NDArray[np.int64], options: Mapping[str, Any] | None = None) -> None:
        """Begin new episodes in some worlds, up to their first observation; the others stay as they are.

        Args:
            worlds: Their numbers.
            options: `start` and `foods` as for the environments; what is left out is random.

        Raises:
            ValueError: Options that are unknown or place something off the free floor, or an arena with no room.
        """
        pose, places = asked_for(self.arena, self.foods, options or {})
        # New episodes begin in blocks of their own, which are then copied to where they belong.
        blocks = -(-len(worlds) // LANES)
        room = empty_worlds(blocks, self.foods)
        new = np.arange(len(worlds))
        there, here = (new // LANES, slice(None), new % LANES), (worlds // LANES, slice(None), worlds % LANES)
        _by_row(room.bodies.keys)[there] = _by_row(self.worlds.bodies.keys)[here]
        lanes = blocks * LANES
        self._play(room, np.zeros((lanes, 1)), np.arange(lanes) < len(worlds), pose, places)
        if np.isnan(_by_row(room.bodies.robots)[:, body.X]).any():
            raise no_room(self.arena, self.foods)
        for rows, begun in zip(_kept(self.worlds), _kept(room), strict=True):
            _by_row(rows)[here] = _by_row(begun)[there]

    def step(self, actions: Floats, waiting: NDArray[np.bool_]) -> None:
        """One round of 0.1 s in every world.

        Args:
            actions: One behaviour a world, shape (worlds,), or motors as `Motors` has them, shape (worlds, 4).
            waiting: Worlds that begin a new episode instead.
        """
        lanes = self._blocks * LANES
        padded = np.zeros((lanes, *actions.shape[1:]))
        padded[: self.num_worlds] = actions
        fresh = np.zeros(lanes, np.bool_)
        fresh[: self.num_worlds] = waiting
        nowhere, nothing = np.full(3, np.nan), np.full((self.foods, 2), np.nan)
        self._play(self.worlds, padded.reshape(lanes, -1), fresh, nowhere, nothing)

    def task(self, row: int, kind: type[np.generic] = np.float64) -> NDArray[Any]:
        """A row of `envs.compiled.rows`, one number a world, as a fresh array of some type."""
        return self._row(self.worlds.tasks, row, kind)

    def body(self, row: int, kind: type[np.generic] = np.float64) -> NDArray[Any]:
        """A row of `sim.compiled.rows`, one number a world, as a fresh array of some type."""
        return self._row(self.worlds.bodies.robots, row, kind)

    def _row(self, rows: Floats, row: int, kind: type[np.generic]) -> NDArray[Any]:
        return _by_row(rows)[:, row].astype(kind).reshape(-1)[: self.num_worlds]

    def _key(self, worlds: NDArray[np.int64], keys: NDArray[np.uint64]) -> None:
        rows, lanes = self.worlds.bodies.keys.reshape(-1, body.KEY_ROWS, LANES), worlds % LANES
        rows[worlds // LANES, body.KEY, lanes] = keys
        rows[worlds // LANES, body.ROUND, lanes] = 0

    def _play(
        self, worlds: Worlds, actions: Floats, fresh: NDArray[np.bool_], pose: Floats, places: Floats
    ) -> None:
        begun, given = np.zeros(1, np.int64), (self._setting, self._rules, actions, fresh, pose, places)
        share_out(play_all, threads_for(len(worlds.tasks) // BLOCKS_A_THREAD), worlds, begun, *given)


def asked_for(arena: Arena, foods: int, options: Mapping[str, Any]) -> tuple[Floats, Floats]:
    """Start and food places that `reset(options=...)` asks for, mm and radians; what it leaves open is not a number.

    Args:
        arena: Where.
        foods: Number of food objects.
        options: `start` and `foods` as for the environments.

    Raises:
        ValueError: Options that are unknown or place something off the free floor.
    """
    pose, places = np.full(3, np.nan), np.full((foods, 2), np.nan)
    if options:
        layout = given_layout(arena, foods, options, np.random.default_rng(0))
        if "start" in options:
            check_robot(arena, layout.starts[0])
            pose = np.array(layout.starts[0])
        if "foods" in options:
            places = np.array(layout.foods)
    return pose, places


def no_room(arena: Arena, foods: int) -> ValueError:
    """What is wrong with an arena in which no random places were found."""
    return ValueError(
        f"{arena.name}: no room for a robot and {foods} food objects outside home; make the arena larger"
    )


def _kept(worlds: Worlds) -> tuple[NDArray[Any], ...]:
    """All arrays that hold something between rounds."""
    return *worlds.bodies[:3], worlds.tasks, worlds.registers


def _by_row(rows: NDArray[Any]) -> NDArray[Any]:
    """Blocks of rows as (blocks, rows, lanes)."""
    return rows.reshape(rows.shape[0], -1, LANES)
