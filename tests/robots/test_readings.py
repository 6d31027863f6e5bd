"""Readings: repetition of implausible ones, and conversion to the ranges of `Senses`."""

from collections.abc import Iterator

import pytest

from khepera_forage.robots.serial.readings import (
    Values,
    arm_passed,
    arm_position,
    jaw_position,
    object_presence,
    read_confirmed,
    within,
)


@pytest.mark.parametrize(
    ("readings", "accepted"),
    [
        ([(10,)], (10,)),
        ([(99,), (98,)], (98,)),
        ([(99,), (10,)], (10,)),
        ([(99,), (70,), (60,), (58,)], (58,)),
        ([(99,), (90,), (80,), (70,), (60,)], None),
    ],
    ids=["plausible", "confirmed", "wrong, then plausible", "confirmed at last", "unknown"],
)
def test_implausible_reading_is_repeated(readings: list[Values], accepted: Values | None) -> None:
    remaining: Iterator[Values] = iter(readings)
    reading = read_confirmed(
        lambda: next(remaining),
        lambda values: max(values) <= 50,
        lambda first, second: within(first, second, 2),
    )
    assert reading == accepted
    assert next(remaining, None) is None


def test_reading_of_the_next_round_confirms_an_unknown_one() -> None:
    accepted = read_confirmed(
        lambda: (98,), lambda values: False, lambda first, second: within(first, second, 2), before=(99,)
    )
    assert accepted == (98,)
    assert read_confirmed(lambda: None, lambda values: True, lambda first, second: True, before=(99,)) is None


def test_arm_changes_all_infra_reds_in_front() -> None:
    clear, behind = (3, 0, 40, 200, 5, 1, 70, 80), (1016, 1021, 1018, 1022, 1015, 1019, 72, 79)
    assert arm_passed(clear, behind)
    assert arm_passed(behind, clear)
    garbled = (1016, *clear[1:])
    assert not arm_passed(clear, garbled)
    assert not arm_passed(clear, (*behind[:6], 900, 79)), "not behind the robot"


@pytest.mark.parametrize(("barrier", "presence"), [(0, 0), (100, 0), (101, 255), (255, 255)])
def test_barrier_threshold_separates_object_from_nothing(barrier: int, presence: int) -> None:
    assert object_presence(barrier) == presence


def test_positions_are_limited_to_their_ranges() -> None:
    assert [arm_position(p) for p in (0, 127, 215, 230, 255)] == [215, 215, 215, 230, 255]
    assert [jaw_position(p) for p in (0, 126, 200, 255)] == [0, 126, 200, 200]
