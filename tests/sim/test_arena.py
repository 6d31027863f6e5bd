"""Arenas: those of the thesis, copies of them, and impossible ones."""

import math
from dataclasses import replace
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from khepera_forage.sim.arena import Arena, Point, Pose, copies
from khepera_forage.sim.arenas.named import box, named_arena
from khepera_forage.sim.arenas.thesis import THESIS_ARENAS
from tests.sim.worlds import ELL, FIELD
from tests.version_0_1 import CORRIDOR, RECTANGLE, SET_UP

PROPERTY = settings(derandomize=True, deadline=None, max_examples=100)
ALL = [CORRIDOR, RECTANGLE, ELL, FIELD]
offsets = st.floats(-3000, 3000)


# ---------------------------------------------------------------- the thesis's arenas


def test_arenas_have_the_sizes_of_section_3_1() -> None:
    assert CORRIDOR.bounds == (0, 0, 650, 230)
    assert RECTANGLE.bounds == (0, 0, 650, 600)
    assert CORRIDOR.diagonal == pytest.approx(math.hypot(650, 230))
    assert (len(CORRIDOR.foods), len(RECTANGLE.foods)) == (1, 2)
    assert THESIS_ARENAS == (CORRIDOR.name, RECTANGLE.name) == ("corridor", "rectangle")


# ---------------------------------------------------------------- clearance


# ---------------------------------------------------------------- copies


@given(st.sampled_from(ALL), offsets, offsets, st.floats(0, 700), st.floats(0, 700))
@PROPERTY
def test_copy_differs_in_its_place_only(arena: Arena, dx: float, dy: float, x: float, y: float) -> None:
    copy = arena.shifted(dx, dy)
    assert copy.clearance(Point(x + dx, y + dy)) == pytest.approx(arena.clearance(Point(x, y)), abs=1e-6)
    assert (copy.name, copy.home_radius, copy.start.heading) == (
        arena.name,
        arena.home_radius,
        arena.start.heading,
    )
    assert copy.diagonal == pytest.approx(arena.diagonal)
    pairs = zip(
        (*copy.walls, copy.home, copy.start, *copy.foods, *(c for o in copy.obstacles for c in o)),
        (*arena.walls, arena.home, arena.start, *arena.foods, *(c for o in arena.obstacles for c in o)),
        strict=True,
    )
    for there, here in pairs:
        assert (there[0] - dx, there[1] - dy) == pytest.approx(here[:2], abs=1e-6)


@pytest.mark.parametrize(("count", "gap"), [(0, 70.0), (-1, 70.0), (2, -1.0), (2, math.nan)])
def test_copies_refuse_a_count_below_1_and_a_negative_gap(count: int, gap: float) -> None:
    with pytest.raises(ValueError, match=rf"{count if count < 1 else gap}.*allowed: at least"):
        copies(CORRIDOR, count, gap)


# ---------------------------------------------------------------- impossible arenas

BLOCK = (Point(340, 80), Point(400, 80), Point(400, 150), Point(340, 150))


@pytest.mark.parametrize(
    ("change", "complaint"),
    [
        ({"home_radius": -1.0}, r"home_radius is -1\.0"),
        ({"home_radius": 0.0}, r"home_radius is 0\.0"),
        ({"home_radius": math.nan}, "home_radius is nan"),
        ({"home_radius": math.inf}, "home_radius is inf"),
        ({"home_radius": 101.0}, "radius 101 mm.*at most 100"),
        ({"home": Point(700, 115)}, r"home at \(700, 115\).*outside the walls"),
        ({"home": Point(math.nan, 115)}, "home at .*nan"),
        ({"home": Point(580, 115)}, "radius 100 mm.*at most 70"),
        ({"foods": ()}, "foods has 0 places; allowed: 1 to 16"),
        ({"foods": (Point(200, 115),) * 17}, "foods has 17 places; allowed: 1 to 16"),
        ({"foods": (Point(370, 115), Point(10, 115))}, r"food at \(10, 115\) mm is 10 mm from a wall"),
        ({"foods": (Point(370, 240),)}, r"food at \(370, 240\).*outside"),
        ({"foods": (Point(math.inf, 115),)}, "food at .*inf"),
        ({"obstacles": (BLOCK,)}, r"food at \(370, 115\) mm is inside a wall"),
        ({"obstacles": (BLOCK,), "foods": (Point(325, 115),)}, "food.* 15 mm from a wall"),
        ({"obstacles": ((Point(500, 100), Point(550, 100), Point(550, 150)),)}, "home"),
        ({"obstacles": ((Point(200, 20), Point(250, 20)),)}, "2 corners"),
        ({"obstacles": ((Point(200, 20), Point(250, 20), Point(math.nan, 50)),)}, "nan"),
        (
            {"obstacles": ((Point(200, 420), Point(250, 420), Point(225, 480)),)},
            r"obstacle \[\(200, 420\).* stands outside the walls; allowed: on the floor",
        ),
        ({"start": Pose(20, 115, 0)}, r"start at \(20, 115\) mm is 20 mm from a wall"),
        ({"start": Pose(-20, 115, 0)}, "start.*outside"),
        ({"start": Pose(math.nan, 115, 0)}, "start.*nan"),
        ({"start": Pose(90, 115, math.nan)}, "start.*nan"),
        ({"walls": CORRIDOR.walls[:2]}, "2 corners"),
        ({"walls": (*CORRIDOR.walls[:3], Point(0, math.nan))}, "nan"),
        ({"walls": (Point(0, 0), Point(650, 230), Point(650, 0), Point(0, 231))}, "cross"),
        ({"walls": tuple(Point(x, 0) for x in (0, 300, 650))}, "no area"),
    ],
)
def test_impossible_arena_is_refused_with_its_name(change: dict[str, Any], complaint: str) -> None:
    with pytest.raises(ValueError, match=rf"corridor: .*{complaint}"):
        replace(CORRIDOR, **change)


@pytest.mark.parametrize("name", ["", " ", 3])
def test_arena_without_a_name_is_refused(name: Any) -> None:
    with pytest.raises(ValueError, match=f"name of an arena is {name!r}; allowed: a text that is not empty"):
        replace(CORRIDOR, name=name)


def test_named_arena_refuses_an_unknown_name_and_a_set_up_that_does_not_fit() -> None:
    with pytest.raises(
        ValueError, match="arena is 'circle'; allowed: an Arena, or one of 'corridor', 'rectangle', 't_maze'"
    ):
        named_arena("circle", SET_UP)
    with pytest.raises(ValueError, match=r"corridor: home .* radius 100 mm reaches outside the walls"):
        named_arena("corridor", SET_UP._replace(home_to_wall=90.0))


@pytest.mark.parametrize(
    "obstacle",
    [
        (Point(200, -20), Point(250, -20), Point(225, 40)),  # with a corner on the floor
        (Point(195, -20), Point(205, -20), Point(205, 250), Point(195, 250)),  # without a corner on the floor
    ],
)
def test_obstacle_through_the_walls_is_refused(obstacle: tuple[Point, ...]) -> None:
    with pytest.raises(
        ValueError, match=r"corridor: obstacle .* reaches through the walls; allowed: on the floor"
    ):
        replace(CORRIDOR, obstacles=(obstacle,))


@pytest.mark.parametrize("offset", [0.0, 0.1, 1398.9128980311582])
def test_obstacles_may_touch_the_walls_and_one_another(offset: float) -> None:
    """At an offset, too, where their corners are rounded."""
    pieces = box(190, 0.3, 210, 60.7), box(190, 60.7, 260, 80.1), box(210, 0, 230, 60.7)
    slanted = (Point(200, 230), Point(233.3, 150.1), Point(266.6, 230))
    replace(CORRIDOR, obstacles=(*pieces, slanted)).shifted(offset, offset)


@pytest.mark.parametrize(
    "other",
    [
        box(210, 40, 230, 60),  # crossing
        box(195, 25, 205, 35),  # inside
        box(190, 20, 220, 50),  # the same
        (Point(205, 10), Point(215, 10), Point(210, 20.1)),  # a tip
    ],
)
def test_obstacles_that_overlap_are_refused(other: tuple[Point, ...]) -> None:
    first = box(190, 20, 220, 50)
    with pytest.raises(
        ValueError, match=r"corridor: obstacles \[\(190.* and \[.* overlap; allowed: beside one another"
    ):
        replace(CORRIDOR, obstacles=(first, box(300, 10, 320, 20), other))
