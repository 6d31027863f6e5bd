"""The Khepera with its gripper turret: geometry, limits, what it senses, what it is told, and the Robot contract.

Figures are those of the Khepera I (thesis 3.2) where sources differ between models. Millimetres, radians and
seconds; x is forward and y left of the robot's centre.
"""

import math
from typing import NamedTuple, Protocol

# The body (thesis 3.2; sources KSIM2, K-Team).
RADIUS = 27.5
MASS = 0.07
"""Kilograms (3.2)."""
WHEEL_BASE = 53.0
SPEED_UNIT = 8.0
"""mm/s of one speed unit of the protocol's command D (K-Team)."""
MAX_SPEED = 20
"""Speed units beyond which no driver of the sources goes."""
PULSE = 0.08
"""mm of wheel travel per encoder pulse (Khepera II manual)."""
CONTROL_PERIOD = 0.1
"""Seconds of one round: our decision, see the table of decisions in the README."""

# The gripper turret. Positions are on the read scale of the turret (thesis 4.2.2).
ARM_DOWN = 255
ARM_RAISED = 215
ARM_ON_FLOOR = 235
"""The arm's fingers reach down to food height (23 mm) at this position and beyond: by KIKS' angle law a tip
66 mm out from a pivot 22 mm high is 23 mm above the floor near 240; rounded towards the raised arm."""
ARM_SPEED = 40.0
"""Positions a second: one second between raised and lowered (KNET and Webots wait 1 s for an arm)."""
JAW_OPEN = 200
JAW_CLOSED = 0
JAW_SPEED = 333.0
"""Positions a second: 0.6 s from open to closed (KNET)."""
JAW_ROOT = 38.0
"""Where the fingers start, forward of the centre (Webots)."""
FINGER_LENGTH = 37.0
"""KIKS; the tip is then 75 mm out, within the sources' 68 to 85."""
FINGER_TIP = JAW_ROOT + FINGER_LENGTH
FINGER_THICKNESS = 4.0
BARRIER = JAW_ROOT + 15.0
"""The optical barrier, 15 mm along the fingers (Webots)."""
PRESENT = 255
"""ObjectPresence while the optical barrier is interrupted; otherwise 0 (4.2.2)."""

# Food (3.1).
FOOD_RADIUS = 17.5
FOOD_HEIGHT = 23.0

# The marker on a robot's back (figure 3.9).
MARKER_LENGTH = 120.0
MARKER_WIDTH = 80.0


def half_gap(jaw: float) -> float:
    """Half the opening between the fingers in mm at a jaw position 0..200 (KIKS' law: 0.5 to 27.5 mm)."""
    return 0.5 + 0.135 * jaw


JAW_ON_FOOD = (FOOD_RADIUS - 0.5) / 0.135
"""Where the jaw stops when it closes on food (near 126)."""


class Motors(NamedTuple):
    """What a robot is told to do until it is told otherwise.

    Attributes:
        left: Speed of the left wheel in speed units (8 mm/s), -20..20.
        right: Speed of the right wheel.
        arm: Where the arm shall go, 255 (down in front) to 215 (raised).
        jaw: Where the jaw shall go, 200 (open) or 0 (closed).
    """

    left: float
    right: float
    arm: int
    jaw: int


class Senses(NamedTuple):
    """What a robot reports of itself.

    Attributes:
        proximity: Eight infra-red readings 0..1023, clockwise from the left: left 90, 45 and 10 degrees, right
            10, 45 and 90, back right, back left (the order of command N).
        left_pulses: Encoder of the left wheel, counts of 0.08 mm.
        right_pulses: Encoder of the right wheel.
        arm: Position of the arm, 255 (down) to 215 (raised).
        jaw: Position of the jaw, 200 (open) to 0 (closed).
        object_presence: 255 while the optical barrier is interrupted, otherwise 0.
    """

    proximity: tuple[int, int, int, int, int, int, int, int]
    left_pulses: int
    right_pulses: int
    arm: int
    jaw: int
    object_presence: int


def applicable(motors: Motors) -> Motors:
    """The command as a Khepera takes it: whole speed units within limits, arm within its travel, jaw open or shut.

    Args:
        motors: Finite numbers; see `check_finite`.
    """
    left = max(-MAX_SPEED, min(MAX_SPEED, math.floor(motors.left + 0.5)))
    right = max(-MAX_SPEED, min(MAX_SPEED, math.floor(motors.right + 0.5)))
    arm = max(ARM_RAISED, min(ARM_DOWN, math.floor(motors.arm + 0.5)))
    return Motors(left, right, arm, JAW_OPEN if motors.jaw > JAW_OPEN / 2 else JAW_CLOSED)


def check_finite(motors: Motors) -> None:
    """Complain about a command that is not made of finite numbers.

    Raises:
        ValueError: It is not.
    """
    left, right, arm, jaw = motors
    if not (left - left == 0 and right - right == 0 and arm - arm == 0 and jaw - jaw == 0):
        raise ValueError(f"{motors} cannot be driven: every value must be a finite number")


class RobotLost(ConnectionError):  # noqa: N818 (what happened, in the words of whoever catches it)
    """A real robot no longer answers, or its line is gone.

    Args:
        port: Where it was.
        command: What it was asked last.
        tries: How often it was asked.
        reason: What came instead of an answer.
    """

    def __init__(self, port: str, command: str, tries: int, reason: str) -> None:
        super().__init__(f"{port}: no answer to {command!r} after {tries} tries: {reason}")
        self.port = port
        self.command = command
        self.tries = tries
        self.reason = reason


class Robot(Protocol):
    """A Khepera with a gripper, simulated or real. Any method of a real one may raise `RobotLost`."""

    def sense(self) -> Senses:
        """What the robot senses now."""
        ...

    def drive(self, motors: Motors) -> Motors:
        """Command the motors, from the next `World.advance` on; returns what is really applied."""
        ...

    def stop(self) -> None:
        """Wheels to zero, at once; arm and jaw are not commanded: they finish what they were told."""
        ...

    def close(self) -> None:
        """Stop, and let go of the robot; a second call does nothing."""
        ...
