"""Motor commands: rounded and limited to the robot's range, rejected if not finite."""

import math

import pytest

from khepera_forage.robots.khepera import JAW_CLOSED, JAW_ON_FOOD, JAW_OPEN, Motors, applicable, check_finite, half_gap


@pytest.mark.parametrize(
    ("command", "applied"),
    [
        (Motors(0, 0, 215, 200), Motors(0, 0, 215, 200)),
        (Motors(20, -20, 255, 0), Motors(20, -20, 255, 0)),
        (Motors(20.4, -20.4, 255, 0), Motors(20, -20, 255, 0)),
        (Motors(21, -127, 256, 0), Motors(20, -20, 255, 0)),
        (Motors(1e300, -1e300, 10**6, -5), Motors(20, -20, 255, 0)),
        (Motors(7.4, -7.4, 0, 300), Motors(7, -7, 215, 200)),
        (Motors(7.6, -7.6, 127, 200), Motors(8, -8, 215, 200)),
        (Motors(-0.4, 0.4, 230, 101), Motors(0, 0, 230, 200)),
        (Motors(0, 0, 230, 100), Motors(0, 0, 230, 0)),
    ],
)
def test_command_is_clamped_and_rounded(command: Motors, applied: Motors) -> None:
    assert applicable(command) == applied


@pytest.mark.parametrize("field", Motors._fields)
@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
def test_value_that_is_not_finite_is_rejected(field: str, value: float) -> None:
    with pytest.raises(ValueError, match=rf"{field}={value}.*finite"):
        check_finite(Motors(**{**Motors(1, 2, 255, 0)._asdict(), field: value}))


def test_jaw_on_food_leaves_a_gap_as_wide_as_food() -> None:
    assert half_gap(JAW_CLOSED) == pytest.approx(0.5)
    assert half_gap(JAW_OPEN) == pytest.approx(27.5)
    assert half_gap(JAW_ON_FOOD) == pytest.approx(35.0 / 2)
