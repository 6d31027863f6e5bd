"""`PymunkWorld`: which worlds and layouts are refused, operators who place robots, copies, and sources of noise.

What all worlds promise: `tests/contracts`.
"""

import math
from dataclasses import replace

import numpy as np
import pytest

from khepera_forage.noise import Noise
from khepera_forage.robots.khepera import JAW_CLOSED
from khepera_forage.sim.arena import Arena, Point, Pose, copies
from khepera_forage.sim.pymunk.world import PymunkWorld
from khepera_forage.sim.world import Layout
from tests.arenas import BLOCKS
from tests.sim.worlds import FIELD, NONE, Kind, holding, make_world, of_both_kinds, run
from tests.version_0_1 import CORRIDOR, RECTANGLE, TIMING


def reset(world: PymunkWorld, starts: tuple[Pose, ...], foods: tuple[Point, ...] = (Point(370, 115),)) -> None:
    world.reset(np.random.default_rng(0), Layout(starts, foods))


@of_both_kinds
@pytest.mark.parametrize(
    ("arenas", "markers", "complaint"),
    [
        ([], (2,), "no arena"),
        ([CORRIDOR], (), r"markers \(\)"),
        ([CORRIDOR], (1, 0), r"markers \(1, 0\)"),
        ([CORRIDOR.shifted(-1, 0)], (2,), r"\(-1, 0\).*allowed"),
        ([CORRIDOR, CORRIDOR.shifted(3000, 0)], (2,), "3650.*allowed"),
    ],
)
def test_impossible_world_is_refused(arenas: list[Arena], markers: tuple[int, ...], complaint: str, kind: Kind) -> None:
    with pytest.raises(ValueError, match=complaint):
        kind(arenas, markers, NONE, timing=TIMING)


@of_both_kinds
def test_advance_before_reset_is_refused(kind: Kind) -> None:
    with pytest.raises(RuntimeError, match="reset"):
        kind([CORRIDOR], (2,), NONE, timing=TIMING).advance()


def test_reset_refuses_what_does_not_fit() -> None:
    """More cases: `tests/envs/test_bad_input.py`."""
    alone = PymunkWorld([BLOCKS], (2,), NONE, timing=TIMING)
    with pytest.raises(ValueError, match=r"robot at \(440, 400\) mm has its gripper in a wall"):
        reset(alone, (Pose(440, 400, 0.0),))
    with pytest.raises(ValueError, match=r"blocks: robot.* 20 mm from a wall"):
        reset(alone, (Pose(480, 400, 0),))
    with pytest.raises(ValueError, match=r"blocks: food.*inside a wall"):
        reset(alone, (BLOCKS.start,), (Point(550, 400),))
    both = PymunkWorld([RECTANGLE], (1, 2), NONE, timing=TIMING)
    with pytest.raises(ValueError, match=r"robot at \(154, 300\) mm overlaps robot at"):
        reset(both, (Pose(100, 300, 0), Pose(154, 300, 0)))
    reset(both, (Pose(100, 300, 0), Pose(155, 300, 0)))


def test_amount_of_food_may_change_at_a_reset() -> None:
    world = make_world(FIELD.start)
    for count in (3, 0, 1):
        reset(world, (FIELD.start,), tuple(Point(250 + 60 * i, 60) for i in range(count)))
        world.advance()
        assert len(world.food_places()) == count
        assert sum(region.holes == 0 for region in world.camera.look().regions) == count


@of_both_kinds
def test_placed_robot_keeps_the_food_it_holds(kind: Kind) -> None:
    world = holding(kind=kind)
    world.place(0, Pose(500, 600, math.pi / 2))
    x, y, _ = world.poses()[0]
    run(world, 3, jaw=JAW_CLOSED)
    assert (x, y) == (500, 600)
    assert world.food_places()[0][:2] == pytest.approx((500, 657), abs=2)
    assert world.food_places()[0].lifted


@of_both_kinds
def test_placed_robot_starts_at_rest(kind: Kind) -> None:
    """Near a wall, wheels still turn as in the round before for a part of a round."""
    world = make_world(FIELD.start, kind=kind)
    run(world, 5, 20, 20)
    world.place(0, Pose(1910, 1000, 0))
    run(world, 1, 1, 1)
    assert world.poses()[0].x == pytest.approx(1910.7, abs=0.2)


def test_place_refuses_a_taken_pose_and_another_arena() -> None:
    """Food and walls are those of the arena that the robot was reset in."""
    world = make_world(Pose(1000, 1000, 0), (1500, 1500))
    for pose in (Pose(1500, 1470, 0), Pose(500, 500, math.nan)):
        with pytest.raises(ValueError, match="robot at"):
            world.place(0, pose)
    world = PymunkWorld(copies(CORRIDOR, 2), (1, 2), NONE, timing=TIMING)
    starts = CORRIDOR.start, CORRIDOR.start._replace(y=415)
    reset(world, starts)
    with pytest.raises(ValueError, match=r"robot.*\(200, 415\)"):
        world.place(0, Pose(200, 415, 0))
    assert world.poses() == starts


def test_sources_of_noise_are_independent_of_one_another_and_of_the_amount_of_food() -> None:
    """Camera and sensors of a standing robot report the same whether wheels slip or not."""
    seen = []
    for slip in (0.0, 0.05):
        noise = replace(Noise.laboratory(), wheel_slip=slip, wheel_bias=slip)
        world = PymunkWorld([RECTANGLE], (2,), noise, timing=TIMING)
        world.reset(np.random.default_rng(8), Layout((RECTANGLE.start,), RECTANGLE.foods))
        for _ in range(60):
            world.advance()
        seen.append((world.robots[0].sense(), world.camera.look()))
    assert seen[0] == seen[1]
    ends = []
    for foods in ((), (Point(600, 60),), (Point(600, 60), Point(600, 540))):
        world = PymunkWorld([RECTANGLE], (2,), replace(NONE, wheel_bias=0.05), timing=TIMING)
        reset(world, (Pose(90, 300, 0),), foods)
        run(world, 20, 10, 10)
        ends.append(world.poses()[0])
    assert ends[0] == ends[1] == ends[2]
    assert abs(ends[0].heading) > 1e-4
