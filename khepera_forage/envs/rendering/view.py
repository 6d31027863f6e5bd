"""What a picture shows, as plain values: an environment fills these in and knows nothing of drawing."""

from typing import NamedTuple

from khepera_forage.sim.arena import Arena, Pose
from khepera_forage.task.states import Behaviour, FoodType, State, StateVector
from khepera_forage.vision.scene import Region


class RobotView(NamedTuple):
    """One robot: its body as it truly is, what it senses, and what it decides.

    Attributes:
        pose: True place (mm) and heading (radians); not finite where nobody knows it: only its panel is then
            drawn.
        holes: In its marker: 1 on the teacher, 2 on a learner.
        arm: 255 (down) to 215 (raised).
        jaw: 200 (open) to 0 (closed).
        proximity: The eight infra-red readings 0..1023, in the order of `Senses`.
        name: Such as "teacher" or "learner 1".
        vector: The state vector it decides on; None if it has none yet.
        state: The state that the vector stands for.
        heard: The behaviour it heard, WAIT being silence; None where nobody speaks.
        executed: The behaviour it executes; None before its first.
        confidence: Confidence level of each behaviour, SEARCH FOR FOOD first; None if it is not an imitator.
        separated: Whether learner and teacher are apart.
        tracked: Whether the camera finds it now.
        note: A few further words, shown beside its name.
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
    """One food object, where it truly is.

    Attributes:
        x: Centre in mm.
        y: Centre in mm.
        food_type: What it is known to be; UNKNOWN before it is identified.
        lifted: Whether a gripper holds it off the floor.
        delivered: Whether it counts as brought home.
    """

    x: float
    y: float
    food_type: FoodType = FoodType.UNKNOWN
    lifted: bool = False
    delivered: bool = False


class View(NamedTuple):
    """All that one picture shows.

    The size of the picture depends on the arenas and on the number of robots only, so that all frames of an
    episode are alike.

    Attributes:
        arenas: At least one.
        robots: One panel each, in this order.
        foods: Every object on the floor or in a gripper.
        regions: What the camera reports, in its pixels of 5 mm.
        step: Steps so far.
        limit: Steps allowed, if there is a limit.
        score: In percent, if there is one.
        delivered: Food objects brought home so far.
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
