"""How one robot's body differs from another's (1.2: "it is quite unlikely for two robots to be 'identical'")."""

import math
from dataclasses import dataclass

from khepera_forage.robots.khepera import FINGER_LENGTH

SHORTEST_FINGERS = 20.0
"""mm. Fingers any shorter would end before food that crosses the optical barrier, 15 mm along them."""


@dataclass(frozen=True, slots=True)
class Body:
    """One simulated robot's lasting peculiarities, on top of the laboratory's noise; by default none.

    Attributes:
        left_wheel: Share by which the left wheel travels too far; below 0 it is lazy. Above -1.
        infra_reds: What the infra-reds read, as a share of what they should; at least 0.
        arm_reading: Share of its travel from the floor that the arm reports: below 1 a raised arm reads more than
            215. Above 0, at most 1.
        fingers: Length in mm, at most the gripper's own.

    Raises:
        ValueError: A value out of range.
    """

    left_wheel: float = 0.0
    infra_reds: float = 1.0
    arm_reading: float = 1.0
    fingers: float = FINGER_LENGTH

    def __post_init__(self) -> None:
        _check("left_wheel", self.left_wheel, -1.0 < self.left_wheel < math.inf, "a finite number above -1")
        _check("infra_reds", self.infra_reds, 0.0 <= self.infra_reds < math.inf, "a finite number >= 0")
        _check("arm_reading", self.arm_reading, 0.0 < self.arm_reading <= 1.0, "above 0, at most 1")
        _check(
            "fingers",
            self.fingers,
            SHORTEST_FINGERS <= self.fingers <= FINGER_LENGTH,
            f"{SHORTEST_FINGERS:g} to {FINGER_LENGTH:g} mm",
        )


def _check(name: str, value: float, fine: bool, allowed: str) -> None:
    if not fine:
        raise ValueError(f"body {name} is {value!r}; allowed: {allowed}")
