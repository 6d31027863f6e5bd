"""Paths through an arena: the next waypoint is the best one, and is kept for a while."""

import math

import numpy as np
import pytest

from khepera_forage.envs.layouts import arena_map_of
from khepera_forage.geometry.paths import KEPT, ChosenWaypoint, has_path, is_clear, next_waypoint
from khepera_forage.geometry.plane import clearance, length
from khepera_forage.sim.arena import Arena
from tests.arenas import BLOCKS, L_ROOM

ARENAS = pytest.mark.parametrize("arena", [L_ROOM, BLOCKS], ids=lambda arena: arena.name)


@ARENAS
def test_next_waypoint_is_the_best_of_all_clear_ones(arena: Arena) -> None:
    known, rng, around = arena_map_of(arena), np.random.default_rng(2), 0
    home = known.home_x, known.home_y
    for x, y in rng.uniform((known.left, known.bottom), (known.right, known.top), (400, 2)).tolist():
        if clearance(x, y, known.walls) <= 0 or is_clear(x, y, *home, False, known.walls, known.paths):
            continue
        paths = [
            (length(point.x - x, point.y - y) + rest, point.x, point.y)
            for point, rest in zip(known.paths.waypoints, known.paths.home_lengths, strict=True)
            if is_clear(x, y, point.x, point.y, False, known.walls, known.paths)
        ]
        best, best_x, best_y = min(paths, default=(math.inf, x, y))
        chosen = ChosenWaypoint()
        assert next_waypoint(x, y, *home, False, chosen, known.walls, known.paths) == (best_x, best_y, best)
        assert has_path(x, y, *home, False, known.walls, known.paths) == bool(paths)
        around += bool(paths)
    assert around > 50


@pytest.mark.parametrize(("driven", "kept"), [(0.9 * KEPT, True), (1.1 * KEPT, False)])
def test_waypoint_is_kept_until_the_robot_has_driven_36_mm(driven: float, kept: bool) -> None:
    """Where another waypoint is on the shortest path by then, and the way to the first one is still clear."""
    known, rng, others = arena_map_of(BLOCKS), np.random.default_rng(4), 0
    paths, walls, home = known.paths, known.walls, (known.home_x, known.home_y)

    def choose(x: float, y: float, chosen: ChosenWaypoint) -> tuple[float, float, float]:
        return next_waypoint(x, y, *home, False, chosen, walls, paths)

    for x, y in rng.uniform((known.left, known.bottom), (known.right, known.top), (3000, 2)).tolist():
        angle = rng.uniform(-math.pi, math.pi)
        there = x + driven * math.cos(angle), y + driven * math.sin(angle)
        if any(
            clearance(*place, walls) <= 0 or is_clear(*place, *home, False, walls, paths) for place in ((x, y), there)
        ):
            continue
        chosen = ChosenWaypoint()
        first, best = choose(x, y, chosen)[:2], choose(*there, ChosenWaypoint())
        far = length(first[0] - there[0], first[1] - there[1])
        if best[:2] == first or far <= KEPT or not is_clear(*there, *first, False, walls, paths):
            continue
        others += 1
        later = choose(*there, chosen)
        assert later[:2] == (first if kept else best[:2])
        rest = paths.home_lengths[[(point.x, point.y) for point in paths.waypoints].index(later[:2])]
        assert later[2] == length(later[0] - there[0], later[1] - there[1]) + rest
    assert others > 20
