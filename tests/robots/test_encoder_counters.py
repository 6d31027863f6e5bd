"""Encoder counters: wrap-around, restarts of the robot, and plausibility."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from khepera_forage.robots.khepera import CONTROL_PERIOD
from khepera_forage.robots.serial.encoder_counters import EncoderCounters, agree
from khepera_forage.robots.serial.readings import Values

STEPS = st.lists(st.tuples(st.integers(-200, 200), st.integers(-200, 200)), max_size=30)


def as_32_bits(value: int) -> int:
    return (value + 2**31) % 2**32 - 2**31


@given(st.tuples(*[st.integers(-(2**31), 2**31 - 1)] * 2), STEPS)
def test_counters_continue_across_32_bit_wrap_around(
    start: tuple[int, int], steps: list[tuple[int, int]]
) -> None:
    counters = EncoderCounters(CONTROL_PERIOD)
    counters.update(start)
    left, right = start
    for step in steps:
        left, right = left + step[0], right + step[1]
        counters.update((as_32_bits(left), as_32_bits(right)))
        assert not counters.restart_noticed
        assert counters.total == (left, right)


@given(st.integers(-(10**6), 10**6), STEPS)
def test_counters_continue_after_a_restart_with_banner(start: int, steps: list[tuple[int, int]]) -> None:
    counters = EncoderCounters(CONTROL_PERIOD)
    counters.update((start, -start))
    counters.restarted()
    counters.update((12, -7))
    assert counters.total == (start + 12, -start - 7)
    counters.update((14, -9))
    assert counters.total == (start + 14, -start - 9)


def test_restart_without_banner_is_detected() -> None:
    counters = EncoderCounters(CONTROL_PERIOD)
    counters.update((5000, 4000))
    assert not counters.plausible((20, 10), (5, 5))
    counters.update((20, 10))
    assert counters.restart_noticed
    assert counters.total == (5020, 4010)
    counters.update((70, 60))
    assert not counters.restart_noticed
    assert counters.total == (5070, 4060)


def test_false_banner_does_not_change_the_counters() -> None:
    counters = EncoderCounters(CONTROL_PERIOD)
    counters.update((5000, 4000))
    counters.restarted()
    counters.update((5050, 4050))
    assert counters.total == (5050, 4050)


@pytest.mark.parametrize(
    ("reading", "speeds", "plausible"),
    [
        ((1050, 1050), (5, 5), True),
        ((1080, 1020), (5, 5), True),
        ((950, 1050), (-5, 5), True),
        ((1081, 1050), (5, 5), False),
        ((1000, 1000), (5, 5), False),
        ((105, 1050), (5, 5), False),
    ],
)
def test_counters_are_plausible_near_the_travel_of_one_period(
    reading: Values, speeds: Values, plausible: bool
) -> None:
    counters = EncoderCounters(CONTROL_PERIOD)
    assert not counters.plausible(reading, speeds), "there is no last reading"
    counters.update((1000, 1000))
    assert counters.plausible(reading, speeds) is plausible


def test_counters_are_plausible_after_the_travel_of_a_long_round(monkeypatch: pytest.MonkeyPatch) -> None:
    now = [100.0]
    monkeypatch.setattr("time.monotonic", lambda: now[0])
    counters = EncoderCounters(CONTROL_PERIOD)
    counters.update((0, 0))
    now[0] += 0.6
    assert counters.plausible((600, -300), (10, -5))
    assert counters.plausible((100, -50), (10, -5)), "of a simulation that does not run in real time"
    assert not counters.plausible((350, -175), (10, -5))
    assert not counters.plausible((600, -50), (10, -5)), "both wheels turn for the same time"


@pytest.mark.parametrize(
    ("second", "agrees"),
    [
        ((1000, 1000), True),
        ((1130, 870), True),
        ((970, 1030), True),
        ((1131, 1000), False),
        ((1050, 1000), False),
        ((969, 1000), False),
    ],
)
def test_readings_agree_within_the_travel_between_them(second: Values, agrees: bool) -> None:
    assert agree((1000, 1000), second, (10, -10), 0.1) is agrees
