"""The nearest wall that a robot remembers is the one that is found by looking at all walls."""

import math

import numpy as np
import pytest

from khepera_forage.envs.forager import arena_map_of
from khepera_forage.geometry.nearest_wall import NearestWall, to_nearest_wall
from khepera_forage.geometry.walls import to_wall
from khepera_forage.sim.arena import Arena
from tests.arenas import BLOCKS, L_ROOM


@pytest.mark.parametrize("arena", [L_ROOM, BLOCKS], ids=lambda arena: arena.name)
@pytest.mark.parametrize(("step", "most"), [(0.3, 0.1), (3.0, 0.5), (40.0, 1.0)])
def test_remembered_wall_is_the_nearest(arena: Arena, step: float, most: float) -> None:
    """Along random walks, with steps shorter and longer than a robot's."""
    known, rng, compared = arena_map_of(arena), np.random.default_rng(1), 0
    low, high = (known.left, known.bottom), (known.right, known.top)
    record, place, steps = NearestWall(), rng.uniform(low, high), 3000
    for _ in range(steps):
        place = np.clip(place + rng.normal(0, step, 2), low, high)
        x, y = place.tolist()
        ways = [to_wall(x, y, *wall[:5]) for wall in known.walls]
        before = record.x, record.y
        way = to_nearest_wall(record, x, y, known.walls)
        # Of two walls that are equally near, but for rounding, it may be either.
        assert math.hypot(*way) == pytest.approx(min(math.hypot(*one) for one in ways), abs=1e-9)
        assert any(way == pytest.approx(one, abs=1e-9) for one in ways)
        compared += (record.x, record.y) != before
    # Small steps do not need all walls each time; after long ones nearly always something has changed.
    assert compared < steps * most
    assert compared > steps / 4 or step < 40.0
