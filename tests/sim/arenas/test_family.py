"""The family of arenas: room for robots, step limits, and the camera's picture."""

import math
from itertools import combinations
from typing import Any

import pytest
import shapely

from khepera_forage.robots.khepera import RADIUS
from khepera_forage.sim.arena import Arena, copies
from khepera_forage.sim.arenas.named import FAMILY, HOME_RADIUS, family_arena, named_arena, step_limit
from khepera_forage.sim.layout_checks import check_layout, check_seen
from khepera_forage.sim.waypoints import check_paths, longest_path, too_narrow
from khepera_forage.sim.world import Layout
from tests.version_0_1 import SET_UP


def usable_floor(arena: Arena, clearance: float = 85.0) -> Any:
    """Where the centre of a robot with its gripper can be: a polygon, or several."""
    obstacles = shapely.union_all([shapely.Polygon(corners) for corners in arena.obstacles])
    return shapely.Polygon(arena.walls).difference(obstacles).buffer(-clearance)


def check_room(arena: Arena) -> None:
    """A robot reaches every part past the home, and a pair is in the camera's picture with room on its marks."""
    floor = usable_floor(arena)
    assert floor.geom_type == "Polygon"
    check_paths(arena)
    assert too_narrow(arena) == []
    home = shapely.Point(arena.home).buffer(arena.home_radius + RADIUS)
    assert floor.difference(home).geom_type == "Polygon"
    for place in (arena.home, arena.start, *arena.foods):
        assert floor.contains(shapely.Point(place[:2]))
    pair = copies(arena, 2)
    check_seen(pair)
    for each in pair:
        check_layout((each,), Layout((each.start,), each.foods))


everywhere = pytest.mark.parametrize("name", FAMILY)


def test_unknown_name_is_refused() -> None:
    with pytest.raises(ValueError, match="arena is 'circle'; allowed: an Arena, or one of 'corridor', 'rectangle', "):
        named_arena("circle", SET_UP)


@everywhere
def test_arena_has_room_for_robots_and_pairs(name: str) -> None:
    arena = family_arena(name)
    check_room(arena)
    assert arena.clearance(arena.home) >= HOME_RADIUS + RADIUS == arena.home_radius + RADIUS


@everywhere
def test_walls_that_do_not_touch_leave_passages_of_200_mm(name: str) -> None:
    arena = family_arena(name)
    shapes = [shapely.LinearRing(arena.walls), *map(shapely.Polygon, arena.obstacles)]
    gaps = [first.distance(second) for first, second in combinations(shapes, 2)]
    assert all(gap == 0 or gap >= 200 for gap in gaps)
    # Walls are at least 20 mm thick: an opening with this width removes none of their area but at corners.
    for shape in shapes[1:]:
        assert shape.buffer(-9.9).buffer(10).area > 0.95 * shape.area


@everywhere
def test_longest_path_is_that_of_the_floor(name: str) -> None:
    assert longest_path(family_arena(name)) <= FAMILY[name].longest_path
    assert FAMILY[name].longest_path <= 1.05 * longest_path(family_arena(name))


def test_step_limit_is_that_of_the_thesis_in_short_arenas_and_grows_with_the_path() -> None:
    assert [step_limit(foods, 650) for foods in (1, 2, 5)] == [500, 700, 1300]
    assert step_limit(1, 100) == 500
    assert step_limit(1, 1300) == 1000
    assert step_limit(2, 1301) == 1500
    assert math.isclose(FAMILY["t_maze"].limit, 1000)
