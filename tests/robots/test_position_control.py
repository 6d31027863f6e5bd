"""Position control with a trapezoidal speed profile."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from khepera_forage.robots.khepera import PULSES_PER_UNIT
from khepera_forage.robots.virtual.firmware import POSITION_TOLERANCE, WheelPositionController

TOLERANCE = POSITION_TOLERANCE * PULSES_PER_UNIT


def driven(
    wheel: WheelPositionController, count: int, limit: int = 20, rounds: int = 3000
) -> tuple[list[int], int]:
    """Speeds of the wheel until it reaches its target, and its final count."""
    speeds = []
    for _ in range(rounds):
        speed = max(-limit, min(limit, wheel.speed(count)))
        if speed == 0 and wheel.reached(count):
            break
        speeds.append(speed)
        count += 10 * speed
    return speeds, count


@given(st.integers(-20000, 20000), st.integers(-20000, 20000), st.integers(1, 127), st.integers(1, 255))
def test_wheel_reaches_its_target_and_stays(
    target: int, start: int, max_speed: int, acceleration: int
) -> None:
    wheel = WheelPositionController()
    wheel.set_profile(max_speed, acceleration)
    wheel.set_target(target, start, 0)
    _, count = driven(wheel, start, rounds=100_000)
    for _ in range(100):
        assert abs(count - target) <= TOLERANCE
        count += 10 * wheel.speed(count)


def test_default_profile_is_a_trapezoid() -> None:
    wheel = WheelPositionController()
    wheel.set_target(5000, 0, 0)
    speeds, count = driven(wheel, 0)
    assert abs(count - 5000) <= TOLERANCE
    assert max(speeds) == 20
    steps = [after - before for before, after in zip([0, *speeds], [*speeds, 0], strict=True)]
    assert max(steps) <= 3, "64 is 2.5 units per control period"
    assert min(steps) >= -4, "the last step may be half as long again"
    top = [i for i, speed in enumerate(speeds) if speed == 20]
    assert top == list(range(top[0], top[-1] + 1)), "one acceleration, one deceleration"
    assert 6 <= top[0] <= 9, "8 periods from rest to 20 units"


def test_profile_limits_speed_and_acceleration() -> None:
    wheel = WheelPositionController()
    wheel.set_profile(7, 16)
    wheel.set_target(-3000, 0, 0)
    speeds, _ = driven(wheel, 0)
    assert min(speeds) == -7
    assert all(speed <= 0 for speed in speeds), "no overshoot"
    assert max(abs(b - a) for a, b in zip([0, *speeds], [*speeds, 0], strict=True)) <= 2


def test_moving_wheel_reverses_for_a_target_behind_it() -> None:
    wheel = WheelPositionController()
    wheel.set_target(-500, 1000, 15)
    speeds, count = driven(wheel, 1000)
    assert speeds[0] > 0 > min(speeds)
    assert abs(count + 500) <= TOLERANCE


def test_robot_slower_than_the_profile_reaches_the_target() -> None:
    wheel = WheelPositionController()
    wheel.set_profile(127, 255)
    wheel.set_target(4000, 0, 0)
    speeds, count = driven(wheel, 0, limit=20)
    assert max(speeds) == 20
    assert abs(count - 4000) <= TOLERANCE


@pytest.mark.parametrize(("max_speed", "acceleration"), [(0, 64), (20, 0)])
def test_zero_speed_or_acceleration_means_no_motion(max_speed: int, acceleration: int) -> None:
    wheel = WheelPositionController()
    wheel.set_profile(max_speed, acceleration)
    wheel.set_target(1000, 0, 0)
    assert [wheel.speed(0) for _ in range(20)] == [0] * 20


def test_setting_the_counter_during_a_motion_keeps_the_speed() -> None:
    wheel = WheelPositionController()
    wheel.set_target(5000, 0, 0)
    count = 0
    for _ in range(10):
        count += 10 * wheel.speed(count)
    wheel.shift_counter(2000)
    count += 2000
    assert abs(wheel.speed(count)) <= 20, "no jump"
    assert abs(driven(wheel, count)[1] - 5000) <= TOLERANCE
