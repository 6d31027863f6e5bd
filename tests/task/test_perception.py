"""From scene and senses to raw data and state vector (4.2.2, 4.3)."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from khepera_forage.envs.layouts import arena_map_of
from khepera_forage.robots.khepera import Senses
from khepera_forage.sim.arena import copies
from khepera_forage.task.decisions import Decisions
from khepera_forage.task.food_tracking import FoodTracker
from khepera_forage.task.perception import RawData, own_region, raw_data, state_vector
from khepera_forage.task.states import FoodType
from khepera_forage.vision.scene import Region, Scene
from tests.version_0_1 import CORRIDOR

ARENA, NEXT_ARENA = (arena_map_of(arena) for arena in copies(CORRIDOR, 2))
OFFSET = NEXT_ARENA.home_y - ARENA.home_y
SENSES = Senses((1, 2, 3, 4, 5, 6, 7, 8), 0, 0, 215, 200, 0)


def region(
    label: int, x: float, y: float, holes: int = 0, orientation: int = 0, found: bool = True
) -> Region:
    return Region(label, x, y, holes, orientation, found, False, x, y, 1.0, 1.0, 1.0)


def perceived(scene: Scene, tracker: FoodTracker, senses: Senses = SENSES) -> RawData:
    """Raw data of the robot with the two-hole marker."""
    own = own_region(scene, ARENA, 2)
    assert own is not None
    home = ARENA.home_x, ARENA.home_y, 0.0
    return raw_data(senses, own, tracker, home, ARENA)


def test_own_region_has_the_markers_holes_in_the_own_arena_in_any_order() -> None:
    mine, teachers, neighbours, food = (
        region(3, 40, 20, 2),
        region(0, 50, 20, 1),
        region(1, 40, 20 + OFFSET, 2),
        region(2, 60, 20),
    )
    for scene in (Scene((mine, teachers, neighbours, food)), Scene((food, neighbours, teachers, mine))):
        assert own_region(scene, ARENA, 2) == mine
        assert own_region(scene, ARENA, 1) == teachers
        assert own_region(scene, NEXT_ARENA, 2) == neighbours
    assert own_region(Scene((food,)), ARENA, 2) is None


def test_raw_data_contain_what_the_thesis_lists() -> None:
    scene = Scene((region(0, 40.3, 20.7, 2, 90, found=False),))
    tracker = FoodTracker(food_seen=True, food_x=50.0, food_y=20.7, type_in_gripper=FoodType.PUSHABLE)
    raw = perceived(scene, tracker, SENSES._replace(object_presence=255))
    assert raw.proximity == (1, 2, 3, 4, 5, 6)
    assert (raw.arm, raw.jaw, raw.object_presence) == (215, 200, 255)
    assert (raw.x, raw.y, raw.orientation, raw.tracked) == (40.3, 20.7, 90, False)
    assert (raw.food_seen, raw.food_x, raw.food_y, raw.food_type) == (True, 50.0, 20.7, FoodType.PUSHABLE)
    assert (raw.home_x, raw.home_y, raw.home_radius) == (110.0, 23.0, 20)
    assert raw.wall_distance == pytest.approx(20.7)
    assert raw.wall_bearing == pytest.approx(180.0, abs=1e-9) or raw.wall_bearing == pytest.approx(-180.0)


@given(
    x=st.floats(0, 130),
    y=st.floats(0, 46),
    food_x=st.floats(0, 130),
    food_y=st.floats(0, 46),
    seen=st.booleans(),
)
def test_state_vector_has_whole_pixels_and_the_diagonal_without_food(
    x: float, y: float, food_x: float, food_y: float, seen: bool
) -> None:
    tracker = FoodTracker(food_seen=True, food_x=food_x, food_y=food_y) if seen else FoodTracker()
    vector = state_vector(
        perceived(Scene((region(0, x, y, 2),)), tracker), -1.0, ARENA.diagonal, Decisions().values()
    )
    assert all(type(value) is int or isinstance(value, FoodType) for value in vector)
    assert abs(vector.robot_home_distance - math.dist((x, y), (110, 23))) <= 0.5
    if seen:
        assert abs(vector.robot_food_distance - math.dist((x, y), (food_x, food_y))) <= 0.5
    else:
        assert vector.robot_food_distance == ARENA.diagonal == 138
