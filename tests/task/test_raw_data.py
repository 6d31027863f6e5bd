"""From scene and senses to raw data and state vector (4.2.2, 4.3)."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from khepera_forage.envs.forager import site_of
from khepera_forage.geometry.angles import turn_to
from khepera_forage.robots.khepera import Senses
from khepera_forage.sim.arena import CORRIDOR, copies
from khepera_forage.task.perception import (
    RawData,
    nearest_food,
    own_region,
    perceive,
    state_vector,
)
from khepera_forage.task.states import FoodType
from khepera_forage.vision.scene import Region, Scene

SITE, BESIDE = (site_of(arena) for arena in copies(CORRIDOR, 2))
OFFSET = BESIDE.home_y - SITE.home_y
SENSES = Senses((1, 2, 3, 4, 5, 6, 7, 8), 0, 0, 215, 200, 0)


def region(
    label: int, x: float, y: float, holes: int = 0, orientation: int = 0, found: bool = True
) -> Region:
    return Region(label, x, y, holes, orientation, found, False, x, y, 1.0, 1.0, 1.0)


def raw_data(scene: Scene, senses: Senses = SENSES, food_type: int = FoodType.UNKNOWN) -> RawData:
    own = own_region(scene, SITE, 2)
    assert own is not None
    return perceive(senses, own, nearest_food(scene, SITE, own.x, own.y, ()), food_type, SITE)


def test_own_region_is_told_by_holes_and_enclosure_and_not_by_order() -> None:
    mine, teachers, neighbours, food = (
        region(3, 40, 20, 2),
        region(0, 50, 20, 1),
        region(1, 40, 20 + OFFSET, 2),
        region(2, 60, 20),
    )
    for scene in (Scene((mine, teachers, neighbours, food)), Scene((food, neighbours, teachers, mine))):
        assert own_region(scene, SITE, 2) == mine
        assert own_region(scene, SITE, 1) == teachers
        assert own_region(scene, BESIDE, 2) == neighbours
    assert own_region(Scene((food,)), SITE, 2) is None


def test_nearest_food_is_of_the_own_enclosure_and_not_settled() -> None:
    near, far, over_there = region(1, 50, 20), region(2, 90, 20), region(3, 41, 20 + OFFSET)
    scene = Scene((far, region(0, 40, 20, 2), over_there, near))
    assert nearest_food(scene, SITE, 40, 20, ()) == near
    assert nearest_food(scene, SITE, 40, 20, {1}) == far
    assert nearest_food(scene, SITE, 40, 20, {1, 2}) is None


def test_raw_data_keep_what_the_thesis_lists() -> None:
    scene = Scene((region(0, 40.3, 20.7, 2, 90, found=False), region(1, 50.0, 20.7)))
    raw = raw_data(scene, SENSES._replace(object_presence=255), FoodType.PUSHABLE)
    assert raw.proximity == (1, 2, 3, 4, 5, 6)
    assert (raw.arm, raw.jaw, raw.object_presence) == (215, 200, 255)
    assert (raw.x, raw.y, raw.orientation, raw.tracked) == (40.3, 20.7, 90, False)
    assert (raw.food_seen, raw.food_x, raw.food_y, raw.food_type) == (True, 50.0, 20.7, FoodType.PUSHABLE)
    assert (raw.home_x, raw.home_y, raw.home_radius) == (110.0, 23.0, 20)
    assert raw.wall_distance == pytest.approx(20.7)
    assert raw.wall_bearing == pytest.approx(180.0, abs=1e-9) or raw.wall_bearing == pytest.approx(-180.0)


def test_food_type_reads_unknown_without_an_object() -> None:
    scene = Scene((region(0, 40, 20, 2), region(1, 50, 20)))
    assert raw_data(scene, SENSES, FoodType.PICKABLE).food_type == FoodType.UNKNOWN


@given(
    x=st.floats(0, 130),
    y=st.floats(0, 46),
    food_x=st.floats(0, 130),
    food_y=st.floats(0, 46),
    seen=st.booleans(),
)
def test_distances_are_whole_pixels_and_the_diagonal_stands_for_no_food(
    x: float, y: float, food_x: float, food_y: float, seen: bool
) -> None:
    regions = [region(0, x, y, 2)] + ([region(1, food_x, food_y)] if seen else [])
    vector = state_vector(raw_data(Scene(tuple(regions))), SITE.diagonal)
    assert all(type(value) is int or isinstance(value, FoodType) for value in vector)
    assert abs(vector.robot_home_distance - math.dist((x, y), (110, 23))) <= 0.5
    if seen:
        assert abs(vector.robot_food_distance - math.dist((x, y), (food_x, food_y))) <= 0.5
    else:
        assert vector.robot_food_distance == SITE.diagonal == 138


@given(direction=st.floats(-720, 720), orientation=st.floats(-720, 720))
def test_turns_are_the_short_way(direction: float, orientation: float) -> None:
    turn = turn_to(direction, orientation)
    assert -180.0 <= turn <= 180.0
    assert math.cos(math.radians(orientation + turn - direction)) == pytest.approx(1.0)
