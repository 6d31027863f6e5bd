"""Arenas: those of the thesis, copies of them, and impossible ones."""

import math
import re
from dataclasses import replace
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from khepera_forage.sim.arena import Arena, Point, Pose, copies
from khepera_forage.sim.arenas.named import box
from khepera_forage.sim.arenas.thesis import THESIS_ARENAS
from tests.arenas import POOL, corners
from tests.version_0_1 import CORRIDOR, RECTANGLE

offsets = st.floats(-3000, 3000)


def test_arenas_have_the_sizes_of_section_3_1() -> None:
    assert CORRIDOR.bounds == (0, 0, 650, 230)
    assert RECTANGLE.bounds == (0, 0, 650, 600)
    assert CORRIDOR.diagonal == pytest.approx(math.hypot(650, 230))
    assert (len(CORRIDOR.foods), len(RECTANGLE.foods)) == (1, 2)
    assert THESIS_ARENAS == (CORRIDOR.name, RECTANGLE.name) == ("corridor", "rectangle")


@given(st.sampled_from((CORRIDOR, *POOL)), offsets, offsets, st.floats(0, 700), st.floats(0, 700))
def test_copy_differs_in_its_place_only(arena: Arena, dx: float, dy: float, x: float, y: float) -> None:
    copy = arena.shifted(dx, dy)
    assert copy.clearance(Point(x + dx, y + dy)) == pytest.approx(arena.clearance(Point(x, y)), abs=1e-6)
    assert (copy.name, copy.home_radius, copy.start.heading) == (arena.name, arena.home_radius, arena.start.heading)
    assert copy.diagonal == pytest.approx(arena.diagonal)
    pairs = zip(
        (*copy.walls, copy.home, copy.start, *copy.foods, *(c for o in copy.obstacles for c in o)),
        (*arena.walls, arena.home, arena.start, *arena.foods, *(c for o in arena.obstacles for c in o)),
        strict=True,
    )
    for there, here in pairs:
        assert (there[0] - dx, there[1] - dy) == pytest.approx(here[:2], abs=1e-6)


def test_copies_refuse_a_count_below_1() -> None:
    with pytest.raises(ValueError, match="0 copies of an arena; allowed: at least 1"):
        copies(CORRIDOR, 0)


# ---------------------------------------------------------------- impossible arenas


def walls(*places: tuple[float, float]) -> dict[str, Any]:
    return {"walls": corners(*places)}


def obstacle(*places: tuple[float, float]) -> dict[str, Any]:
    return {"obstacles": (corners(*places),)}


BLOCK = obstacle((340, 80), (400, 80), (400, 150), (340, 150))
FIRST = box(190, 20, 220, 50)
OVERLAP = r"obstacles \[\(190.* and \[.* overlap; allowed: beside one another"
IMPOSSIBLE: list[tuple[dict[str, Any], str]] = [
    *(({"home_radius": wrong}, f"home_radius is {wrong}") for wrong in (4.0, math.nan, math.inf)),
    ({"home_radius": 101.0}, "radius 101 mm.*at most 100"),
    ({"home": Point(700, 115)}, r"home at \(700, 115\).*outside the walls"),
    ({"foods": ()}, "foods has 0 places; allowed: 1 to 16"),
    ({"foods": (Point(200, 115),) * 17}, "foods has 17 places; allowed: 1 to 16"),
    ({"foods": corners((370, 115), (10, 115))}, r"food at \(10, 115\) mm is 10 mm from a wall"),
    (BLOCK, r"food at \(370, 115\) mm is inside a wall"),
    ({"start": Pose(20, 115, 0)}, r"start at \(20, 115\) mm is 20 mm from a wall"),
    ({"start": Pose(90, 115, math.nan)}, "start.*nan"),
    (walls((0, 0), (650, 0)), r"walls are \[\(0, 0\), \(650, 0\)\]; allowed: at least 3 corners"),
    (walls((0, 0), (650, 0), (650, 230), (0, math.nan)), "nan"),
    (walls((0, 0), (300, 0), (650, 0)), "no area"),
    (walls((0, 0), (100, 100), (100, 0), (0, 100)), r"cross or touch at \(50, 50\)"),
    (walls((0, 0), (300, 0), (300, 300), (150, 0), (0, 300)), r"cross or touch at \(150, 0\)"),  # at a corner
    (walls((0, 0), (300, 0), (300, 300), (300, 100), (300, 200), (0, 300)), "cross"),  # back on itself
    (walls((0, 0), (300, 0), (300, 300), (0, 0)), r"corner \(0, 0\) follows itself"),
    (obstacle((500, 100), (550, 100), (550, 150)), "home"),
    (obstacle((200, 20), (250, 20)), "at least 3 corners"),
    (obstacle((200, 420), (250, 420), (225, 480)), r"obstacle \[\(200, 420\).* stands outside the walls; allowed: "),
    # Through the walls, with and without a corner on the floor.
    (obstacle((200, -20), (250, -20), (225, 40)), "obstacle .* reaches through the walls; allowed: on the floor"),
    ({"obstacles": (box(195, -20, 205, 250),)}, "obstacle .* reaches through the walls; allowed: on the floor"),
    # Crossing, inside, the same, and with a tip.
    *(({"obstacles": (FIRST, box(300, 10, 320, 20), other)}, OVERLAP) for other in (
        box(210, 40, 230, 60), box(195, 25, 205, 35), FIRST, corners((205, 10), (215, 10), (210, 20.1)))),
]  # fmt: skip


@pytest.mark.parametrize(("change", "complaint"), IMPOSSIBLE)
def test_impossible_arena_is_refused_with_its_name(change: dict[str, Any], complaint: str) -> None:
    with pytest.raises(ValueError, match=rf"corridor: .*{complaint}"):
        replace(CORRIDOR, **change)


@pytest.mark.parametrize("name", ["", " den", "a\nb", 3])
def test_arena_without_a_name_is_refused(name: Any) -> None:
    with pytest.raises(ValueError, match=re.escape(f"name of an arena is {name!r}; allowed: a text on one line")):
        replace(CORRIDOR, name=name)


@pytest.mark.parametrize("offset", [0.0, 0.1, 1398.9128980311582])
def test_walls_may_run_either_way_and_lie_in_one_line_and_obstacles_may_touch(offset: float) -> None:
    """At an offset, too, where corners are rounded."""
    pieces = box(190, 0.3, 210, 60.7), box(190, 60.7, 260, 80.1), box(210, 0, 230, 60.7)
    slanted = corners((200, 230), (233.3, 150.1), (266.6, 230))
    comb = corners((0, 230), (0, 0), (650, 0), (650, 230), (450, 230), (450, 210), (420, 210), (420, 230))
    for around in (CORRIDOR.walls, CORRIDOR.walls[::-1], comb, comb[::-1]):
        replace(CORRIDOR, walls=around, obstacles=(*pieces, slanted)).shifted(offset, offset)
