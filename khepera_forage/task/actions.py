"""Actions of the Wheels environments: four numbers in -1..1 as motors. Plain arithmetic, also compiled."""

import math

from khepera_forage.robots.khepera import ARM_DOWN, ARM_RAISED, JAW_CLOSED, JAW_OPEN, MAX_SPEED, Motors


def decode_motors(left: float, right: float, arm: float, jaw: float) -> Motors:
    """Motors that an action commands.

    Args:
        left: -1..1 is -20..20 speed units.
        right: -1..1 is -20..20 speed units.
        arm: -1 is 255, down; +1 is 215, raised.
        jaw: Above 0 closes.
    """
    position = math.floor((ARM_DOWN + ARM_RAISED) / 2 - arm * (ARM_DOWN - ARM_RAISED) / 2 + 0.5)
    return Motors(left * MAX_SPEED, right * MAX_SPEED, position, JAW_CLOSED if jaw > 0 else JAW_OPEN)
