"""Several robots in one arena, on both backends: they block each other, and infra-reds and camera see each other."""

import math
from typing import Any

import numpy as np
import pytest

from khepera_forage.noise import Noise
from khepera_forage.robots.khepera import FOOD_RADIUS, RADIUS, Motors
from khepera_forage.sim.arena import Point, Pose
from khepera_forage.sim.world import Layout
from tests.sim.worlds import KINDS, run
from tests.version_0_1 import RECTANGLE, TIMING

STARTS = (Pose(150, 300, 0.0), Pose(450, 300, math.pi), Pose(300, 500, -math.pi / 2))
FOOD = Point(300, 120)


@pytest.fixture(params=KINDS)
def world(request: pytest.FixtureRequest) -> Any:
    """Three robots around the middle, each heading for it, and food aside."""
    made = request.param([RECTANGLE], (1, 2, 2), Noise.none(), timing=TIMING)
    made.reset(np.random.default_rng(0), Layout(STARTS, (FOOD,)))
    return made


def _drive(world: Any, rounds: int, arm: int = 215, speed: int = 10) -> None:
    for robot in world.robots:
        robot.drive(Motors(speed, speed, arm, 200))
    for _ in range(rounds):
        world.advance()


@pytest.mark.parametrize("arm", [215, 255])
def test_robots_see_and_block_each_other(world: Any, arm: int) -> None:
    starts = world.poses()
    assert max(world.robots[0].sense().proximity) == 0
    regions = world.camera.look().regions
    assert sorted(region.holes for region in regions) == [0, 1, 2, 2]
    shown = {(round(region.x * 5), round(region.y * 5)) for region in regions if region.holes}
    assert shown == {(round(pose.x), round(pose.y)) for pose in starts}
    _drive(world, 80, arm)
    poses = world.poses()
    if arm == 215:  # otherwise it hides what is ahead
        near = [max(robot.sense().proximity) > 100 for robot in world.robots]
        assert sum(near) >= 2, "but for one that has turned away"
    for i, pose in enumerate(poses):
        assert math.dist(pose[:2], starts[i][:2]) > 20, "it has driven"
        assert RECTANGLE.clearance(pose) > RADIUS - 1.5
        for other in poses[:i]:
            assert math.dist(pose[:2], other[:2]) > 2 * RADIUS - 1.5
    before = poses[2]
    world.robots[2].drive(Motors(0, 0, arm, 200))
    for robot in world.robots[:2]:
        robot.drive(Motors(-10, -10, arm, 200))
    for _ in range(8):
        world.advance()
    after = world.poses()
    assert math.dist(after[0][:2], after[1][:2]) > math.dist(poses[0][:2], poses[1][:2]) + 40, "they part again"
    assert math.dist(after[2][:2], before[:2]) < 30


def test_robots_push_food_that_other_robots_stop(world: Any) -> None:
    """Robot 0 pushes the food against robot 1."""
    world.place(0, Pose(200, 120, 0.0))
    world.place(1, Pose(420, 120, math.pi / 2))
    world.place(2, Pose(100, 500, math.pi / 2))
    run(world, 60, 8, 8, arm=255, jaw=0)
    food, poses = world.food_places()[0], world.poses()
    assert food.x > FOOD.x + 10
    for pose in poses:
        assert math.dist(food[:2], pose[:2]) > RADIUS + FOOD_RADIUS - 1.5
    assert math.dist(poses[0][:2], poses[1][:2]) > 2 * RADIUS - 1.5


@pytest.mark.parametrize("carrier", [0, 1])
@pytest.mark.parametrize("arm", [215, 255])
def test_robots_see_food_in_another_gripper_on_the_floor_alone(world: Any, carrier: int, arm: int) -> None:
    """Where the food is now, whichever robot comes first."""
    watcher = 1 - carrier
    world.place(2, Pose(100, 500, math.pi / 2))
    world.place(watcher, Pose(310, 185, -math.pi / 2))
    world.place(carrier, Pose(FOOD.x - 60, FOOD.y, 0.0))
    for motors in (Motors(0, 0, 255, 200), Motors(0, 0, 255, 0), Motors(0, 0, arm, 0)):
        for _ in range(20):
            world.robots[carrier].drive(motors)
            world.advance()
    world.robots[carrier].drive(Motors(-6, -6, arm, 0))
    world.advance()
    (food,) = world.food_places()
    assert food.lifted == (arm == 215)
    assert food.x < FOOD.x - 3, "it is carried along"
    seen = world.robots[watcher].sense().proximity
    world.place(watcher, world.poses()[watcher])  # senses again
    assert world.robots[watcher].sense().proximity == seen
    assert (max(seen) > 50) == (arm == 255)
