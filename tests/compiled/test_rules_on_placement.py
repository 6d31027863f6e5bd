"""Layouts, food types and placement by hand: the same in Python and on records in compiled code."""

import math
from typing import Any

import numpy as np
import pytest

from khepera_forage.compilation.decorators import entrance
from khepera_forage.counter_rng import key_of
from khepera_forage.envs.arguments import food_odds
from khepera_forage.envs.compiled import rules  # noqa: F401 (registers the rules)
from khepera_forage.envs.compiled.parameters import (
    arena_map,
    floor,
    task_parameters,
)
from khepera_forage.envs.compiled.records import (
    food_object_dtype,
    place_dtype,
    start_dtype,
)
from khepera_forage.envs.forager import arena_map_of, floor_of
from khepera_forage.sim.arena import Arena, Point, Pose
from khepera_forage.sim.compiled import tracking  # noqa: F401 (registers the rules of association)
from khepera_forage.task.decisions import Decisions
from khepera_forage.task.food_tracking import (
    FoodObject,
)
from khepera_forage.task.placement import (
    Place,
    Start,
    draw_food_types,
    draw_layout,
    layout_key,
    place_by_hand,
)
from tests.compiled.rule_records import check_same, task_of
from tests.version_0_1 import CORRIDOR, RECTANGLE

BOX = Arena(
    name="box",
    walls=(Point(0, 0), Point(180, 0), Point(180, 180), Point(0, 180)),
    home=Point(90, 90),
    home_radius=80,
    start=Pose(90, 90, 0),
    foods=(Point(30, 30),),
)
PILLAR = Arena(
    name="pillar",
    walls=(Point(0, 0), Point(900, 0), Point(900, 700), Point(450, 500), Point(0, 700)),
    home=Point(800, 200),
    home_radius=90,
    start=Pose(100, 100, 0),
    foods=(Point(600, 200),),
    obstacles=((Point(300, 250), Point(400, 250), Point(400, 350), Point(300, 350)),),
)


@entrance
def _draw(start: Any, places: Any, foods: Any, key: Any, task: Any) -> bool:
    draw_food_types(foods, key, task.arena[0].odds)
    return draw_layout(start[0], places, key, floor(task), arena_map(task), task.decisions[0])


@pytest.mark.parametrize("arena", [CORRIDOR, RECTANGLE, PILLAR, BOX], ids=lambda arena: arena.name)
@pytest.mark.parametrize("count", [1, 2])
def test_drawn_layouts_and_types_are_the_same_on_records(arena: Arena, count: int) -> None:
    """Bit for bit, also where there is no room."""
    decisions = Decisions(food_spacing=80)
    odds = food_odds({"pickable": 1, "pushable": 1, "poisonous": 1})
    task = task_parameters(arena, 500, odds, decisions)
    for episode in range(40):
        key = layout_key(key_of(3), episode)
        start, places, foods = (
            Start(),
            [Place() for _ in range(count)],
            [FoodObject(0, 0) for _ in range(count)],
        )
        arrays = np.zeros(1, start_dtype), np.zeros(count, place_dtype), np.zeros(count, food_object_dtype)
        room = draw_layout(start, places, key, floor_of(arena), arena_map_of(arena), decisions.values())
        draw_food_types(foods, key, odds)
        assert _draw(*arrays, np.uint64(key), task) == room == (arena is not BOX)
        assert arrays[0].tolist() == [(start.x, start.y, start.heading)]
        assert arrays[1].tolist() == [(place.x, place.y) for place in places]
        assert arrays[2]["type"].tolist() == [food.type for food in foods]


@entrance
def _place(
    start: Any, places: Any, key: Any, mark: Any, marks: Any, error: float, heading_error: float, task: Any
) -> bool:
    return place_by_hand(start[0], places, key, mark[0], marks, error, heading_error, floor(task))


@pytest.mark.parametrize(("error", "degrees"), [(0.0, 0.0), (5.0, 3.0), (60.0, 40.0), (1e6, 0.0)])
def test_placement_by_hand_is_the_same_on_records(error: float, degrees: float) -> None:
    task, foods = task_of(RECTANGLE), RECTANGLE.foods
    marks = np.array([tuple(RECTANGLE.start)], start_dtype), np.array(list(map(tuple, foods)), place_dtype)
    for episode in range(40):
        key = layout_key(key_of(4), episode)
        start, places = Start(), [Place() for _ in foods]
        arrays = np.zeros(1, start_dtype), np.zeros(len(foods), place_dtype)
        errors = error, math.radians(degrees)
        free = place_by_hand(start, places, key, RECTANGLE.start, foods, *errors, floor_of(RECTANGLE))
        assert _place(*arrays, np.uint64(key), *marks, *errors, task) == free == (error < 1000)
        check_same(arrays[0], [start])
        check_same(arrays[1], places)
