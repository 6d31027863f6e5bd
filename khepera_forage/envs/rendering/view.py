"""Content of a picture as plain values, which environments fill in without drawing anything."""

from typing import NamedTuple

from khepera_forage.sim.arena import Arena, Pose
from khepera_forage.task.states import Behaviour, FoodType, State, StateVector
from khepera_forage.vision.scene import Region


class RobotView(NamedTuple):
    """One robot: its true pose, its senses, and its decision.

    Attributes:
        pose: True position (mm) and heading (radians). With values that are not finite only the panel is drawn.
        holes: Number of holes in its marker: 1 on the teacher, 2 on a learner.
        arm: 255 (down) to 215 (raised).
        jaw: 200 (open) to 0 (closed).
        proximity: The eight infra-red readings 0..1023, in the order of `Senses`.
        name: For example "teacher" or "learner 1".
        vector: The state vector of its decision; None if there is none yet.
        state: The state to which the vector belongs.
        heard: The behaviour heard, with WAIT for silence; None in a task without a teacher.
        executed: The behaviour executed; None before the first.
        confidence: Confidence level of each behaviour, SEARCH FOR FOOD first; None if the robot is no imitator.
        separated: Whether the learner is separated from the teacher.
        tracked: Whether the camera tracks its marker now.
        note: Short text beside its name.
    """

    pose: Pose
    holes: int
    arm: float
    jaw: float
    proximity: tuple[int, ...]
    name: str
    vector: StateVector | None = None
    state: State | None = None
    heard: Behaviour | None = None
    executed: Behaviour | None = None
    confidence: tuple[float, ...] | None = None
    separated: bool = False
    tracked: bool = True
    note: str = ""


class FoodView(NamedTuple):
    """One food object at its true position.

    Attributes:
        x: Centre in mm.
        y: Centre in mm.
        food_type: Its identified type; UNKNOWN before identification.
        lifted: Whether a gripper holds it above the floor.
        delivered: Whether it counts as delivered.
    """

    x: float
    y: float
    food_type: FoodType = FoodType.UNKNOWN
    lifted: bool = False
    delivered: bool = False


class View(NamedTuple):
    """Everything that one picture shows.

    The size of the picture depends only on the arenas and on the number of robots, so that all pictures of an episode
    have the same size.

    Attributes:
        arenas: At least one.
        robots: One panel each, in this order.
        foods: Every object on the floor or in a gripper.
        regions: Regions reported by the camera, in its pixels of 5 mm.
        step: Number of steps so far.
        limit: Greatest number of steps, if there is a limit.
        score: In percent, if the task has a score.
        delivered: Number of food objects delivered so far.
        title: Heading of the picture.
    """

    arenas: tuple[Arena, ...]
    robots: tuple[RobotView, ...] = ()
    foods: tuple[FoodView, ...] = ()
    regions: tuple[Region, ...] = ()
    step: int = 0
    limit: int | None = None
    score: float | None = None
    delivered: int = 0
    title: str = ""
