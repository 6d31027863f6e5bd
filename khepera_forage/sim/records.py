"""The records of simulated bodies: robots, food, and the numbers of noise and timing that all robots share.

On pymunk they are these classes, on compiled worlds records of numpy arrays with the same fields (`records.dtype_of`).
Units are millimetres, radians and seconds unless a comment says otherwise.
"""

from dataclasses import dataclass, field
from typing import Any, NamedTuple

from khepera_forage.noise import Noise
from khepera_forage.records import Word, blank
from khepera_forage.robots.khepera import ARM_RAISED, JAW_OPEN, Senses
from khepera_forage.robots.model import KHEPERA, RobotModel
from khepera_forage.sim.world import Timing


@dataclass(slots=True)
class RobotState:
    """One robot: its body, its senses, and its marker as the camera shows it.

    Attributes:
        x: Centre.
        y: Centre.
        heading: Counter-clockwise from the x axis.
        cos: Of the heading.
        sin: Of the heading.
        arm: Position of the arm, 255 (down) to 215 (raised).
        jaw: Position of the jaw, 200 (open) to 0 (closed).
        held: Number of the food object between the closed fingers; -1 without.
        grip_x: Place of held food in the robot's frame.
        grip_y: Likewise.
        bias_left: Lasting error of the left wheel, as a share of its travel.
        bias_right: Likewise.
        left_wheel_error: Part of `bias_left`: a deviation of this robot (`RobotParameters`), as are the next three.
        infra_red_error: `infra_red_gain` - 1.
        arm_reading_error: `arm_reading_scale` - 1.
        finger_shortage: How much shorter than usual its fingers are.
        left_pulses: Encoder counter of the left wheel.
        right_pulses: Likewise.
        left: Motor command as applied, in speed units; also `right`, `arm_target` and `jaw_target`.
        right: Likewise.
        arm_target: Likewise.
        jaw_target: Likewise.
        forward: Speed to which the wheels pull in this round, mm/s.
        turn: Likewise, rad/s.
        marker_x: Centre of its marker as last shown, pixels.
        marker_y: Likewise.
        marker_heading: Whole degrees.
        marker_found: Whether the last frame showed the marker: it is not lost, and in the picture.
        marker_lost: Whether the tracker does not see the marker at present.
        first_frame: Whether the coming frame is the first after a reset.
        next_label: Label of the next new track of food; counted by the first robot of an arena.
        holes: Of its marker, 1 or 2.
        has_gripper: Whether it has a gripper. Without one, arm and jaw stay raised and open, where they touch nothing.
        wheel_base: Distance of its wheels, mm.
        max_speed: Highest speed of its wheels, in speed units.
        key: Of the random numbers of its world.
        round: Rounds since the key was set.
        response: Of each infra-red to what is before it, without noise; holds nothing between rounds.
        senses: What it senses, at the end of the last round.
    """

    x: float = 0.0
    y: float = 0.0
    heading: float = 0.0
    cos: float = 1.0
    sin: float = 0.0
    arm: float = ARM_RAISED
    jaw: float = JAW_OPEN
    held: int = -1
    grip_x: float = 0.0
    grip_y: float = 0.0
    bias_left: float = 0.0
    bias_right: float = 0.0
    left_wheel_error: float = 0.0
    infra_red_error: float = 0.0
    arm_reading_error: float = 0.0
    finger_shortage: float = 0.0
    left_pulses: float = 0.0
    right_pulses: float = 0.0
    left: float = 0.0
    right: float = 0.0
    arm_target: float = ARM_RAISED
    jaw_target: float = JAW_OPEN
    forward: float = 0.0
    turn: float = 0.0
    marker_x: float = 0.0
    marker_y: float = 0.0
    marker_heading: float = 0.0
    marker_found: bool = False
    marker_lost: bool = False
    first_frame: bool = False
    next_label: int = 0
    holes: int = 1
    has_gripper: bool = True
    wheel_base: float = KHEPERA.plan_base
    max_speed: float = KHEPERA.max_speed
    key: Word = 0
    round: int = 0
    response: list[float] = field(default_factory=lambda: [0.0] * 8)
    senses: Senses = field(default_factory=lambda: blank(Senses))


@dataclass(slots=True)
class FoodState:
    """One food object, and what the camera shows of it.

    Attributes:
        x: Centre.
        y: Centre.
        lost: Whether the tracker does not see it at present.
    """

    x: float = 0.0
    y: float = 0.0
    lost: bool = False


@dataclass(slots=True)
class FoodDetection:
    """What a frame shows of a food object, in pixels: the fields of `vision.association.Detection` that tracks need."""

    x: float = 0.0
    y: float = 0.0
    holes: int = 0
    first_x: float = 0.0
    first_y: float = 0.0


@dataclass(slots=True)
class Constants:
    """Sizes and rates of noise, how the bodies move in time, and what kind of robots they are.

    Attributes:
        noise: Sizes and rates.
        timing: Duration of a round, and speeds of arm and jaw.
        has_gripper: As in `RobotModel`; so are the others.
        wheel_base: On the plan, mm.
        max_speed: Likewise.
        reach: Likewise.
        sensors: The infra-reds: mm forward and left, cosine and sine of each one's direction, one after another.
    """

    noise: Noise
    timing: Timing
    has_gripper: bool
    wheel_base: float
    max_speed: float
    reach: float
    sensors: list[float] = field(default_factory=lambda: [v for sensor in KHEPERA.sensors for v in sensor])


class Enclosure(NamedTuple):
    """Everything in one arena of a world.

    Attributes:
        robots: `RobotState` records.
        foods: `FoodState` records.
        tracks: `Track` records of food, twice as many as food objects.
        detections: `FoodDetection` records, one a food object; they hold nothing between rounds.
        walls: `Wall` records in mm.
        corners: The corners that point into the floor, records with `x` and `y` in mm.
    """

    robots: Any
    foods: Any
    tracks: Any
    detections: Any
    walls: Any
    corners: Any


def constants_of(noise: Noise, timing: Timing, model: RobotModel) -> Constants:
    """The `Constants` of worlds with robots of a kind."""
    return Constants(
        noise,
        timing,
        model.has_gripper,
        model.plan_base,
        model.max_speed,
        model.reach,
        [value for sensor in model.sensors for value in sensor],
    )
