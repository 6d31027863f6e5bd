"""One robot at its task: from Senses and Scene to raw data and state vector, round after round."""

import math

from khepera_forage.robots.khepera import Motors, Robot, Senses
from khepera_forage.sim.arena import Arena
from khepera_forage.task.behaviours import command
from khepera_forage.task.food_tracking import FoodRegister
from khepera_forage.task.perception import (
    RawData,
    Site,
    nearest_food,
    own_region,
    perceive,
    state_vector,
    wall_of,
)
from khepera_forage.task.states import Behaviour, State, StateVector, behaviour_for, classify
from khepera_forage.vision.scene import MM_PER_PIXEL, Region, Scene


def site_of(arena: Arena) -> Site:
    """What a robot knows of an arena from the beginning, in pixels."""
    x1, y1, x2, y2 = arena.bounds
    return Site(
        arena.home.x / MM_PER_PIXEL,
        arena.home.y / MM_PER_PIXEL,
        round(arena.home_radius / MM_PER_PIXEL),
        math.degrees(math.atan2((y1 + y2) / 2 - arena.home.y, (x1 + x2) / 2 - arena.home.x)),
        round(arena.diagonal / MM_PER_PIXEL),
        (x1 / MM_PER_PIXEL, y1 / MM_PER_PIXEL, x2 / MM_PER_PIXEL, y2 / MM_PER_PIXEL),
        tuple(
            wall_of(x1 / MM_PER_PIXEL, y1 / MM_PER_PIXEL, x2 / MM_PER_PIXEL, y2 / MM_PER_PIXEL)
            for x1, y1, x2, y2 in arena.segments
        ),
    )


class Forager:
    """Perception and motors of one robot in its own arena.

    What it perceives is of the last round: `raw`, `vector`, and the `state` that the teacher would classify it as.

    Args:
        robot: The body.
        site: Its arena.
        holes: Of its marker.
        register: Of the food in its arena.
    """

    def __init__(self, robot: Robot, site: Site, holes: int, register: FoodRegister) -> None:
        self.robot = robot
        self.site = site
        self.register = register
        self.holes = holes
        self.own: Region
        self.raw: RawData
        self.vector: StateVector
        self.state: State
        self.senses: Senses = robot.sense()
        self.applied: Motors = robot.drive(Motors(0, 0, self.senses.arm, self.senses.jaw))

    def seen(self, scene: Scene) -> bool:
        """Whether the camera has found the robot yet."""
        return own_region(scene, self.site, self.holes) is not None

    @property
    def correct_behaviour(self) -> Behaviour:
        """What the teacher would do now."""
        return behaviour_for(self.state)

    def motors_for(self, behaviour: int) -> Motors:
        """What a behaviour commands now."""
        return command(behaviour, self.raw)

    def drive(self, motors: Motors) -> None:
        """Command the motors for the coming round."""
        self.applied = self.robot.drive(motors)

    def perceive(self, scene: Scene) -> None:
        """Take in the round that is over."""
        before, self.senses = self.senses, self.robot.sense()
        own = own_region(scene, self.site, self.holes)
        if own is None:
            raise RuntimeError("the camera's scene has lost all trace of the robot's marker")
        self.own = own
        register = self.register
        register.update(scene, own, before, self.senses, self.applied)
        food = nearest_food(scene, self.site, own.x, own.y, register.settled)
        self.raw = perceive(self.senses, own, food, register.type_in_gripper, self.site)
        self.vector = state_vector(self.raw, self.site.diagonal)
        self.state = classify(self.vector, self.site.home_radius)
