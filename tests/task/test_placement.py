"""Random layouts and food types (5.4.1.1)."""

import math
from dataclasses import replace
from itertools import combinations

import pytest
import shapely
from hypothesis import given, reject, settings
from hypothesis import strategies as st

from khepera_forage.counter_rng import key_of
from khepera_forage.envs.layouts import arena_map_of, floor_of, random_layout
from khepera_forage.robots.footprint import GRIPPER_HALF_WIDTH
from khepera_forage.robots.khepera import FINGER_TIP, FOOD_RADIUS, JAW_ROOT, RADIUS
from khepera_forage.sim.arena import Arena, Point
from khepera_forage.sim.layout_checks import check_layout, check_robot
from khepera_forage.sim.ways import check_ways
from khepera_forage.sim.world import Layout
from khepera_forage.task.decisions import DEFAULT_VALUES, Decisions
from khepera_forage.task.food_tracking import FoodObject
from khepera_forage.task.placement import (
    Place,
    Start,
    draw_food_types,
    draw_layout,
    food_type_key,
    layout_key,
)
from khepera_forage.task.states import FoodType
from khepera_forage.vision.scene import MM_PER_PIXEL
from tests.geometry.shapes import star
from tests.sim.worlds import ELL, FIELD
from tests.version_0_1 import CORRIDOR, RECTANGLE

PROPERTY = settings(derandomize=True, deadline=None, max_examples=60)
ARENAS = [CORRIDOR, RECTANGLE, ELL, FIELD, RECTANGLE.shifted(700.0, 400.0)]
"""Convex, convex, not convex with an obstacle, wide, and at an offset."""
RADII = st.lists(st.floats(50, 220), min_size=3, max_size=6)
CELLS = st.tuples(st.integers(0, 2), st.integers(0, 2))
KEYS = st.integers(0, 2**64 - 1)


def drawn(arena: Arena, foods: int, key: int, decisions: Decisions | None = None) -> Layout | None:
    """A random layout; None where there is no room."""
    start, places = Start(), [Place() for _ in range(foods)]
    values = (Decisions() if decisions is None else decisions).values()
    if not draw_layout(start, places, key, floor_of(arena), arena_map_of(arena), values):
        return None
    return random_layout(arena, foods, key, values)


def check_random(arena: Arena, layout: Layout, decisions: Decisions) -> None:
    """A random layout is one in which a robot can forage."""
    check_layout((arena,), layout)
    (start,) = layout.starts
    assert -math.pi <= start.heading <= math.pi
    assert math.dist(start[:2], arena.home) >= arena.home_radius + RADIUS
    check_robot(arena, start)
    for food in layout.foods:
        assert arena.clearance(food) >= decisions.food_to_walls
        assert math.dist(food, arena.home) >= arena.home_radius + FOOD_RADIUS
        assert math.dist(food, start[:2]) > decisions.close_to_food * MM_PER_PIXEL
    for one, other in combinations(layout.foods, 2):
        assert math.dist(one, other) >= decisions.food_spacing


# ---------------------------------------------------------------- random layouts


@given(st.sampled_from(ARENAS), KEYS, st.integers(1, 3))
@PROPERTY
def test_random_layout_is_free_and_outside_home(arena: Arena, key: int, foods: int) -> None:
    layout = drawn(arena, foods, key)
    if foods == 1 or arena is not CORRIDOR:
        assert layout is not None
        assert len(layout.foods) == foods
    if layout is not None:
        check_random(arena, layout, Decisions())


@st.composite
def arenas_with_obstacles(draw: st.DrawFn) -> Arena:
    """A wide floor with obstacles, around which there are ways."""
    cells = draw(st.lists(CELLS, min_size=1, max_size=4, unique=True))
    obstacles = tuple(
        tuple(Point(*corner) for corner in star(draw(RADII), (400.0 + 500.0 * i, 400.0 + 500.0 * j)))
        for i, j in cells
    )
    try:
        arena = replace(FIELD, obstacles=obstacles)
        check_ways(arena)
    except ValueError:  # on the home or a mark, or around one
        reject()
    return arena


@given(arenas_with_obstacles(), KEYS)
@PROPERTY
def test_random_layout_avoids_obstacles(arena: Arena, key: int) -> None:
    layout = drawn(arena, 3, key)
    assert layout is not None
    check_random(arena, layout, Decisions())


def test_random_start_has_room_for_the_gripper_beside_a_thin_wall() -> None:
    """Robots that started with a wall across the gripper were stuck on pymunk, and thrown in compiled worlds."""
    thin = Point(848, 752), Point(852, 748), Point(1252, 1148), Point(1248, 1152)
    arena = replace(FIELD, obstacles=(thin,))
    fingers = [(JAW_ROOT, -GRIPPER_HALF_WIDTH), (FINGER_TIP, -GRIPPER_HALF_WIDTH)]
    fingers += [(FINGER_TIP, GRIPPER_HALF_WIDTH), (JAW_ROOT, GRIPPER_HALF_WIDTH)]
    for seed in range(1500):
        layout = random_layout(arena, 1, key_of(seed), DEFAULT_VALUES)
        x, y, heading = layout.starts[0]
        cosine, sine = math.cos(heading), math.sin(heading)
        gripper = shapely.Polygon(
            [(x + u * cosine - v * sine, y + u * sine + v * cosine) for u, v in fingers]
        )
        assert not gripper.intersects(shapely.Polygon(thin)), seed


@given(st.sampled_from(ARENAS), KEYS)
@PROPERTY
def test_random_layout_is_the_same_for_the_same_key(arena: Arena, key: int) -> None:
    layout = drawn(arena, 1, key)
    assert layout == drawn(arena, 1, key)
    assert layout != drawn(arena, 1, key ^ 1)


def test_random_layout_moves_along_with_its_arena() -> None:
    here, there = drawn(RECTANGLE, 2, 5), drawn(RECTANGLE.shifted(700.0, 400.0), 2, 5)
    assert here is not None
    assert there is not None
    assert there.starts[0] == pytest.approx(
        (here.starts[0].x + 700.0, here.starts[0].y + 400.0, here.starts[0].heading)
    )


def test_random_starts_and_food_cover_the_floor() -> None:
    layouts = [drawn(RECTANGLE, 1, key_of(seed)) for seed in range(300)]
    for places in ([x.starts[0][:2] for x in layouts if x], [x.foods[0] for x in layouts if x]):
        quarters = {(x > 325.0, y > 300.0) for x, y in places}
        assert len(quarters) == 4
    headings = [x.starts[0].heading for x in layouts if x]
    assert abs(sum(map(math.cos, headings)) / 300) < 0.17  # four standard errors
    assert abs(sum(map(math.sin, headings)) / 300) < 0.17


def test_draw_layout_without_room_is_false() -> None:
    assert not draw_layout(
        Start(), [Place() for _ in range(20)], 1, floor_of(CORRIDOR), arena_map_of(CORRIDOR), DEFAULT_VALUES
    )
    with pytest.raises(ValueError, match="corridor: no room for a robot and 20 food objects outside home"):
        random_layout(CORRIDOR, 20, 1, DEFAULT_VALUES)


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
        layout = drawn(RECTANGLE, 2, key_of(seed), decisions)
        assert layout is not None
        check_random(RECTANGLE, layout, decisions)
        nearest_wall = min(nearest_wall, *(RECTANGLE.clearance(food) for food in layout.foods))
        nearest_food = min(nearest_food, math.dist(*layout.foods))
        nearest_robot = min(nearest_robot, *(math.dist(f, layout.starts[0][:2]) for f in layout.foods))
    assert nearest_wall < decisions.food_to_walls + 10
    assert nearest_food < decisions.food_spacing + 25
    assert nearest_robot < decisions.close_to_food * MM_PER_PIXEL + 30


# ---------------------------------------------------------------- keys and food types


def test_keys_differ_between_seeds_episodes_and_purposes() -> None:
    keys = [
        purpose(key_of(seed), episode)
        for purpose in (layout_key, food_type_key)
        for seed in range(20)
        for episode in range(20)
    ]
    assert len(set(keys)) == len(keys)
    assert layout_key(key_of(3), 2) == layout_key(key_of(3), 2)


def types_of(foods: int, key: int, pickable: float, pushable: float) -> list[int]:
    objects = [FoodObject(0.0, 0.0) for _ in range(foods)]
    draw_food_types(objects, key, (pickable, pushable, 1 - pickable - pushable))
    assert all(food.known == FoodType.UNKNOWN for food in objects)
    return [food.type for food in objects]


def test_food_types_have_their_odds() -> None:
    types = types_of(4000, 12, 0.5, 0.3)
    shares = [types.count(t) / 4000 for t in (FoodType.PICKABLE, FoodType.PUSHABLE, FoodType.POISONOUS)]
    assert shares == pytest.approx([0.5, 0.3, 0.2], abs=0.03)  # four standard errors


def test_food_types_depend_on_key_and_number_alone() -> None:
    assert types_of(5, 12, 0.4, 0.3)[:3] == types_of(3, 12, 0.4, 0.3)
    assert types_of(50, 12, 0.4, 0.3) != types_of(50, 13, 0.4, 0.3)
