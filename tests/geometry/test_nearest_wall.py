"""The nearest wall that a robot remembers is the one that is found by looking at all walls."""

import math

import numpy as np
import pytest

from khepera_forage.envs.forager import arena_map_of
from khepera_forage.geometry.nearest_wall import NearestWall, is_among_four, to_nearest_wall
from khepera_forage.geometry.walls import to_wall
from khepera_forage.sim.arena import Arena
from tests.arenas import BLOCKS, L_ROOM


@pytest.mark.parametrize("arena", [L_ROOM, BLOCKS], ids=lambda arena: arena.name)
@pytest.mark.parametrize(("step", "most"), [(0.3, 0.1), (3.0, 0.5), (40.0, 1.0)])
def test_remembered_wall_is_the_nearest(arena: Arena, step: float, most: float) -> None:
    """Along random walks, with steps shorter and longer than a robot's."""
    known, rng, compared, among_four = arena_map_of(arena), np.random.default_rng(1), 0, 0
    low, high = (known.left, known.bottom), (known.right, known.top)
    record, place, steps = NearestWall(), rng.uniform(low, high), 3000
    for _ in range(steps):
        place = np.clip(place + rng.normal(0, step, 2), low, high)
        x, y = place.tolist()
        ways = [to_wall(x, y, *wall[:5]) for wall in known.walls]
        before = record.x, record.y
        if is_among_four(record, x, y):
            four = [ways[k] for k in (record.first, record.second, record.third, record.fourth)]
            assert min(math.hypot(*one) for one in four) == min(math.hypot(*one) for one in ways)
            among_four += 1
        # Where two walls meet, both are equally near, but for rounding.
        nearest = min(ways, key=lambda way: way[0] ** 2 + way[1] ** 2)
        assert to_nearest_wall(record, x, y, known.walls) == pytest.approx(nearest, abs=1e-9)
        compared += (record.x, record.y) != before
    assert among_four >= steps - compared
    # Small steps do not need all walls each time; after long ones nearly always something has changed.
    assert compared < steps * most
    assert compared > steps / 4 or step < 40.0
