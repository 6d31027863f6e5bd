"""Which walls a robot senses and may touch: the same whether it was surveyed step by step or for the first time."""

import math

import numpy as np
import pytest

from khepera_forage.geometry.polygon import distance
from khepera_forage.robots.khepera import FINGER_TIP, RADIUS
from khepera_forage.robots.proximity import REACH
from khepera_forage.sim.arena import Arena, Pose
from khepera_forage.sim.broad_phase import PUSHED, WallWatch
from tests.arenas import BLOCKS, L_ROOM
from tests.version_0_1 import CORRIDOR

STEPS = 2000


@pytest.mark.parametrize("arena", [CORRIDOR, L_ROOM, BLOCKS], ids=lambda arena: arena.name)
def test_survey_along_a_way_is_the_same_as_the_first_one(arena: Arena) -> None:
    rng, watch = np.random.default_rng(1), WallWatch(arena.segments)
    x1, y1, x2, y2 = arena.bounds
    place, clear, far = rng.uniform((x1, y1), (x2, y2)), 0, 0
    for _ in range(STEPS):
        place = np.clip(place + rng.normal(0, 15, 2), (x1, y1), (x2, y2))
        x, y = place.tolist()
        watch.survey(x, y)
        assert watch.near == [wall for wall in arena.segments if distance(x, y, wall) < REACH]
        far += not watch.near
        fresh, pose = WallWatch(arena.segments), Pose(x, y, rng.uniform(-math.pi, math.pi))
        fresh.survey(x, y)
        travel, pushing = rng.uniform(0, 20), bool(rng.random() < 0.5)
        is_clear = watch.clear(pose, travel, pushing)
        assert is_clear == fresh.clear(pose, travel, pushing)
        if is_clear:
            clear += 1
            tip_x, tip_y = x + FINGER_TIP * math.cos(pose.heading), y + FINGER_TIP * math.sin(pose.heading)
            reach = PUSHED if pushing else RADIUS
            assert all(
                distance(x, y, wall) >= reach + travel and distance(tip_x, tip_y, wall) >= travel
                for wall in arena.segments
            )
    assert 0 < far < STEPS
    assert 0 < clear < STEPS
