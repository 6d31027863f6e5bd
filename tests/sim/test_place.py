"""`World.place`: an operator puts a robot down elsewhere (5.3.1)."""

import math

import numpy as np
import pytest

from khepera_forage.robots.khepera import JAW_CLOSED
from khepera_forage.sim.arena import Point, Pose, copies
from khepera_forage.sim.pymunk.world import PymunkWorld
from khepera_forage.sim.world import Layout
from tests.sim.worlds import NONE, holding, make_world, run
from tests.version_0_1 import CORRIDOR, TIMING

CENTRE = Pose(1000, 1000, 0)


def test_placed_robot_keeps_the_food_it_holds() -> None:
    world = holding()
    world.place(0, Pose(500, 600, math.pi / 2))
    x, y, _ = world.poses()[0]
    run(world, 3, jaw=JAW_CLOSED)
    assert (x, y) == (500, 600)
    assert world.food_places()[0][:2] == pytest.approx((500, 657), abs=2)
    assert world.food_places()[0].lifted
    with pytest.raises(ValueError, match=r"robot at \(10, 600\)"):
        world.place(0, Pose(10, 600, 0))
    assert world.poses()[0][:2] == pytest.approx((500, 600), abs=0.1)


def test_place_refuses_a_taken_or_impossible_pose() -> None:
    world = make_world(CENTRE, (1500, 1500))
    for pose in (Pose(1500, 1470, 0), Pose(500, 500, math.nan)):
        with pytest.raises(ValueError, match="robot at"):
            world.place(0, pose)
        assert world.poses()[0] == CENTRE


def test_place_refuses_another_arena() -> None:
    """Its food and its walls are those of the arena it was reset in."""
    arenas = copies(CORRIDOR, 2)
    world = PymunkWorld(arenas, (1, 2), NONE, timing=TIMING)
    starts = CORRIDOR.start, arenas[1].start
    world.reset(np.random.default_rng(0), Layout(starts, (Point(370, 115), Point(370, 415))))
    with pytest.raises(ValueError, match=r"robot.*\(200, 415\)"):
        world.place(0, Pose(200, 415, 0))
    assert world.poses() == starts
