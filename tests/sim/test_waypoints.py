"""Paths through an arena: waypoints, shortest paths, and arenas that are too narrow."""

import math
from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
import shapely
from hypothesis import given
from hypothesis import strategies as st

from khepera_forage.geometry.paths import KEPT, NO_CORNERS, ChosenWaypoint, is_clear, next_waypoint
from khepera_forage.geometry.plane import clearance
from khepera_forage.sim.arena import Arena, Point, Pose
from khepera_forage.sim.arenas.named import box
from khepera_forage.sim.waypoints import (
    CLEARANCE,
    check_paths,
    is_home_free,
    path_length,
    path_tables_of,
    pixel_walls,
    shortest_path,
    too_narrow,
    way_out,
)
from khepera_forage.vision.scene import MM_PER_PIXEL
from tests.arenas import BLOCKS, L_ROOM
from tests.version_0_1 import CORRIDOR, RECTANGLE

ROOM = Arena("room", box(0, 0, 800, 800), Point(120, 120), 80.0, Pose(680, 680, math.pi), (Point(600, 300),))
BLOCK = replace(ROOM, name="block", obstacles=(box(300, 300, 500, 500),))
DOOR = replace(ROOM, name="door", obstacles=(box(390, 0, 410, 300), box(390, 500, 410, 800)))
CLOSED = replace(ROOM, name="closed", obstacles=(box(390, 0, 410, 340), box(390, 460, 410, 800)))
HALL = Arena("hall", box(0, 0, 2000, 2000), Point(1000, 1000), 80.0, Pose(200, 200, 0.0), (Point(1800, 1800),))
ACROSS = Arena("across", box(0, 0, 1100, 360), Point(550, 180), 170.0, Pose(150, 180, 0.0), (Point(300, 180),))
WINDING = [BLOCK, DOOR, L_ROOM]


@pytest.mark.parametrize("arena", [CORRIDOR, RECTANGLE, ROOM])
def test_ways_of_an_arena_without_inward_corners_are_straight(arena: Arena) -> None:
    assert path_tables_of(arena) == NO_CORNERS
    start = Point(arena.start.x, arena.start.y)
    assert shortest_path(arena, start, arena.home) == (start, arena.home)
    assert too_narrow(arena) == []
    x1, y1, x2, y2 = arena.bounds
    assert way_out(arena) == ((x1 + x2) / 2, (y1 + y2) / 2)


def test_a_home_from_wall_to_wall_is_a_barrier() -> None:
    check_paths(ACROSS)
    with pytest.raises(ValueError, match=r"no way between food 1 .* and the start .* that does not cross the home"):
        check_paths(replace(ACROSS, foods=(Point(900, 180),)))
    assert path_tables_of(replace(ACROSS, home=Point(930, 180))) == NO_CORNERS, "nothing lies behind it"


def test_home_is_free_where_a_robot_can_drive_all_the_way_round_it() -> None:
    assert is_home_free(HALL)
    assert not any(map(is_home_free, [CORRIDOR, RECTANGLE, ROOM, L_ROOM]))
    room = HALL.home_radius + 20.0 + CLEARANCE
    assert is_home_free(replace(HALL, home=Point(room, 1000)))
    assert not is_home_free(replace(HALL, home=Point(room - 1.0, 1000)))
    assert not is_home_free(replace(HALL, obstacles=(box(1000 + room - 1.0, 990, 1000 + room - 1.0 + 20, 1010),)))


@pytest.mark.parametrize("arena", WINDING, ids=lambda arena: arena.name)
@given(data=st.data())
def test_shortest_path_keeps_its_clearance_and_is_symmetric(arena: Arena, data: st.DataObject) -> None:
    floor = shapely.Polygon(arena.walls).difference(
        shapely.union_all([shapely.Polygon(obstacle) for obstacle in arena.obstacles])
    )
    inside = floor.buffer(-CLEARANCE)
    places = []
    for name in ("start", "goal"):
        x1, y1, x2, y2 = arena.bounds
        x, y = (data.draw(st.floats(x1, x2), label=f"{name} x"), data.draw(st.floats(y1, y2), label=f"{name} y"))
        if not shapely.contains_xy(inside, x, y) or math.dist((x, y), arena.home) < arena.home_radius + 40:
            return
        places.append(Point(x, y))
    if places[0] == places[1]:
        return
    path = shortest_path(arena, *places)
    line = shapely.LineString(path)
    assert line.length == pytest.approx(path_length(shortest_path(arena, *reversed(places))), rel=0.02)
    # A way passes a corner at 0.85 of the distance of its ends from the walls, and a short one may come nearer.
    nearest = 0.85 * CLEARANCE if path_length(path) > 2 * CLEARANCE else 0.0
    assert line.distance(floor.boundary) >= nearest


@pytest.mark.parametrize("arena", WINDING, ids=lambda arena: arena.name)
def test_way_home_from_every_free_place_is_the_shortest_of_all_clear_ones(arena: Arena) -> None:
    """Also from places beside walls, where a robot may start or food may lie."""
    rng, paths, walls = np.random.default_rng(0), path_tables_of(arena), pixel_walls(arena)
    home = arena.home.x / MM_PER_PIXEL, arena.home.y / MM_PER_PIXEL
    left, bottom, right, top = arena.bounds
    tried = around = 0
    while tried < 2000:
        place = Point(float(rng.uniform(left, right)), float(rng.uniform(bottom, top)))
        if arena.clearance(place) < 32.5:
            continue
        tried += 1
        path = shortest_path(arena, place, arena.home)
        for a, b in pairwise(path):
            x1, y1, x2, y2 = (end / MM_PER_PIXEL for end in (*a, *b))
            assert is_clear(x1, y1, x2, y2, False, walls, paths)
        if len(path) > 2:
            around += 1
            x, y = place.x / MM_PER_PIXEL, place.y / MM_PER_PIXEL
            best = min(
                math.dist((x, y), (point.x, point.y)) + rest
                for point, rest in zip(paths.waypoints, paths.home_lengths, strict=True)
                if is_clear(x, y, point.x, point.y, False, walls, paths)
            )
            assert next_waypoint(x, y, *home, False, ChosenWaypoint(), walls, paths)[2] == pytest.approx(best)
    assert around > 50


@pytest.mark.parametrize(("driven", "kept"), [(0.9 * KEPT, True), (1.1 * KEPT, False)])
def test_waypoint_is_kept_until_the_robot_has_driven_40_mm(driven: float, kept: bool) -> None:
    """Where another waypoint is on the shortest path by then, and the way to the first one is still clear."""
    rng, paths, walls, others = np.random.default_rng(4), path_tables_of(BLOCKS), pixel_walls(BLOCKS), 0
    home = BLOCKS.home.x / MM_PER_PIXEL, BLOCKS.home.y / MM_PER_PIXEL

    def choose(place: tuple[float, float], chosen: ChosenWaypoint) -> tuple[float, float]:
        return next_waypoint(*place, *home, False, chosen, walls, paths)[:2]

    for x, y, angle in rng.uniform((10, 20, -math.pi), (230, 160, math.pi), (3000, 3)).tolist():
        here, there = (x, y), (x + driven * math.cos(angle), y + driven * math.sin(angle))
        if any(
            clearance(*place, walls) <= 0 or is_clear(*place, *home, False, walls, paths) for place in (here, there)
        ):
            continue
        chosen = ChosenWaypoint()
        first, best = choose(here, chosen), choose(there, ChosenWaypoint())
        if best == first or math.dist(first, there) <= KEPT or not is_clear(*there, *first, False, walls, paths):
            continue
        others += 1
        assert choose(there, chosen) == (first if kept else best)
    assert others > 20


def test_check_ways_names_what_cannot_be_reached_and_the_narrow_place() -> None:
    with pytest.raises(ValueError, match=r"closed: there is no way between the start at \(680, 680\) mm") as error:
        check_paths(CLOSED)
    assert "too narrow near (400, 400) mm; allowed: passages that are 160 mm wide" in str(error.value)
    with pytest.raises(ValueError, match=r"there is no way between food 1 at \(600, 300\) mm"):
        check_paths(replace(CLOSED, start=Pose(200, 680, 0.0)))
    places: Any = {"home": Point(400, 100), "start": Pose(680, 100, 0.0), "foods": (Point(100, 100),)}
    alley = replace(ROOM, walls=box(0, 0, 800, 200), obstacles=(box(500, 0, 520, 20),), **places)
    with pytest.raises(ValueError, match=r"food 1 at .* and the start at .* that does not cross the home"):
        check_paths(alley)
