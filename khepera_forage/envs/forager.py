"""One robot at its task: from `Senses` and `Scene` to raw data, state vector and state, round after round."""

import math
from collections.abc import Sequence
from functools import lru_cache

from khepera_forage.robots.khepera import Motors, Robot, Senses
from khepera_forage.sim.arena import Arena
from khepera_forage.sim.ways import is_home_free, pixel_walls, way_out, ways_of
from khepera_forage.task.arena_map import EVERY_SIDE, OUTSIDE, ArenaMap, Floor, whole_pixels
from khepera_forage.task.behaviours import command
from khepera_forage.task.decisions import DecisionValues
from khepera_forage.task.food_tracking import FoodTracker, explored, share_identified, update_food
from khepera_forage.task.perception import RawData, own_region, perceive, state_vector, without_food
from khepera_forage.task.states import Behaviour, State, StateVector, behaviour_for, classify
from khepera_forage.vision.scene import MM_PER_PIXEL, Region, Scene


@lru_cache(maxsize=1 << 14)
def arena_map_of(arena: Arena) -> ArenaMap:
    """What a robot knows of an arena from the beginning, in pixels."""
    x1, y1, x2, y2 = arena.bounds
    return ArenaMap(
        arena.home.x / MM_PER_PIXEL,
        arena.home.y / MM_PER_PIXEL,
        whole_pixels(arena.home_radius),
        arena.start.x / MM_PER_PIXEL,
        arena.start.y / MM_PER_PIXEL,
        _home_opening(arena),
        whole_pixels(arena.diagonal),
        x1 / MM_PER_PIXEL - OUTSIDE,
        y1 / MM_PER_PIXEL - OUTSIDE,
        x2 / MM_PER_PIXEL + OUTSIDE,
        y2 / MM_PER_PIXEL + OUTSIDE,
        pixel_walls(arena),
        ways_of(arena),
    )


def _home_opening(arena: Arena) -> float:
    if is_home_free(arena):
        return EVERY_SIDE
    out_x, out_y = way_out(arena)
    return math.degrees(math.atan2(out_y - arena.home.y, out_x - arena.home.x))


@lru_cache(maxsize=1 << 14)
def floor_of(arena: Arena) -> Floor:
    """The floor of an arena, in mm."""
    return Floor(*arena.bounds, arena.home.x, arena.home.y, arena.home_radius, arena.wall_records)


class Forager:
    """Perception and motors of one robot in its own arena.

    Args:
        robot: The body.
        arena: What it knows of its arena.
        holes: Of its marker.
        tracker: The food tracker of its arena.
        decisions: Of the task.

    Attributes:
        own: Its marker's region.
        raw: Raw data of the last round.
        vector: State vector of the last round.
        state: What the teacher would classify it as.
    """

    def __init__(
        self, robot: Robot, arena: ArenaMap, holes: int, tracker: FoodTracker, decisions: DecisionValues
    ) -> None:
        self.robot = robot
        self.arena = arena
        self.tracker = tracker
        self.holes = holes
        self.decisions = decisions
        self.own: Region
        self.raw: RawData
        self.vector: StateVector
        self.state: State
        self.senses: Senses = robot.sense()
        self.applied = Motors(0, 0, self.senses.arm, self.senses.jaw)

    @property
    def correct_behaviour(self) -> Behaviour:
        """What the teacher would do now."""
        return behaviour_for(self.state)

    def motors_for(self, behaviour: int) -> Motors:
        """What a behaviour commands now."""
        return command(behaviour, self.raw, self.decisions)

    def drive(self, motors: Motors) -> None:
        """Command the motors for the coming round."""
        self.applied = self.robot.drive(motors)

    def perceive(self, scene: Scene) -> None:
        """Perceive what the last round has brought.

        Raises:
            RuntimeError: The scene has no marker of the robot.
        """
        before, self.senses = self.senses, self.robot.sense()
        own = own_region(scene, self.arena, self.holes)
        if own is None:
            raise RuntimeError("the camera's scene has lost all trace of the robot's marker")
        self.own = own
        tracker, present = self.tracker, self.senses.object_presence != 0
        update_food(
            tracker,
            tracker.foods,
            tracker.chosen,
            tracker.links,
            scene.regions,
            self.arena,
            own.x,
            own.y,
            own.orientation,
            present,
            present and explored(before, self.senses, self.applied),
            self.senses.arm,
            self.decisions,
        )
        self.raw = perceive(self.senses, own, tracker, self.arena)
        self.vector = state_vector(
            self.raw, without_food(tracker, self.arena, self.decisions), self.decisions
        )
        self.state = classify(self.vector, self.arena.home_radius, self.decisions)


def perceive_all(foragers: Sequence[Forager], scene: Scene) -> None:
    """Let the robots of paired arenas perceive what the last round has brought.

    What one identifies, the next ones know at once, and the others a round later.

    Raises:
        RuntimeError: The scene has no marker of a robot.
    """
    for forager in foragers:
        forager.perceive(scene)
        for other in foragers:
            if other is not forager:
                share_identified(forager.tracker.foods, other.tracker.foods)
