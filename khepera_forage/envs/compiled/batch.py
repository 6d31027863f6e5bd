"""`CompiledBatch`: recalls in many compiled worlds, stepped together."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields
from typing import Any

import numpy as np
from numpy.typing import NDArray

from khepera_forage.compilation import entry, share_out
from khepera_forage.counter_rng import keys_of
from khepera_forage.envs.arguments import COMPILED, ArenaPool, Settings, timing_of, whole_number
from khepera_forage.envs.compiled.arenas import PreparedArenas, arena_at, map_of, settings_record
from khepera_forage.envs.compiled.step import WorldRecords, begin, carry_out, drive, motors_of, new_worlds, world_of
from khepera_forage.envs.forager import Forager
from khepera_forage.envs.layouts import arena_map_of, checked_options, given_places
from khepera_forage.geometry.paths import ChosenWaypoint
from khepera_forage.records import columns_of, dtype_of
from khepera_forage.robots.khepera import ARM_DOWN, JAW_OPEN, Motors
from khepera_forage.sim.arena import Arena, Point, Pose
from khepera_forage.sim.compiled.world import CompiledWorld
from khepera_forage.sim.simulation import SimulatedKhepera
from khepera_forage.sim.world import Layout
from khepera_forage.task.behaviours import behaviour_of_motors, decode_motors
from khepera_forage.task.decisions import Decisions
from khepera_forage.task.episode import Episode, ForagerState
from khepera_forage.task.food_tracking import FoodObject, FoodTracker, KnownFood, Link
from khepera_forage.task.perception import Marker, RawData
from khepera_forage.task.states import Behaviour, State, StateVector

_LEAST = 512
"""Worlds for which another thread pays."""


@dataclass(slots=True)
class _Turn:
    """What one world does in one round.

    Attributes:
        world: Its number.
        place: Of its arena, see `arena_at`.
        begins: A new episode, in place of an action.
        start_given: Where it begins: the robot stands where it starts; otherwise it starts at a random place.
        foods_given: Likewise for the food.
        behaviour: The action; -1 if that is `motors`.
        motors: Four numbers in -1..1.
        no_room: Written by the round: there was none for a new episode.
    """

    world: int = 0
    place: int = 0
    begins: bool = False
    start_given: bool = False
    foods_given: bool = False
    behaviour: int = Behaviour.WAIT.value
    motors: list[float] = field(default_factory=lambda: [0.0] * 4)
    no_room: bool = False


class CompiledBatch:
    """Recalls in many worlds. Each has one episode after another, with random numbers of its own.

    Args:
        num_worlds: How many.
        settings: From the user.
        foods: Food objects in each, 1 to 16.
        limit: Steps after which an episode ends.

    Attributes:
        worlds: Their records.
        largest_diagonal: Of all arenas in which an episode may take place, in pixels.

    Raises:
        ValueError: An argument out of range.
    """

    def __init__(self, num_worlds: int, settings: Settings, foods: int, limit: int) -> None:
        self.num_worlds = whole_number("num_worlds", num_worlds, 1)
        self.settings, self.foods, self.limit = settings, foods, limit
        self._record = settings_record(settings, foods, limit, settings.decisions.recall_marker)
        pool = ArenaPool(settings.arena, settings.decisions)
        self.largest_diagonal = pool.diagonal
        self._arenas = PreparedArenas(pool)
        self.worlds = new_worlds(self.num_worlds, foods)
        self._turns = np.zeros(self.num_worlds, dtype_of(_Turn))
        self._turns["world"] = np.arange(self.num_worlds)
        self._seeds: dict[int, int] = {}
        """Of worlds that were seeded and not restarted since."""

    @property
    def arenas(self) -> list[Arena]:
        """The arena in which each world is."""
        return [self._arenas.arena(place) for place in self._turns["place"].tolist()]

    def world(self, number: int) -> WorldRecords:
        """The records of one world, which share its memory."""
        return world_of(self.worlds, number)

    def seed(self, seeds: Mapping[int, int]) -> None:
        """Seed some worlds: from their next restart on they have the episodes of single environments with these seeds.

        Args:
            seeds: One at least 0 by the number of each world.
        """
        self._seeds.update(seeds)

    def restart(self, worlds: NDArray[np.int64], options: Mapping[str, Any] | None = None) -> None:
        """Begin new episodes in some worlds, up to their first observation; the others stay unchanged.

        Args:
            worlds: Their numbers.
            options: `start` and `foods` as for the environments; what is left out is random.

        Raises:
            ValueError: Options that are unknown or place something off the free floor, or an arena with no room. All
                worlds then stay unchanged.
        """
        self._turns["place"] = self._arenas.forget(self._turns["place"])
        kept = [part[worlds] for part in (*self.worlds, self._turns)]
        try:
            self._begin(worlds, checked_options(options))
        except ValueError:
            for part, rows in zip((*self.worlds, self._turns), kept, strict=True):
                part[worlds] = rows
            raise

    def _begin(self, worlds: NDArray[np.int64], options: Mapping[str, Any]) -> None:
        seeds = {world: self._seeds[world] for world in worlds.tolist() if world in self._seeds}
        if seeds:
            robots, foragers, seeded = self.worlds.robots[:, 0], self.worlds.foragers[:, 0], list(seeds)
            robots["key"][seeded] = keys_of(list(seeds.values()))
            robots["round"][seeded] = foragers["number"][seeded] = 0
        self._enter(worlds)
        turns = self._turns[worlds]
        start, places = None, None
        for place in np.unique(turns["place"]).tolist() if options else ():
            start, places = given_places(self._arenas.arena(place), self.foods, options)
        if start is not None:
            self.worlds.robots[["x", "y", "heading"]][worlds, 0] = tuple(start)
        for k, food in enumerate(places or ()):
            self.worlds.foods[["x", "y"]][worlds, k] = tuple(food)
        turns["begins"], turns["start_given"], turns["foods_given"] = True, start is not None, places is not None
        turns["behaviour"] = Behaviour.WAIT
        self._run(turns)
        for world in seeds:
            del self._seeds[world]

    def _enter(self, worlds: NDArray[np.int64]) -> None:
        """Let some worlds be in the arenas of their next episodes."""
        keys, numbers = self.worlds.robots["key"][worlds, 0], self.worlds.foragers["number"][worlds, 0]
        self._turns["place"][worlds] = self._arenas.of_episodes(keys, numbers)

    @property
    def foragers(self) -> Any:
        """`ForagerState` of all worlds: each field is an array with one element a world."""
        return columns_of(self.worlds.foragers[:, 0])

    @property
    def raw(self) -> Any:
        """`RawData` of all worlds, likewise."""
        return columns_of(self.worlds.raw[:, 0])

    def step(self, actions: NDArray[Any], waiting: NDArray[np.bool_]) -> None:
        """One round in every world.

        Args:
            actions: One behaviour a world, shape (worlds,), or four numbers in -1..1, shape (worlds, 4).
            waiting: Worlds that begin a new episode instead.

        Raises:
            ValueError: An arena has no room for a new episode. The other worlds have gone on.
        """
        new = waiting.nonzero()[0]
        if len(new):
            self._turns["place"] = self._arenas.forget(self._turns["place"])
            self._enter(new)
        self._turns["begins"] = waiting
        if actions.ndim == 1:
            self._turns["behaviour"] = actions
        else:
            self._turns["behaviour"], self._turns["motors"] = -1, actions
        self._run(self._turns)

    def step_alone(self, action: Sequence[float]) -> None:
        """One round in the only world of a batch: a behaviour, or four numbers in -1..1."""
        if len(action) == 1:
            self._turns["behaviour"] = action[0]
        else:
            self._turns["behaviour"], self._turns["motors"] = -1, action
        _step_worlds(0, 1, *self.worlds, self._arenas.blocks, self._record, self._turns)

    def _run(self, turns: NDArray[Any]) -> None:
        share_out(_step_worlds, len(turns), *self.worlds, self._arenas.blocks, self._record, turns, least=_LEAST)
        if turns["no_room"].any():
            raise self._arenas.no_room(turns["place"][turns["no_room"]], self.foods)


@entry
def _step_worlds(
    first: int,
    last: int,
    robots: Any,
    foragers: Any,
    raw: Any,
    foods: Any,
    trackers: Any,
    objects: Any,
    detections: Any,
    tracks: Any,
    links: Any,
    chosen: Any,
    blocks: Any,
    settings: Any,
    turns: Any,
) -> None:
    """One round in the worlds of some turns: of the one at `first`, up to the one at `last`."""
    # As arguments of their own, which numba hands over faster than a tuple.
    worlds = WorldRecords(robots, foragers, raw, foods, trackers, objects, detections, tracks, links, chosen)
    place, arena = -1, arena_at(blocks, 0)
    for k in range(first, last):
        turn = turns[k]
        world = world_of(worlds, turn.world)
        if turn.place != place:
            place, arena = turn.place, arena_at(blocks, turn.place)
        turn.no_room = turn.begins and not begin(world, arena, settings[0], turn.start_given, turn.foods_given)
        state, action = world.foragers[0].state, turn.motors
        behaviour = turn.behaviour if turn.behaviour >= 0 else state
        motors = motors_of(world, map_of(arena), settings[0], behaviour)
        if turn.behaviour < 0:
            correct, motors = motors, decode_motors(action[0], action[1], action[2], action[3])
            behaviour = behaviour_of_motors(motors, state, correct, settings[0].decisions)
        drive(world, motors, behaviour)
        carry_out(world, arena, settings[0])


class CompiledRecalls:
    """Recalls one after another in a compiled world; arguments and attributes are those of `WorldRecalls`."""

    backend = COMPILED

    def __init__(self, settings: Settings, foods: int, limit: int) -> None:
        self._batch = CompiledBatch(1, settings, foods, limit)
        self.diagonal = self._batch.largest_diagonal

    @property
    def arena(self) -> Arena:
        """That of the present episode; before the first, the first one."""
        return self._batch.arenas[0]

    @property
    def world(self) -> CompiledWorld:
        """Bodies and camera as they are now."""
        return bodies_of(self._batch.world(0), self.arena, self._batch.settings)

    @property
    def forager(self) -> Forager:
        """The robot at its task, as it is now."""
        return forager_of(self._batch.world(0), self.arena, self._batch.settings.decisions)

    @property
    def raw(self) -> RawData:
        """What the robot perceives now."""
        return raw_of(self._batch.worlds)

    def seed(self, seed: int) -> None:
        """Make the episodes that follow repeatable, bit for bit."""
        self._batch.seed({0: seed})

    def begin(self, rng: np.random.Generator, options: Mapping[str, Any] | None = None) -> ForagerState:
        """Begin the next episode, as `WorldRecalls.begin`, without `rng`: a compiled world draws its own numbers."""
        self._batch.restart(np.zeros(1, np.int64), options)
        # The robot has stood still for one round, so it is still where it started.
        worlds = self._batch.worlds
        starts, places = worlds.robots[["x", "y", "heading"]], worlds.foods[["x", "y"]]
        self.layout = Layout((Pose(*starts.item(0)),), tuple(Point(*place) for place in places[0].tolist()))
        return state_of(worlds)

    def step(self, action: Sequence[float]) -> ForagerState:
        """One round under the number of a behaviour, or four numbers in -1..1."""
        self._batch.step_alone(action)
        return state_of(self._batch.worlds)


def state_of(world: WorldRecords) -> ForagerState:
    """The robot of a compiled world at its task, in Python's numbers."""
    own, vector, state, behaviour, number, episode = world.foragers.item(0)
    return ForagerState(Marker(*own), StateVector(*vector), state, behaviour, number, Episode(*episode))


def raw_of(world: WorldRecords) -> RawData:
    """What the robot of a compiled world perceives, in Python's numbers."""
    values = world.raw.item(0)
    return RawData._make(tuple(value.tolist()) if isinstance(value, np.ndarray) else value for value in values)


def forager_of(world: WorldRecords, arena: Arena, decisions: Decisions) -> Forager:
    """The robot of a compiled world at its task, as it is now."""
    robot, now = SimulatedKhepera(world.robots, 0), state_of(world)
    food = KnownFood(
        FoodTracker(*world.trackers.item(0)),
        [FoodObject(*food.item()) for food in world.objects],
        [Link(*link.item()) for link in world.links],
        [ChosenWaypoint(*chosen.item()) for chosen in world.chosen],
    )
    values = decisions.values(robot.has_gripper)
    forager = Forager(robot, arena_map_of(arena), decisions.recall_marker, food, values)
    for part in fields(ForagerState):
        setattr(forager, part.name, getattr(now, part.name))
    forager.raw, forager.state = raw_of(world), State(now.state)
    record = robot.record
    gripper = (record.arm_target, record.jaw_target) if robot.has_gripper else (ARM_DOWN, JAW_OPEN)
    forager.applied = Motors(float(record.left), float(record.right), *map(int, gripper))
    return forager


def bodies_of(world: WorldRecords, arena: Arena, settings: Settings) -> CompiledWorld:
    """Bodies and camera of a compiled world, which show its records as they are now; none before the first episode."""
    _, noise, _, decisions, model = settings
    timing = timing_of(decisions)
    bodies = CompiledWorld([arena], (decisions.recall_marker,), noise, timing=timing, model=model)
    if world.robots["holes"].all():
        bodies.show_only(world.robots, world.foods, world.tracks)
    return bodies
