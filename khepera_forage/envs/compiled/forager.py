"""The robot of a compiled world at its task: what `envs.forager.Forager` offers, read from records."""

from typing import Any

from khepera_forage.envs.compiled.one_world import OneWorld
from khepera_forage.envs.compiled.records import VECTOR
from khepera_forage.envs.forager import arena_map_of
from khepera_forage.geometry.known_ways import StraightWay
from khepera_forage.geometry.nearest_wall import NearestWall
from khepera_forage.robots.khepera import Motors, Senses
from khepera_forage.sim.arena import Arena
from khepera_forage.task.behaviours import command
from khepera_forage.task.decisions import Decisions
from khepera_forage.task.food_links import Link
from khepera_forage.task.food_tracking import FoodObject, FoodTracker
from khepera_forage.task.perception import raw_data
from khepera_forage.task.states import Behaviour, State, StateVector, behaviour_for
from khepera_forage.task.way_finding import KnownWays, way_home


class CompiledForager:
    """One robot at its task, as it was when this object was made.

    Args:
        world: The compiled world.
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

    def __init__(self, world: OneWorld, arena: Arena, decisions: Decisions) -> None:
        worlds = world.worlds
        robot, task = worlds.bodies.robots[0], worlds.tasks[0]
        self.arena = arena_map_of(arena)
        self.holes = decisions.recall_marker
        self.decisions = decisions.values()
        proximity = [int(reading) for reading in robot["proximity"][:, 0]]
        self.senses = Senses(
            tuple(proximity),  # type: ignore[arg-type]
            *(round(_of(robot, name)) for name in ("pulses_left", "pulses_right")),
            *(int(_of(robot, name)) for name in ("arm_reading", "jaw_reading", "object_presence")),
        )
        self.tracker = FoodTracker(*worlds.trackers[0, 0].item())
        self.tracker.foods = [FoodObject(*food.item()) for food in worlds.foods[0, 0]]
        self.tracker.nearest_wall = NearestWall(*worlds.nearest_walls[0, 0].item())
        self.tracker.known_ways = KnownWays(
            [StraightWay(*way.item()) for way in worlds.straight_ways[0, 0]],
            [StraightWay(*way.item()) for way in worlds.to_waypoints[0, 0]],
            worlds.food_lengths[0, 0].tolist(),
        )
        self.tracker.links = [Link(*link.item()) for link in worlds.links[0, 0]]
        x, y = _of(robot, "marker_x"), _of(robot, "marker_y")
        self.raw = raw_data(
            self.senses,
            x,
            y,
            int(_of(robot, "marker_heading")),
            _of(robot, "marker_found") != 0,
            _of(task, "food_seen") != 0,
            _of(task, "food_x"),
            _of(task, "food_y"),
            int(_of(task, "food_type")),
            _of(task, "wall_x"),
            _of(task, "wall_y"),
            # Kernels only look it up when a behaviour uses it.
            way_home(x, y, self.tracker, self.tracker.foods, self.tracker.known_ways, self.arena),
            (_of(task, "food_way_x"), _of(task, "food_way_y"), _of(task, "food_path")),
            self.arena,
        )
        self.vector = StateVector(*(int(_of(task, name)) for name in VECTOR))
        self.state = State(int(_of(task, "state")))

    @property
    def correct_behaviour(self) -> Behaviour:
        """What the teacher would do now."""
        return behaviour_for(self.state)

    def motors_for(self, behaviour: int) -> Motors:
        """What a behaviour commands now."""
        return command(behaviour, self.raw, self.decisions)


def _of(record: Any, name: str) -> float:
    return float(record[name][0])
