"""Actions of the Wheels environments as motors."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from khepera_forage.robots.khepera import ARM_DOWN, ARM_RAISED, JAW_CLOSED, JAW_OPEN, MAX_SPEED, Motors
from khepera_forage.task.behaviours import decode_motors

VALUES = st.floats(-1, 1)


@pytest.mark.parametrize(
    ("action", "motors"),
    [
        ((1.0, -1.0, -1.0, 1.0), Motors(MAX_SPEED, -MAX_SPEED, ARM_DOWN, JAW_CLOSED)),
        ((0.0, 0.5, 1.0, -1.0), Motors(0.0, 10.0, ARM_RAISED, JAW_OPEN)),
        ((0.0, 0.0, 0.0, 0.0), Motors(0.0, 0.0, 235, JAW_OPEN)),
        ((0.0, 0.0, 0.0, 1e-9), Motors(0.0, 0.0, 235, JAW_CLOSED)),
    ],
)
def test_decode_motors_maps_the_ends_of_the_action_to_the_limits(
    action: tuple[float, float, float, float], motors: Motors
) -> None:
    assert decode_motors(*action) == motors


@given(left=VALUES, right=VALUES, arm=VALUES, jaw=VALUES)
def test_decode_motors_stays_within_the_limits(left: float, right: float, arm: float, jaw: float) -> None:
    motors = decode_motors(left, right, arm, jaw)
    assert (motors.left, motors.right) == (left * MAX_SPEED, right * MAX_SPEED)
    assert ARM_RAISED <= motors.arm <= ARM_DOWN
    assert abs(motors.arm - (235 - 20 * arm)) <= 0.5
    assert motors.jaw == (JAW_CLOSED if jaw > 0 else JAW_OPEN)
