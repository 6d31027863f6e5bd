"""Robots and food on the marks of figure 5.1, as well as an operator can put them there (4.5.2)."""

import math
from dataclasses import replace

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from khepera_forage.counter_rng import key_of
from khepera_forage.envs.layouts import floor_of, no_room_on_marks, training_layout
from khepera_forage.noise import Noise
from khepera_forage.sim.arena import Arena, Point, Pose, copies
from khepera_forage.sim.layout_checks import check_layout
from khepera_forage.sim.world import Layout
from khepera_forage.task.placement import Place, Start, layout_is_free, place_by_hand
from tests.sim.worlds import ELL, FIELD
from tests.version_0_1 import CORRIDOR, RECTANGLE

PROPERTY = settings(derandomize=True, deadline=None, max_examples=60)
ARENAS = [CORRIDOR, RECTANGLE, ELL, FIELD]
KEYS = st.integers(0, 2**64 - 1)
SHARES = st.tuples(st.floats(-0.05, 1.05), st.floats(-0.05, 1.05))
"""Of width and height of an arena."""
FACING_A_WALL = replace(CORRIDOR, start=Pose(60.0, 115.0, math.pi))


@given(st.sampled_from(ARENAS), KEYS, st.floats(0, 20), st.floats(0, 30))
@PROPERTY
def test_training_layout_is_free_and_near_the_marks(
    arena: Arena, key: int, error: float, degrees: float
) -> None:
    noise = Noise(placement_error=error, placement_heading_error=degrees)
    layout = training_layout((arena,), noise, key)
    check_layout((arena,), layout)
    assert layout == training_layout((arena,), noise, key)
    assert math.dist(layout.starts[0][:2], arena.start[:2]) <= 8 * error + 1e-9
    for food, mark in zip(layout.foods, arena.foods, strict=True):
        assert math.dist(food, mark) <= 8 * error + 1e-9


def test_training_layout_without_error_is_on_the_marks() -> None:
    arenas = copies(CORRIDOR, 3)
    layout = training_layout(arenas, Noise.none(), 9)
    assert layout == Layout(tuple(a.start for a in arenas), tuple(f for a in arenas for f in a.foods))


def test_training_errors_have_their_deviation_and_differ_between_arenas() -> None:
    noise = Noise(placement_error=3.0, placement_heading_error=2.0)
    arenas = copies(CORRIDOR, 2)
    errors, turns = [], []
    for seed in range(400):
        layout = training_layout(arenas, noise, key_of(seed))
        for arena, start in zip(arenas, layout.starts, strict=True):
            errors += [start.x - arena.start.x, start.y - arena.start.y]
            turns.append(math.degrees(start.heading))
        for arena, food in zip(arenas, layout.foods, strict=True):
            errors += [food.x - arena.foods[0].x, food.y - arena.foods[0].y]
        assert len({round(e, 6) for e in errors[-8:]}) == 8
    for values, deviation in ((errors, 3.0), (turns, 2.0)):
        count = len(values)
        assert abs(sum(values) / count) < 4 * deviation / math.sqrt(count)
        assert math.sqrt(sum(v * v for v in values) / count) == pytest.approx(deviation, rel=0.1)


def test_place_by_hand_without_room_is_false() -> None:
    start, places = Start(), [Place()]
    assert not place_by_hand(
        start, places, 1, FACING_A_WALL.start, FACING_A_WALL.foods, 0.0, 0.0, floor_of(FACING_A_WALL)
    )


def test_training_layout_without_room_names_placement_error_and_mark() -> None:
    with pytest.raises(
        ValueError, match=r"placement error of 0 mm.*\(60, 115\) mm has its gripper in a wall"
    ):
        training_layout((FACING_A_WALL,), Noise.none(), 1)
    assert "placement error of 2.5 mm" in str(no_room_on_marks(CORRIDOR, Noise(placement_error=2.5)))


@given(st.sampled_from(ARENAS[:3]), SHARES, SHARES, SHARES, st.floats(-math.pi, math.pi))
@settings(PROPERTY, max_examples=300)
def test_layout_is_free_agrees_with_the_checks_of_worlds(
    arena: Arena,
    start: tuple[float, float],
    food: tuple[float, float],
    other: tuple[float, float],
    heading: float,
) -> None:
    """Those checks are the same rule, and also say what is wrong."""
    left, bottom, right, top = arena.bounds
    (x, y), *foods = (
        Point(left + (right - left) * u, bottom + (top - bottom) * v) for u, v in (start, food, other)
    )
    free = layout_is_free(Start(x, y, heading), [Place(*place) for place in foods], floor_of(arena))
    try:
        check_layout((arena,), Layout((Pose(x, y, heading),), tuple(foods)))
    except ValueError:
        assert not free
    else:
        assert free
