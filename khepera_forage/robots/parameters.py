"""Differences between individual robots (1.2: "it is quite unlikely for two robots to be 'identical'")."""

import math
from dataclasses import dataclass

from khepera_forage.robots.khepera import FINGER_LENGTH

MIN_FINGER_LENGTH = 20.0
"""mm. Shorter fingers would end before food that crosses the optical barrier, 15 mm along them."""


@dataclass(frozen=True, slots=True)
class RobotParameters:
    """Constant deviations of one simulated robot, in addition to the noise; by default none.

    Attributes:
        left_wheel_error: Relative error of the left wheel's travel: 0.1 is 10 % too far, -0.1 is 10 % too short.
            Above -1.
        infra_red_gain: Factor on the infra-red readings; at least 0.
        arm_reading_scale: Reported share of the arm's travel from the floor: below 1 a raised arm reads more than
            215. Above 0, at most 1.
        finger_length: Length of the gripper's fingers in mm, at most that of the real gripper.

    Raises:
        ValueError: A value out of range.
    """

    left_wheel_error: float = 0.0
    infra_red_gain: float = 1.0
    arm_reading_scale: float = 1.0
    finger_length: float = FINGER_LENGTH

    def __post_init__(self) -> None:
        self._check("left_wheel_error", -1.0 < self.left_wheel_error < math.inf, "a finite number above -1")
        self._check("infra_red_gain", 0.0 <= self.infra_red_gain < math.inf, "a finite number >= 0")
        self._check("arm_reading_scale", 0.0 < self.arm_reading_scale <= 1.0, "above 0, at most 1")
        allowed = f"{MIN_FINGER_LENGTH:g} to {FINGER_LENGTH:g} mm"
        self._check("finger_length", MIN_FINGER_LENGTH <= self.finger_length <= FINGER_LENGTH, allowed)

    def _check(self, name: str, valid: bool, allowed: str) -> None:
        if not valid:
            raise ValueError(f"robot parameter {name} is {getattr(self, name)!r}; allowed: {allowed}")
