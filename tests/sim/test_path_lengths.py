"""Lengths of shortest paths."""

import math
from dataclasses import replace

import pytest

from khepera_forage.sim.arena import Point
from khepera_forage.sim.arenas.named import box, family_arena
from khepera_forage.sim.ways import longest_path, path_length


def test_path_length_is_the_sum_of_its_legs() -> None:
    assert path_length((Point(0, 0), Point(30, 40), Point(30, 140))) == 150
    assert path_length((Point(5, 5),)) == 0


def test_longest_path_of_an_empty_room_ends_in_the_far_corner() -> None:
    room = family_arena("many_foods")
    assert longest_path(room) == pytest.approx(math.hypot(room.home.x - 85, room.home.y - 85))


def test_longest_path_goes_round_walls_and_leaves_out_what_cannot_be_reached() -> None:
    room = family_arena("many_foods")
    wall = replace(room, obstacles=(box(880, 240, 920, 900),))
    assert longest_path(wall) > 1.1 * longest_path(room)
    closed = replace(room, obstacles=(box(880, 0, 920, 900),))
    assert longest_path(closed) == pytest.approx(math.hypot(room.home.x - 1005, room.home.y - 85))
