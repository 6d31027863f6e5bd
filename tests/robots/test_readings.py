"""Readings: what is surprising, what is believed, and counters that go on for ever."""

from collections.abc import Iterator

import pytest
from hypothesis import given
from hypothesis import strategies as st

from khepera_forage.robots.serial.readings import (
    ARM,
    JAW,
    Counters,
    Position,
    Values,
    arm_of,
    confirmed,
    jaw_of,
    present,
)

STEPS = st.lists(st.tuples(st.integers(-200, 200), st.integers(-200, 200)), max_size=30)


def wrapped(value: int) -> int:
    return (value + 2**31) % 2**32 - 2**31


@pytest.mark.parametrize(
    ("answers", "believed"),
    [
        ([(10,)], (10,)),
        ([(99,), (98,)], (98,)),
        ([(99,), (10,), (11,)], (11,)),
        ([(10, 99), (10, 9), (11, 99)], (10, 99)),
    ],
    ids=["as expected", "surprising but true", "wrong", "middle of three, value by value"],
)
def test_a_surprising_reading_is_asked_again(answers: list[Values], believed: Values) -> None:
    said: Iterator[Values] = iter(answers)
    assert confirmed(lambda: next(said), lambda values: max(values) > 50, alike=2) == believed
    assert next(said, None) is None


@pytest.mark.parametrize(("barrier", "presence"), [(0, 0), (100, 0), (101, 255), (255, 255)])
def test_barrier(barrier: int, presence: int) -> None:
    assert present(barrier) == presence


def test_positions_are_brought_into_range() -> None:
    assert [arm_of(p) for p in (0, 127, 215, 230, 255)] == [215, 215, 215, 230, 255]
    assert [jaw_of(p) for p in (0, 126, 200, 255)] == [0, 126, 200, 200]


def asked(position: Position, readings: list[int]) -> list[bool]:
    """Whether it was asked in each of as many rounds; it reads what it is at then."""
    due = []
    for reading in readings:
        due.append(position.due())
        if due[-1]:
            position.read(reading)
    return due


def test_an_arm_is_asked_until_it_has_arrived_and_then_now_and_then() -> None:
    arm = Position(ARM, stalls=False, phase=0)
    arm.sent_to(255)
    way = [*range(219, 255, 4), 255, 255, *[255] * 20]
    due = asked(arm, way)
    assert all(due[:11])
    assert sum(due[11:]) == 2
    arm.sent_to(215)
    assert arm.due()


def test_an_arm_that_is_held_up_is_asked_in_every_round() -> None:
    arm = Position(ARM, stalls=False, phase=0)
    arm.sent_to(255)
    assert all(asked(arm, [234] * 40))


def test_a_jaw_on_food_is_asked_now_and_then() -> None:
    jaw = Position(JAW, stalls=True, phase=5)
    jaw.sent_to(0)
    due = asked(jaw, [167, 134, *[126] * 40])
    assert all(due[:12])
    assert 2 <= sum(due[14:]) <= 4


def test_what_was_never_told_is_asked_until_it_rests() -> None:
    arm = Position(ARM, stalls=False, phase=0)
    assert sum(asked(arm, [240] * 40)) < 20


@pytest.mark.parametrize(
    ("reading", "surprising"), [(231, False), (227, False), (25, True), (220, True), (250, True)]
)
def test_a_position_that_is_not_on_the_way_surprises(reading: int, surprising: bool) -> None:
    arm = Position(ARM, stalls=False, phase=0)
    arm.sent_to(255)
    assert arm.surprising((227,)), "the first of all"
    arm.read(227)
    assert arm.surprising((reading,)) is surprising


@given(st.tuples(*[st.integers(-(2**31), 2**31 - 1)] * 2), STEPS)
def test_counters_go_on_where_32_bits_wrap(start: tuple[int, int], steps: list[tuple[int, int]]) -> None:
    counters = Counters()
    counters.read(start)
    left, right = start
    for step in steps:
        left, right = left + step[0], right + step[1]
        assert not counters.read((wrapped(left), wrapped(right)))
        assert counters.total == (left, right)


@given(st.integers(-(10**6), 10**6), STEPS)
def test_counters_go_on_after_a_restart_that_was_seen(start: int, steps: list[tuple[int, int]]) -> None:
    counters = Counters()
    counters.read((start, -start))
    counters.restarted()
    counters.read((12, -7))
    assert counters.total == (start + 12, -start - 7)
    counters.read((14, -9))
    assert counters.total == (start + 14, -start - 9)


def test_a_restart_that_nobody_saw_shows_in_the_counters() -> None:
    counters = Counters()
    counters.read((5000, 4000))
    assert counters.surprising((20, 10), (5, 5), (5, 5))
    assert counters.read((20, 10))
    assert counters.total == (5020, 4010)
    assert not counters.read((70, 60))
    assert counters.total == (5070, 4060)


def test_a_banner_that_was_none_does_no_harm() -> None:
    counters = Counters()
    counters.read((5000, 4000))
    counters.restarted()
    counters.read((5050, 4050))
    assert counters.total == (5050, 4050)


@pytest.mark.parametrize(
    ("reading", "now", "before", "surprising"),
    [
        ((1050, 1050), (5, 5), (5, 5), False),
        ((1000, 1000), (5, 5), (0, 0), False),
        ((950, 1050), (-5, 5), (-5, 5), False),
        ((1500, 1050), (5, 5), (5, 5), True),
        ((105, 1050), (5, 5), (5, 5), True),
        ((900, 1000), (5, 5), (5, 5), True),
    ],
)
def test_counters_that_the_wheels_do_not_explain_surprise(
    reading: Values, now: Values, before: Values, surprising: bool
) -> None:
    counters = Counters()
    assert counters.surprising(reading, now, before), "the first of all"
    counters.read((1000, 1000))
    assert counters.surprising(reading, now, before) is surprising
