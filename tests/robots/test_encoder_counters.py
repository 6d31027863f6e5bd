"""Encoder counters: wrap-around, restarts of the robot, and plausibility."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from khepera_forage.robots.serial.encoder_counters import EncoderCounters
from khepera_forage.robots.serial.readings import Values

STEPS = st.lists(st.tuples(st.integers(-200, 200), st.integers(-200, 200)), max_size=30)


def as_32_bits(value: int) -> int:
    return (value + 2**31) % 2**32 - 2**31


@given(st.tuples(*[st.integers(-(2**31), 2**31 - 1)] * 2), STEPS)
def test_counters_continue_across_32_bit_wrap_around(
    start: tuple[int, int], steps: list[tuple[int, int]]
) -> None:
    counters = EncoderCounters()
    counters.update(start)
    left, right = start
    for step in steps:
        left, right = left + step[0], right + step[1]
        assert not counters.update((as_32_bits(left), as_32_bits(right)))
        assert counters.total == (left, right)


@given(st.integers(-(10**6), 10**6), STEPS)
def test_counters_continue_after_a_restart_with_banner(start: int, steps: list[tuple[int, int]]) -> None:
    counters = EncoderCounters()
    counters.update((start, -start))
    counters.restarted()
    counters.update((12, -7))
    assert counters.total == (start + 12, -start - 7)
    counters.update((14, -9))
    assert counters.total == (start + 14, -start - 9)


def test_restart_without_banner_is_detected() -> None:
    counters = EncoderCounters()
    counters.update((5000, 4000))
    assert counters.implausible((20, 10), (5, 5), (5, 5))
    assert counters.update((20, 10))
    assert counters.total == (5020, 4010)
    assert not counters.update((70, 60))
    assert counters.total == (5070, 4060)


def test_false_banner_does_not_change_the_counters() -> None:
    counters = EncoderCounters()
    counters.update((5000, 4000))
    counters.restarted()
    counters.update((5050, 4050))
    assert counters.total == (5050, 4050)


@pytest.mark.parametrize(
    ("reading", "speeds", "speeds_before", "implausible"),
    [
        ((1050, 1050), (5, 5), (5, 5), False),
        ((1000, 1000), (5, 5), (0, 0), False),
        ((950, 1050), (-5, 5), (-5, 5), False),
        ((1500, 1050), (5, 5), (5, 5), True),
        ((105, 1050), (5, 5), (5, 5), True),
        ((900, 1000), (5, 5), (5, 5), True),
    ],
)
def test_counters_that_contradict_the_wheel_speeds_are_implausible(
    reading: Values, speeds: Values, speeds_before: Values, implausible: bool
) -> None:
    counters = EncoderCounters()
    assert counters.implausible(reading, speeds, speeds_before), "there is no last reading"
    counters.update((1000, 1000))
    assert counters.implausible(reading, speeds, speeds_before) is implausible
