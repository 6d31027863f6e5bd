"""Readings: repetition of implausible ones, and conversion to the ranges of `Senses`."""

from collections.abc import Iterator

import pytest

from khepera_forage.robots.serial.readings import (
    Values,
    arm_position,
    jaw_position,
    object_presence,
    read_confirmed,
)


@pytest.mark.parametrize(
    ("readings", "accepted"),
    [
        ([(10,)], (10,)),
        ([(99,), (98,)], (98,)),
        ([(99,), (10,), (11,)], (11,)),
        ([(10, 99), (10, 9), (11, 99)], (10, 99)),
    ],
    ids=["plausible", "implausible but confirmed", "wrong", "median of three, value by value"],
)
def test_implausible_reading_is_repeated(readings: list[Values], accepted: Values) -> None:
    remaining: Iterator[Values] = iter(readings)
    assert (
        read_confirmed(lambda: next(remaining), lambda values: max(values) > 50, equal_within=2) == accepted
    )
    assert next(remaining, None) is None


@pytest.mark.parametrize(("barrier", "presence"), [(0, 0), (100, 0), (101, 255), (255, 255)])
def test_barrier_threshold_separates_object_from_nothing(barrier: int, presence: int) -> None:
    assert object_presence(barrier) == presence


def test_positions_are_limited_to_their_ranges() -> None:
    assert [arm_position(p) for p in (0, 127, 215, 230, 255)] == [215, 215, 215, 230, 255]
    assert [jaw_position(p) for p in (0, 126, 200, 255)] == [0, 126, 200, 200]
