"""Arenas by name and procedural arenas: room for robots, step limits, the same everywhere, disjoint splits."""

import pickle
from dataclasses import replace
from itertools import combinations
from typing import Any
from zlib import crc32

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from khepera_forage.robots.khepera import RADIUS
from khepera_forage.sim.arena import Arena, copies
from khepera_forage.sim.arena_file import arena_text
from khepera_forage.sim.arenas.difficulty import DIFFICULTIES, Difficulty, checked_difficulty
from khepera_forage.sim.arenas.named import FAMILY, HOME_RADIUS, family_arena, named_arena
from khepera_forage.sim.arenas.procedural import LEVELS, ProceduralArenas, procedural_arena
from khepera_forage.sim.arenas.procedural_floor import PASSAGE
from khepera_forage.sim.layout_checks import check_layout, check_seen
from khepera_forage.sim.waypoints import check_paths, longest_path, too_narrow
from khepera_forage.sim.world import Layout
from tests.version_0_1 import SET_UP

of_all_difficulties = pytest.mark.parametrize("difficulty", DIFFICULTIES)


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


def test_unknown_name_is_refused() -> None:
    with pytest.raises(ValueError, match="arena is 'circle'; allowed: an Arena, or one of 'corridor', 'rectangle', "):
        named_arena("circle", SET_UP)


@pytest.mark.parametrize("name", FAMILY)
def test_arena_has_room_for_robots_and_pairs_and_passages_of_200_mm(name: str) -> None:
    arena = family_arena(name)
    check_room(arena)
    assert arena.clearance(arena.home) >= HOME_RADIUS + RADIUS == arena.home_radius + RADIUS
    assert longest_path(arena) <= FAMILY[name].longest_path <= 1.05 * longest_path(arena)
    shapes = [shapely.LinearRing(arena.walls), *map(shapely.Polygon, arena.obstacles)]
    gaps = [first.distance(second) for first, second in combinations(shapes, 2)]
    assert all(gap == 0 or gap >= 200 for gap in gaps)
    # Walls are at least 20 mm thick: an opening with this width removes none of their area but at corners.
    for shape in shapes[1:]:
        assert shape.buffer(-9.9).buffer(10).area > 0.95 * shape.area


# ---------------------------------------------------------------- procedural arenas


@of_all_difficulties
@settings(max_examples=30)
@given(level=st.integers(0, 2 * LEVELS))
def test_level_has_room_for_robots_and_pairs_and_what_its_difficulty_says(difficulty: str, level: int) -> None:
    arena, chosen = procedural_arena(level, difficulty), DIFFICULTIES[difficulty]
    check_room(arena)
    # No slits: a place with some room around it is beside the floor that robots use.
    slits = usable_floor(arena, 50).difference(usable_floor(arena).buffer(60))
    assert slits.area == pytest.approx(0, abs=1)
    left, bottom, right, top = arena.bounds
    assert (left, bottom) == (0, 0)
    assert chosen.length[0] <= max(right, top) <= max(chosen.length[1], chosen.width[1])
    assert chosen.width[0] <= min(right, top) <= chosen.width[1]
    assert len(arena.segments) <= chosen.most_walls <= 30
    assert len(arena.foods) == chosen.foods
    outer = shapely.LinearRing(arena.walls)
    shapes = [shapely.Polygon(corners) for corners in arena.obstacles]
    free = [shape for shape in shapes if shape.distance(outer) > 0]
    assert chosen.blocks[0] <= len(free) <= chosen.blocks[1]
    assert chosen.partitions[0] <= len(shapes) - len(free) <= 2 * chosen.partitions[1]
    for shape in free:
        others = [outer, *(other for other in shapes if other is not shape)]
        assert min(map(shape.distance, others)) > PASSAGE - 1e-6
    assert (len(arena.walls) - 4) / 2 in range(chosen.notches[0], chosen.notches[1] + 1)


@of_all_difficulties
def test_step_limit_allows_for_the_paths_of_nearly_all_levels(difficulty: str) -> None:
    paths = [longest_path(arena) for arena in ProceduralArenas(difficulty, num_levels=40)]
    assert np.quantile(paths, 0.95) <= DIFFICULTIES[difficulty].longest_path
    assert DIFFICULTIES[difficulty].longest_path <= 1.3 * max(paths)


@pytest.mark.parametrize(
    ("difficulty", "expected"),
    [("easy", 1618678405), ("medium", 1564153441), ("hard", 3192213929), ("extreme", 1919782940)],
)
def test_levels_are_those_of_version_1(difficulty: str, expected: int) -> None:
    """Results name levels: a generator with other arenas needs environments of another version."""
    arenas = [procedural_arena(level, difficulty) for level in (*range(20), LEVELS, LEVELS + 1)]
    assert crc32("".join(map(arena_text, arenas)).encode()) == expected


def test_sequence_is_of_consecutive_levels_of_a_split() -> None:
    train = ProceduralArenas("easy", num_levels=5, start_level=10)
    test = ProceduralArenas("easy", "test", 5, 10)
    assert len(train) == len(test) == 5
    assert list(train) == [procedural_arena(level, "easy") for level in range(10, 15)]
    assert list(test) == [procedural_arena(LEVELS + level, "easy") for level in range(10, 15)]
    assert train[-1] is train[4] is procedural_arena(14, "easy")
    assert train[1:3] == (train[1], train[2])
    assert train[np.int64(2)] == train[2]
    assert train[0].name == "procedural_easy_10"
    with pytest.raises(IndexError):
        train[5]


def test_sequence_can_be_compared_copied_and_used_as_a_key() -> None:
    arenas = ProceduralArenas("hard", "test", 7, 3)
    assert pickle.loads(pickle.dumps(arenas)) == arenas
    assert len({arenas, ProceduralArenas("hard", "test", 7, 3), ProceduralArenas("hard")}) == 2
    assert len(pickle.dumps(arenas)) < 300


# ---------------------------------------------------------------- bad input


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"difficulty": "brutal"}, "difficulty is 'brutal'; allowed: 'easy', 'medium', 'hard', 'extreme', or a Diff"),
        ({"num_levels": 2.5}, r"num_levels is 2\.5; allowed: a whole number of at least 1"),
        ({"start_level": -1}, "start_level is -1; allowed: a whole number of at least 0"),
        ({"start_level": LEVELS - 100}, "start_level 999900 \\+ num_levels 200 is 1000100; allowed: at most 1000000"),
    ],
)  # fmt: skip
def test_sequence_refuses_what_is_not_allowed(arguments: dict[str, object], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        ProceduralArenas(**arguments)  # type: ignore[arg-type]


@pytest.mark.parametrize("level", [-1, 1.5, "3", True])
def test_generator_refuses_what_is_no_level(level: object) -> None:
    with pytest.raises(ValueError, match=f"level is {level!r}; allowed: a whole number of at least 0"):
        procedural_arena(level)


CROWDED = replace(DIFFICULTIES["easy"], name="crowded", foods=16)


def test_difficulty_without_room_for_its_food_is_an_error() -> None:
    with pytest.raises(
        ValueError, match=r"difficulty 'crowded': no room for 16 food objects.* in level 3 after.*allowed: fewer"
    ):
        procedural_arena(3, CROWDED)
    assert len(procedural_arena(3, replace(CROWDED, length=(2000, 2400), width=(1100, 1165))).foods) == 16
    with pytest.raises(ValueError, match=r"1 partitions .* there are more than 7 walls; allowed: fewer of them, more"):
        procedural_arena(3, replace(DIFFICULTIES["hard"], notches=(0, 0), blocks=(0, 0), most_walls=7))


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"length": (2000, 2500)}, r"length is \(2000, 2500\); allowed: two whole numbers in increasing order, 500 to"),
        ({"width": (700, 600)}, r"width is \(700, 600\); allowed"),
        ({"notches": 2}, "notches is 2; allowed"),
        ({"partitions": (0.0, 1.0)}, r"partitions is \(0\.0, 1\.0\); allowed"),
        ({"foods": 17}, "foods is 17; allowed: 1 to 16"),
        ({"most_walls": 3}, "most_walls is 3; allowed: a number of at least 4"),
        ({"noise": float("nan")}, "noise is nan; allowed"),
    ],
)  # fmt: skip
def test_difficulty_refuses_values_out_of_range(change: dict[str, object], message: str) -> None:
    with pytest.raises(ValueError, match=f"difficulty 'easy': {message}"):
        replace(DIFFICULTIES["easy"], **change)  # type: ignore[arg-type]


def test_difficulty_of_ones_own_is_accepted() -> None:
    own = Difficulty("own", (700, 700), (500, 500), (0, 0), (0, 0), (0, 0), 4, 1, 700)
    assert checked_difficulty(own) is own
    assert procedural_arena(0, own).name == "procedural_own_0"
    assert max(procedural_arena(0, own).bounds) == 700
    assert (own.limit, dict(own.food_types)) == (600, {"PICKABLE": 1.0})
