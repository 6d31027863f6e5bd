"""A compiled world as objects: the robot at its task, as `envs.forager.Forager`, and the `World` of its bodies."""

from typing import Any

from khepera_forage.envs.arguments import timing_of
from khepera_forage.envs.compiled.worlds import World
from khepera_forage.envs.forager import arena_map_of
from khepera_forage.geometry.angles import bearing_of, turn_to
from khepera_forage.geometry.paths import ChosenWaypoint
from khepera_forage.noise import Noise
from khepera_forage.robots.khepera import Motors
from khepera_forage.sim.arena import Arena
from khepera_forage.sim.compiled.world import CompiledWorld
from khepera_forage.sim.simulation import SimulatedKhepera
from khepera_forage.task.behaviours import command
from khepera_forage.task.decisions import Decisions
from khepera_forage.task.food_links import Link
from khepera_forage.task.food_tracking import FoodObject, FoodTracker
from khepera_forage.task.perception import RawData
from khepera_forage.task.states import Behaviour, State, StateVector, behaviour_for
from khepera_forage.task.way_finding import WayMemory, way_home


class CompiledForager:
    """One robot at its task, as it was when this object was made.

    Args:
        world: Its records.
        arena: Its arena.
        decisions: Of the task.

    Attributes:
        arena: What the robot knows of its arena.
        senses: What it senses.
        tracker: The food tracker of its arena.
        raw: Raw data of the last round.
        vector: State vector of the last round.
        state: What the teacher would classify it as.
    """

    def __init__(self, world: World, arena: Arena, decisions: Decisions) -> None:
        forager = world.foragers[0]
        self.arena = arena_map_of(arena)
        self.holes = decisions.recall_marker
        self.decisions = decisions.values()
        self.senses = SimulatedKhepera(world.robots[0]).sense()
        self.tracker = FoodTracker(*forager["tracker"].item())
        self.tracker.foods = [FoodObject(*food.item()) for food in world.objects]
        self.tracker.links = [Link(*link.item()) for link in world.links]
        self.tracker.memory = WayMemory(
            [ChosenWaypoint(*chosen.item()) for chosen in world.chosen], world.lengths.tolist()
        )
        self.raw = self._raw(RawData(*_values(forager["raw"])))
        self.vector = StateVector(*forager["vector"].item())
        self.state = State(int(forager["state"]))

    @property
    def correct_behaviour(self) -> Behaviour:
        """What the teacher would do now."""
        return behaviour_for(self.state)

    def motors_for(self, behaviour: int) -> Motors:
        """What a behaviour commands now."""
        return command(behaviour, self.raw, self.decisions)

    def _raw(self, raw: RawData) -> RawData:
        """Raw data with the way home, which compiled worlds look up when a behaviour uses it."""
        x, y, path = way_home(raw.x, raw.y, self.tracker, self.tracker.foods, self.tracker.memory, self.arena)
        return raw._replace(
            home_bearing=turn_to(bearing_of(x - raw.x, y - raw.y), raw.orientation),
            home_path=max(path, raw.home_distance),
        )


def world_of_records(
    records: World, arena: Arena, noise: Noise | str | None, decisions: Decisions
) -> CompiledWorld:
    """The bodies and the camera of a world, which show its records as they are now.

    Args:
        records: Its records; nothing is shown before the first episode.
        arena: Its arena.
        noise: Of its devices.
        decisions: Of the task.
    """
    world = CompiledWorld([arena], (decisions.recall_marker,), noise, timing=timing_of(decisions))
    if records.robots["holes"].all():
        world.show_only(records.robots, records.foods, records.tracks)
    return world


def _values(record: Any) -> Any:
    """The values of a record as Python's own, with tuples for arrays."""
    return (tuple(value.tolist()) if hasattr(value, "tolist") else value for value in record.item())
