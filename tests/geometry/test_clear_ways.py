"""Ways that stay clear while their ends move, and the order in which waypoints are tried."""

import math

import numpy as np
import pytest

from khepera_forage.envs.forager import arena_map_of
from khepera_forage.geometry.angles import length
from khepera_forage.geometry.paths import is_clear, next_waypoint, room_beside
from khepera_forage.geometry.walls import clearance
from khepera_forage.sim.arena import Arena
from tests.arenas import BLOCKS, L_ROOM

ARENAS = pytest.mark.parametrize("arena", [L_ROOM, BLOCKS], ids=lambda arena: arena.name)


@ARENAS
@pytest.mark.parametrize("past_home", [False, True])
def test_clear_way_stays_clear_while_its_ends_move_within_its_room(arena: Arena, past_home: bool) -> None:
    known, rng, moved = arena_map_of(arena), np.random.default_rng(1), 0
    low, high = (known.left, known.bottom), (known.right, known.top)
    for _ in range(1500):
        (x, y), (to_x, to_y) = rng.uniform(low, high), rng.uniform(low, high)
        to_walls = min(clearance(x, y, known.walls), clearance(to_x, to_y, known.walls))
        if to_walls <= 0 or not is_clear(x, y, to_x, to_y, past_home, known.walls, known.ways):
            continue
        room = min(room_beside(x, y, to_x, to_y, past_home, known.ways), to_walls)
        if room > 0:
            angles, moved = rng.uniform(-math.pi, math.pi, (8, 2)), moved + 1
            for here, there in (room * 0.999 * np.exp(1j * angles)).tolist():
                ends = x + here.real, y + here.imag, to_x + there.real, to_y + there.imag
                assert is_clear(*ends, past_home, known.walls, known.ways)
    assert moved > 100


@ARENAS
def test_next_waypoint_is_the_best_of_all_clear_ones(arena: Arena) -> None:
    known, rng, around = arena_map_of(arena), np.random.default_rng(2), 0
    home = known.home_x, known.home_y
    for x, y in rng.uniform((known.left, known.bottom), (known.right, known.top), (400, 2)).tolist():
        if clearance(x, y, known.walls) <= 0 or is_clear(x, y, *home, False, known.walls, known.ways):
            continue
        paths = [
            (length(point.x - x, point.y - y) + rest, point.x, point.y)
            for point, rest in zip(known.ways.waypoints, known.ways.home_lengths, strict=True)
            if is_clear(x, y, point.x, point.y, False, known.walls, known.ways)
        ]
        best, best_x, best_y = min(paths, default=(math.inf, *home))
        found = next_waypoint(x, y, *home, known.ways.home_lengths, False, known.walls, known.ways)
        assert found == (best_x, best_y, best)
        around += bool(paths)
    assert around > 50
