"""Robots that take food home past poison."""

import math

import pytest

from khepera_forage.envs.layouts import arena_map_of
from khepera_forage.geometry.paths import ChosenWaypoint
from khepera_forage.robots.khepera import FOOD_RADIUS, RADIUS
from khepera_forage.sim.arena import Arena, Point, Pose
from khepera_forage.task.arena_map import is_poison_about, past_poison, path_home
from khepera_forage.task.food_tracking import FoodObject, FoodTracker
from khepera_forage.task.placement import draw_food_types
from khepera_forage.task.states import FoodType
from khepera_forage.vision.scene import MM_PER_PIXEL

_CORNERS = (Point(0, 0), Point(1000, 0), Point(1000, 600), Point(0, 600))
HALL = arena_map_of(Arena("hall", _CORNERS, Point(900, 300), 80, Pose(100, 300, 0.0), (Point(500, 300),)))
HOME = (HALL.home_x, HALL.home_y)
ROBOT = (40.0, 60.0)
AHEAD = (100.0, 60.0)
TOUCH = (RADIUS + FOOD_RADIUS) / MM_PER_PIXEL


def _foods(place: tuple[float, float], known: FoodType = FoodType.POISONOUS) -> list[FoodObject]:
    """The food in the gripper, and one other object."""
    return [FoodObject(*ROBOT, known=FoodType.PICKABLE), FoodObject(*place, known=known)]


def _aim(foods: list[FoodObject]) -> tuple[float, float]:
    return past_poison(*ROBOT, *HOME, 0, foods, HALL)


def _distance_from_line(aim: tuple[float, float], place: tuple[float, float]) -> float:
    (x, y), (dx, dy) = ROBOT, (aim[0] - ROBOT[0], aim[1] - ROBOT[1])
    return abs((place[0] - x) * dy - (place[1] - y) * dx) / math.hypot(dx, dy)


@pytest.mark.parametrize("offset", [-8.0, -1.0, 0.0, 1.0, 8.0])
def test_way_past_poison_touches_it_nowhere(offset: float) -> None:
    place = AHEAD[0], AHEAD[1] + offset
    assert _distance_from_line(_aim(_foods(place)), place) == pytest.approx(TOUCH + 2.0)


def test_way_leads_past_the_other_side_if_a_wall_is_near() -> None:
    foods = _foods((100.0, 17.0))
    x, y = past_poison(40.0, 16.0, 160.0, 16.0, 0, foods, HALL)
    assert y > 16.0
    assert x > 40.0


def test_poison_without_room_beside_it_is_shoved() -> None:
    corners = (Point(0, 0), Point(1000, 0), Point(1000, 180), Point(0, 180))
    alley = arena_map_of(Arena("alley", corners, Point(900, 90), 80, Pose(100, 90, 0.0), (Point(500, 90),)))
    foods = _foods((100.0, 18.0))
    assert past_poison(40.0, 18.0, 160.0, 18.0, 0, foods, alley) == (160.0, 18.0)


@pytest.mark.parametrize("place", [(100.0, 70.0), (20.0, 60.0), (HOME[0] + 12.0, HOME[1]), (40.0, 68.0)])
def test_poison_beside_behind_or_beyond_is_not_in_the_way(place: tuple[float, float]) -> None:
    foods = _foods(place)
    assert _aim(foods) == HOME
    assert foods[1].side == 0


@pytest.mark.parametrize("known", [FoodType.PICKABLE, FoodType.PUSHABLE, FoodType.UNKNOWN])
def test_other_food_is_not_passed(known: FoodType) -> None:
    assert _aim(_foods(AHEAD, known)) == HOME
    assert not is_poison_about(0, _foods(AHEAD, known))


def test_unknown_food_is_passed_where_there_can_be_poison() -> None:
    foods = _foods(AHEAD, FoodType.UNKNOWN)
    draw_food_types(foods, 0, (0.5, 0.0, 0.5))
    assert _aim(foods) != HOME
    draw_food_types(foods, 0, (0.5, 0.5, 0.0))
    assert _aim(foods) == HOME


@pytest.mark.parametrize(("held", "straight"), [(-1, True), (0, False)])
def test_only_the_way_home_with_food_in_the_gripper_leads_past_poison(held: int, straight: bool) -> None:
    foods = _foods(AHEAD)
    way = path_home(*ROBOT, FoodTracker(held=held), foods, [ChosenWaypoint()] * 3, HALL)
    assert (way == (*HOME, 0.0)) is straight
    assert way[2] == 0.0


def test_side_stays_while_the_poison_is_in_the_way() -> None:
    foods = _foods((AHEAD[0], AHEAD[1] + 0.1))
    first = _aim(foods)
    foods[1].y = AHEAD[1] - 0.1
    assert (_aim(foods)[1] - ROBOT[1]) * (first[1] - ROBOT[1]) > 0.0
    foods[1].y = AHEAD[1] + 20.0
    assert _aim(foods) == HOME
    foods[1].y = AHEAD[1] - 0.1
    assert (_aim(foods)[1] - ROBOT[1]) * (first[1] - ROBOT[1]) < 0.0
