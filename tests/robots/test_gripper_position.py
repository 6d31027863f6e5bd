"""The position of arm or jaw: when it is requested, and which readings are plausible."""

import pytest

from khepera_forage.robots.serial.gripper_position import GripperPosition
from khepera_forage.robots.serial.readings import ARM_LIMITS, JAW_LIMITS


def due_rounds(position: GripperPosition, readings: list[int]) -> list[bool]:
    """Whether the position was due in each round, with these readings."""
    due = []
    for reading in readings:
        due.append(position.is_due())
        if due[-1]:
            position.update(reading)
    return due


def test_arm_is_due_until_it_has_arrived() -> None:
    arm = GripperPosition(ARM_LIMITS, can_stall=False, phase=0)
    arm.set_target(255)
    way = [*range(219, 255, 4), 255, 255, *[255] * 20]
    due = due_rounds(arm, way)
    assert all(due[:11])
    assert sum(due[11:]) == 2
    arm.set_target(215)
    assert arm.is_due()


def test_arm_resting_on_an_obstacle_is_due_in_every_round() -> None:
    arm = GripperPosition(ARM_LIMITS, can_stall=False, phase=0)
    arm.set_target(255)
    assert all(due_rounds(arm, [234] * 40))


def test_jaw_on_food_is_rarely_due() -> None:
    jaw = GripperPosition(JAW_LIMITS, can_stall=True, phase=5)
    jaw.set_target(0)
    due = due_rounds(jaw, [167, 134, *[126] * 40])
    assert all(due[:12])
    assert 2 <= sum(due[14:]) <= 4


def test_position_without_target_is_due_until_it_rests() -> None:
    arm = GripperPosition(ARM_LIMITS, can_stall=False, phase=0)
    assert sum(due_rounds(arm, [240] * 40)) < 20


@pytest.mark.parametrize(
    ("reading", "plausible"), [(231, True), (227, True), (25, False), (220, False), (250, False)]
)
def test_position_off_the_way_to_the_target_is_implausible(reading: int, plausible: bool) -> None:
    arm = GripperPosition(ARM_LIMITS, can_stall=False, phase=0)
    arm.set_target(255)
    assert not arm.plausible((227,)), "there is no last reading"
    arm.update(227)
    assert arm.plausible((reading,)) is plausible
