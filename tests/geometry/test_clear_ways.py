"""Straight ways: what is known of one stays true while its ends move little, and the best waypoint is found."""

import math

import numpy as np
import pytest
from khepera_forage.geometry.known_ways import StraightWay, is_known_clear, room_beside
from khepera_forage.geometry.straight_ways import is_clear

from khepera_forage.envs.forager import arena_map_of
from khepera_forage.geometry.angles import length
from khepera_forage.geometry.paths import KEPT, has_path, next_waypoint
from khepera_forage.geometry.walls import clearance
from khepera_forage.sim.arena import Arena
from tests.arenas import BLOCKS, L_ROOM

ARENAS = pytest.mark.parametrize("arena", [L_ROOM, BLOCKS], ids=lambda arena: arena.name)


@ARENAS
def test_clear_way_stays_clear_while_its_ends_move_within_its_room(arena: Arena) -> None:
    known, rng, clear, moved = arena_map_of(arena), np.random.default_rng(1), 0, 0
    low, high = (known.left, known.bottom), (known.right, known.top)
    for _ in range(1500):
        (x, y), (to_x, to_y) = rng.uniform(low, high), rng.uniform(low, high)
        if not is_clear(x, y, to_x, to_y, False, known.walls, known.ways):
            continue
        room, clear = room_beside(x, y, to_x, to_y, known.walls, known.ways), clear + 1
        if room > 0:
            angles, moved = rng.uniform(-math.pi, math.pi, (8, 2)), moved + 1
            # It also stays clear while its ends move along it.
            shares = rng.uniform(0, 1, (8, 2)).tolist()
            for (here, there), (near, far) in zip(
                (room * 0.999 * np.exp(1j * angles)).tolist(), shares, strict=True
            ):
                begin = x + near * (to_x - x) + here.real, y + near * (to_y - y) + here.imag
                end = to_x + far * (x - to_x) + there.real, to_y + far * (y - to_y) + there.imag
                assert is_clear(*begin, *end, False, known.walls, known.ways)
    assert moved == clear > 100


@ARENAS
@pytest.mark.parametrize("past_home", [False, True])
def test_known_way_is_the_same_as_one_examined_anew(arena: Arena, past_home: bool) -> None:
    """Along paths through the arena, with the steps of a robot and the errors of a camera."""
    known, rng = arena_map_of(arena), np.random.default_rng(3)
    low, high = (known.left, known.bottom), (known.right, known.top)
    both = {True: 0, False: 0}
    examined = 0
    for _ in range(30):
        (x, y), (goal_x, goal_y), (to_x, to_y) = rng.uniform(low, high, (3, 2)).tolist()
        way = StraightWay()
        steps = 60
        for k in range(steps):
            share = k / steps
            here_x = x + share * (goal_x - x) + rng.normal(0, 0.1)
            here_y = y + share * (goal_y - y) + rng.normal(0, 0.1)
            there_x, there_y = to_x + rng.normal(0, 0.1), to_y
            before = way.x, way.y
            found = is_known_clear(way, here_x, here_y, there_x, there_y, past_home, known.walls, known.ways)
            assert found == is_clear(here_x, here_y, there_x, there_y, past_home, known.walls, known.ways)
            both[found] += 1
            examined += (way.x, way.y) != before
    assert min(both.values()) > 100
    assert examined < 30 * 60 / 2


@ARENAS
def test_next_waypoint_is_the_best_of_all_clear_ones(arena: Arena) -> None:
    """Whichever waypoint is tried first, and also if the ways to waypoints are known from other places."""
    known, rng, around = arena_map_of(arena), np.random.default_rng(2), 0
    home = known.home_x, known.home_y
    to_waypoints, straight = [StraightWay() for _ in known.ways.waypoints], StraightWay()
    for x, y in rng.uniform((known.left, known.bottom), (known.right, known.top), (400, 2)).tolist():
        if clearance(x, y, known.walls) <= 0 or is_clear(x, y, *home, False, known.walls, known.ways):
            continue
        paths = [
            (length(point.x - x, point.y - y) + rest, point.x, point.y)
            for point, rest in zip(known.ways.waypoints, known.ways.home_lengths, strict=True)
            if is_clear(x, y, point.x, point.y, False, known.walls, known.ways)
        ]
        best, best_x, best_y = min(paths, default=(math.inf, x, y))
        given = known.ways.home_lengths, False, straight, to_waypoints, known.walls, known.ways
        assert next_waypoint(x, y, *given) == (best_x, best_y, best)
        assert has_path(x, y, *home, known.ways.home_lengths, False, known.walls, known.ways) == bool(paths)
        around += bool(paths)
    assert around > 50


@pytest.mark.parametrize(("driven", "kept"), [(0.9 * KEPT, True), (1.1 * KEPT, False)])
def test_waypoint_is_kept_until_the_robot_has_driven_36_mm(driven: float, kept: bool) -> None:
    """Where another waypoint is on the shortest path by then, and the way to the first one is still clear."""
    known, rng, others = arena_map_of(BLOCKS), np.random.default_rng(4), 0
    ways, walls, home = known.ways, known.walls, (known.home_x, known.home_y)

    def choose(x: float, y: float, straight: StraightWay) -> tuple[float, float, float]:
        assert not is_known_clear(straight, x, y, *home, False, walls, ways)
        to_waypoints = [StraightWay() for _ in ways.waypoints]
        return next_waypoint(x, y, ways.home_lengths, False, straight, to_waypoints, walls, ways)

    for x, y in rng.uniform((known.left, known.bottom), (known.right, known.top), (3000, 2)).tolist():
        angle = rng.uniform(-math.pi, math.pi)
        there = x + driven * math.cos(angle), y + driven * math.sin(angle)
        if any(
            clearance(*place, walls) <= 0 or is_clear(*place, *home, False, walls, ways)
            for place in ((x, y), there)
        ):
            continue
        straight = StraightWay()
        first, best = choose(x, y, straight)[:2], choose(*there, StraightWay())
        far = length(first[0] - there[0], first[1] - there[1])
        if best[:2] == first or far <= KEPT or not is_clear(*there, *first, False, walls, ways):
            continue
        others += 1
        later = choose(*there, straight)
        assert later[:2] == (first if kept else best[:2])
        rest = ways.home_lengths[[(point.x, point.y) for point in ways.waypoints].index(later[:2])]
        assert later[2] == length(later[0] - there[0], later[1] - there[1]) + rest
    assert others > 20
