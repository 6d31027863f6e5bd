"""The Khepera with its gripper turret: dimensions, limits, senses, motor commands, and the `Robot` contract.

Figures are those of the Khepera I (thesis 3.2) where sources differ between models. Millimetres, radians and
seconds; x is forward and y left of the robot's centre.
"""

import math
from typing import Any, NamedTuple, Protocol

# The body (thesis 3.2; sources KSIM2, K-Team).
RADIUS = 27.5
MASS = 0.07
"""Kilograms (3.2)."""
WHEEL_BASE = 53.0
SPEED_UNIT = 8.0
"""mm/s: one speed unit of the protocol's command D (K-Team)."""
MAX_SPEED = 20
"""Speed units: the highest speed that any driver among the sources uses."""
PULSE = 0.08
"""mm of wheel travel per encoder pulse (Khepera II manual)."""
CONTROL_PERIOD = 0.1
"""Seconds of a control period of programs that have no rounds: robot commands, and the virtual robot's firmware."""

# The gripper turret. Positions are on the read scale of the turret (thesis 4.2.2).
ARM_DOWN = 255
ARM_RAISED = 215
ARM_ON_FLOOR = 235
"""From this position on, the fingers are below the top of food (23 mm): by KIKS' angle law a tip 66 mm out from a pivot
22 mm high is 23 mm above the floor near 240; rounded towards the raised arm."""
JAW_OPEN = 200
JAW_CLOSED = 0
JAW_ROOT = 38.0
"""mm from the robot's centre forward to the root of the fingers (Webots)."""
FINGER_LENGTH = 37.0
"""mm (KIKS); the tip is then 75 mm from the centre, within the sources' 68 to 85."""
FINGER_TIP = JAW_ROOT + FINGER_LENGTH
FINGER_THICKNESS = 4.0
BARRIER = JAW_ROOT + 15.0
"""mm from the centre forward to the optical barrier, 15 mm along the fingers (Webots)."""
PRESENT = 255
"""ObjectPresence while the optical barrier is interrupted; otherwise 0 (4.2.2)."""

# Food (3.1).
FOOD_RADIUS = 17.5
FOOD_HEIGHT = 23.0

# The marker on a robot's back (figure 3.9).
MARKER_LENGTH = 120.0
MARKER_WIDTH = 80.0


def half_gap(jaw: float) -> float:
    """Half the distance between the fingers in mm at a jaw position 0..200 (KIKS' law: 0.5 to 27.5 mm)."""
    return 0.5 + 0.135 * jaw


JAW_ON_FOOD = (FOOD_RADIUS - 0.5) / 0.135
"""Jaw position at which the fingers touch food (near 126)."""


class Motors(NamedTuple):
    """A motor command, which holds until the next one.

    Attributes:
        left: Speed of the left wheel in speed units (8 mm/s), -20..20.
        right: Speed of the right wheel.
        arm: Target position of the arm, 255 (down in front) to 215 (raised).
        jaw: Target position of the jaw, 200 (open) or 0 (closed).
    """

    left: float
    right: float
    arm: int
    jaw: int


class Senses(NamedTuple):
    """The readings of a robot's own sensors.

    Attributes:
        proximity: Eight infra-red readings 0..1023, clockwise from the left: left 90, 45 and 10 degrees, right
            10, 45 and 90, back right, back left (the order of command N).
        left_pulses: Encoder counter of the left wheel, pulses of 0.08 mm.
        right_pulses: Encoder counter of the right wheel.
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
    """The nearest command that a Khepera can execute: whole speed units in range, arm in range, jaw open or closed.

    Args:
        motors: Finite numbers; see `check_finite`.
    """
    left = max(-MAX_SPEED, min(MAX_SPEED, math.floor(motors.left + 0.5)))
    right = max(-MAX_SPEED, min(MAX_SPEED, math.floor(motors.right + 0.5)))
    arm = max(ARM_RAISED, min(ARM_DOWN, math.floor(motors.arm + 0.5)))
    return Motors(left, right, arm, JAW_OPEN if motors.jaw > JAW_OPEN / 2 else JAW_CLOSED)


def check_finite(motors: Motors) -> None:
    """Reject a command with a value that is not a finite number.

    Raises:
        ValueError: A value is not finite.
    """
    if not all(map(math.isfinite, motors)):
        raise ValueError(f"{motors} is not a motor command; allowed: finite numbers")


class RobotLost(ConnectionError):  # noqa: N818 (an event, not a mistake)
    """A real robot does not reply any more, or its port failed.

    Args:
        port: The robot's port.
        command: The last request; empty if no request is to blame.
        tries: How often it was sent.
        reason: Why there is no reply.
    """

    def __init__(self, port: str, command: str, tries: int, reason: str) -> None:
        if tries:
            event = f"no answer to {command!r} after {tries} {'try' if tries == 1 else 'tries'}: {reason}"
        else:
            event = f"{command!r} was not sent: {reason}" if command else reason
        super().__init__(f"{port}: {event}")
        self.port = port
        self.command = command
        self.tries = tries
        self.reason = reason

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (self.port, self.command, self.tries, self.reason), {"args": self.args}


class Robot(Protocol):
    """A robot, simulated or real. Any method of a real one may raise `RobotLost`."""

    @property
    def has_gripper(self) -> bool:
        """Whether it can pick up food; without a gripper, its arm counts as lowered, and its jaw as open."""
        ...

    def sense(self) -> Senses:
        """The current readings of the robot's sensors."""
        ...

    def drive(self, motors: Motors) -> Motors:
        """Command the motors, from the next `World.advance` on; returns the command that is really applied."""
        ...

    def stop(self) -> None:
        """Stop the wheels at once; arm and jaw still move to their last targets."""
        ...

    def close(self) -> None:
        """Stop the robot and release its port or body; a second call does nothing."""
        ...
