"""Random layouts and food types (5.4.1.1), and layouts on the marks of figure 5.1 (4.5.2)."""

import math
from itertools import combinations

import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from khepera_forage.counter_rng import key_of
from khepera_forage.envs.layouts import floor_of, random_layout, training_layout
from khepera_forage.noise import Noise
from khepera_forage.robots.khepera import FOOD_RADIUS, RADIUS
from khepera_forage.sim.arena import Arena, Point, Pose, copies
from khepera_forage.sim.arenas.procedural import procedural_arena
from khepera_forage.sim.layout_checks import check_layout
from khepera_forage.sim.world import Layout
from khepera_forage.task.decisions import DEFAULT_VALUES, Decisions
from khepera_forage.task.food_tracking import FoodObject
from khepera_forage.task.placement import Place, Start, draw_food_types, layout_is_free
from khepera_forage.task.states import FoodType
from khepera_forage.vision.scene import MM_PER_PIXEL
from tests.arenas import POOL
from tests.version_0_1 import CORRIDOR, RECTANGLE

PROPERTY = settings(max_examples=60)
ARENAS = (CORRIDOR, RECTANGLE, *POOL)
LEVELS = st.builds(procedural_arena, st.integers(0, 40), st.sampled_from(("medium", "hard")))
"""With notches, rooms and obstacles."""
KEYS = st.integers(0, 2**64 - 1)
SHARES = st.tuples(st.floats(-0.05, 1.05), st.floats(-0.05, 1.05))
"""Of width and height of an arena."""


def check_random(arena: Arena, layout: Layout, decisions: Decisions) -> None:
    """A random layout is one in which a robot can forage."""
    check_layout((arena,), layout)
    (start,) = layout.starts
    assert -math.pi <= start.heading <= math.pi
    assert math.dist(start[:2], arena.home) >= arena.home_radius + RADIUS
    for food in layout.foods:
        assert arena.clearance(food) >= decisions.food_to_walls
        assert math.dist(food, arena.home) >= arena.home_radius + FOOD_RADIUS
        assert math.dist(food, start[:2]) > decisions.close_to_food * MM_PER_PIXEL
    for one, other in combinations(layout.foods, 2):
        assert math.dist(one, other) >= decisions.food_spacing


@given(st.sampled_from(ARENAS) | LEVELS, KEYS, st.integers(1, 3))
@settings(PROPERTY, max_examples=120)
def test_random_layout_is_free_and_outside_home(arena: Arena, key: int, foods: int) -> None:
    assume(arena is not CORRIDOR or foods == 1)  # there is not always room for more
    layout = random_layout(arena, foods, key, DEFAULT_VALUES)
    assert len(layout.foods) == foods
    check_random(arena, layout, Decisions())


def test_random_starts_and_food_cover_the_floor() -> None:
    layouts = [random_layout(RECTANGLE, 1, key_of(seed), DEFAULT_VALUES) for seed in range(300)]
    for places in ([x.starts[0][:2] for x in layouts], [x.foods[0] for x in layouts]):
        assert len({(x > 325.0, y > 300.0) for x, y in places}) == 4
    headings = [x.starts[0].heading for x in layouts]
    assert abs(sum(map(math.cos, headings)) / 300) < 0.17  # four standard errors
    assert abs(sum(map(math.sin, headings)) / 300) < 0.17


@pytest.mark.parametrize(
    "decisions",
    [
        Decisions(food_to_walls=90.0),
        Decisions(food_spacing=200.0),
        Decisions(close_to_food=50.0),
        Decisions(food_to_walls=20.0, food_spacing=40.0, close_to_food=20.0),
    ],
    ids=lambda decisions: "-".join(decisions.changed()),
)
def test_decisions_move_the_limits_of_random_food(decisions: Decisions) -> None:
    nearest_wall = nearest_food = nearest_robot = math.inf
    for seed in range(200):
        layout = random_layout(RECTANGLE, 2, key_of(seed), decisions.values())
        check_random(RECTANGLE, layout, decisions)
        nearest_wall = min(nearest_wall, *(RECTANGLE.clearance(food) for food in layout.foods))
        nearest_food = min(nearest_food, math.dist(*layout.foods))
        nearest_robot = min(nearest_robot, *(math.dist(f, layout.starts[0][:2]) for f in layout.foods))
    assert nearest_wall < decisions.food_to_walls + 10
    assert nearest_food < decisions.food_spacing + 25
    assert nearest_robot < decisions.close_to_food * MM_PER_PIXEL + 30


def test_food_types_have_their_odds() -> None:
    objects = [FoodObject(0.0, 0.0) for _ in range(4000)]
    draw_food_types(objects, 12, (0.5, 0.3, 0.2))
    assert {food.known for food in objects} == {FoodType.UNKNOWN}
    types = [food.type for food in objects]
    shares = [types.count(t) / 4000 for t in (FoodType.PICKABLE, FoodType.PUSHABLE, FoodType.POISONOUS)]
    assert shares == pytest.approx([0.5, 0.3, 0.2], abs=0.03)  # four standard errors


@given(st.sampled_from(ARENAS), KEYS, st.floats(0, 20), st.floats(0, 30))
@PROPERTY
def test_training_layout_is_free_and_near_the_marks(arena: Arena, key: int, error: float, degrees: float) -> None:
    layout = training_layout((arena,), Noise(placement_error=error, placement_heading_error=degrees), key)
    check_layout((arena,), layout)
    assert math.dist(layout.starts[0][:2], arena.start[:2]) <= 8 * error + 1e-9
    for food, mark in zip(layout.foods, arena.foods, strict=True):
        assert math.dist(food, mark) <= 8 * error + 1e-9


def test_training_errors_have_their_deviation_and_differ_between_arenas() -> None:
    noise, arenas = Noise(placement_error=3.0, placement_heading_error=2.0), copies(CORRIDOR, 2)
    errors, turns = [], []
    for seed in range(400):
        layout = training_layout(arenas, noise, key_of(seed))
        for arena, start, food in zip(arenas, layout.starts, layout.foods, strict=True):
            errors += [start.x - arena.start.x, start.y - arena.start.y]
            errors += [food.x - arena.foods[0].x, food.y - arena.foods[0].y]
            turns.append(math.degrees(start.heading))
        assert len({round(e, 6) for e in errors[-8:]}) == 8
    for values, deviation in ((errors, 3.0), (turns, 2.0)):
        count = len(values)
        assert abs(sum(values) / count) < 4 * deviation / math.sqrt(count)
        assert math.sqrt(sum(v * v for v in values) / count) == pytest.approx(deviation, rel=0.1)


@given(st.sampled_from(ARENAS), SHARES, SHARES, SHARES, st.floats(-math.pi, math.pi))
@settings(PROPERTY, max_examples=300)
def test_layout_is_free_agrees_with_the_checks_of_worlds(
    arena: Arena, start: tuple[float, float], food: tuple[float, float], other: tuple[float, float], heading: float
) -> None:
    """Those checks are the same rule, and also say what is wrong."""
    left, bottom, right, top = arena.bounds
    (x, y), *foods = (Point(left + (right - left) * u, bottom + (top - bottom) * v) for u, v in (start, food, other))
    free = layout_is_free(Start(x, y, heading), [Place(*place) for place in foods], floor_of(arena))
    try:
        check_layout((arena,), Layout((Pose(x, y, heading),), tuple(foods)))
    except ValueError:
        assert not free
    else:
        assert free
