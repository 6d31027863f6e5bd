"""A single compiled world behind `RecallEnv`: world 0 of a batch, bit for bit; and compiled worlds as objects."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from khepera_forage.envs.arena_pool import Arenas
from khepera_forage.envs.arguments import COMPILED, FoodOdds, timing_of
from khepera_forage.envs.compiled.batch import CompiledBatch
from khepera_forage.envs.compiled.worlds import World
from khepera_forage.envs.forager import Forager, arena_map_of
from khepera_forage.envs.recalls import Shown
from khepera_forage.geometry.angles import bearing_of, turn_to
from khepera_forage.geometry.paths import ChosenWaypoint
from khepera_forage.noise import Noise
from khepera_forage.robots.model import KHEPERA
from khepera_forage.sim.arena import Arena, Point
from khepera_forage.sim.camera import marker_region
from khepera_forage.sim.compiled.world import CompiledWorld
from khepera_forage.sim.simulation import SimulatedKhepera
from khepera_forage.sim.world import Layout
from khepera_forage.task.decisions import Decisions
from khepera_forage.task.food_tracking import FoodObject, FoodTracker, Link
from khepera_forage.task.perception import RawData
from khepera_forage.task.states import State, StateVector
from khepera_forage.task.way_finding import way_home

_FIRST = np.zeros(1, np.int64)
"""The only world of a batch of one."""
_WAITING = np.zeros(1, np.bool_)


class CompiledRecalls:
    """Recalls one after another in a compiled world; arguments and attributes are those of `WorldRecalls`."""

    backend = COMPILED
    layout: Layout

    def __init__(
        self,
        arena: Arenas,
        foods: int,
        limit: int,
        noise: Noise | str | None,
        food_types: FoodOdds,
        decisions: Decisions,
        robot: str = KHEPERA.name,
    ) -> None:
        self._batch = CompiledBatch(1, arena, foods, limit, noise, food_types, decisions, robot)
        self._noise, self._decisions = noise, decisions
        self.largest_diagonal = self._batch.largest_diagonal
        self._actions = {count: np.zeros((1, count)) for count in (1, 4)}
        self._enter()

    @property
    def forager(self) -> Forager:
        """The robot at its task, as it is now."""
        return forager_of(self._batch.world(0), self.arena, self._decisions)

    def seed(self, seed: int) -> None:
        """Make the episodes that follow repeatable, bit for bit."""
        self._batch.seed([seed], _FIRST)

    def begin(self, rng: np.random.Generator, options: Mapping[str, Any] | None = None) -> Shown:
        """Begin the next episode.

        Args:
            rng: Not used: a compiled world draws its own random numbers.
            options: `start` and `foods` as for the environments; what is left out is random.

        Raises:
            ValueError: Options that are unknown or place something off the free floor, or an arena with no room.
        """
        self._batch.restart(_FIRST, options)
        self._enter()
        # The robot has stood still for one round, so it is still where it started.
        self.layout = Layout(self.world.poses(), tuple(Point(x, y) for x, y, _ in self.world.food_places()))
        return self.shown()

    def step(self, action: Sequence[float]) -> Shown:
        """One round under the number of a behaviour, or four numbers in -1..1."""
        numbers = self._actions[len(action)]
        numbers[0] = action
        return Shown._make(self._batch.go_on(numbers, _WAITING).item())

    def shown(self) -> Shown:
        """What environments show of the last round."""
        return Shown._make(self._batch.shown.item())

    def _enter(self) -> None:
        """Make arena and bodies those of the world."""
        self.arena = self._batch.arenas[0]
        self.world = bodies_of(self._batch.world(0), self.arena, self._noise, self._decisions)

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        self._enter()  # a copied world would show records of its own


def forager_of(world: World, arena: Arena, decisions: Decisions) -> Forager:
    """The robot of a compiled world at its task, as it is now.

    Args:
        world: Its records.
        arena: Its arena.
        decisions: Of the task.
    """
    record, arena_map = world.foragers[0], arena_map_of(arena)
    tracker = FoodTracker(*record["tracker"].item())
    tracker.foods = [FoodObject(*food.item()) for food in world.objects]
    tracker.links = [Link(*link.item()) for link in world.links]
    tracker.chosen = [ChosenWaypoint(*chosen.item()) for chosen in world.chosen]
    robot = SimulatedKhepera(world.robots[0])
    values = decisions.values(robot.has_gripper)
    forager = Forager(robot, arena_map, decisions.recall_marker, tracker, values)
    forager.own = marker_region(0, world.robots[0])
    numbers = (tuple(value.tolist()) if hasattr(value, "tolist") else value for value in record["raw"].item())
    raw = RawData._make(numbers)
    # Compiled worlds look up the way home when a behaviour uses it.
    x, y, path = way_home(raw.x, raw.y, tracker, tracker.foods, tracker.chosen, arena_map)
    forager.raw = raw._replace(
        home_bearing=turn_to(bearing_of(x - raw.x, y - raw.y), raw.orientation),
        home_path=max(path, raw.home_distance),
    )
    forager.vector = StateVector(*record["vector"].item())
    forager.state = State(int(record["state"]))
    return forager


def bodies_of(world: World, arena: Arena, noise: Noise | str | None, decisions: Decisions) -> CompiledWorld:
    """Bodies and camera of a compiled world, which show its records as they are now.

    Args:
        world: Its records; nothing is shown before the first episode.
        arena: Its arena.
        noise: Of its devices.
        decisions: Of the task.
    """
    bodies = CompiledWorld([arena], (decisions.recall_marker,), noise, timing=timing_of(decisions))
    if world.robots["holes"].all():
        bodies.show_only(world.robots, world.foods, world.tracks)
    return bodies
