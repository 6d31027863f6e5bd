"""Which worlds can be made, and which layouts their reset refuses."""

import math

import numpy as np
import pytest

from khepera_forage.sim.arena import Arena, Point, Pose, copies
from khepera_forage.sim.pymunk.world import PymunkWorld
from khepera_forage.sim.world import Layout
from tests.sim.worlds import ELL, NONE
from tests.version_0_1 import CORRIDOR, RECTANGLE, TIMING

START = CORRIDOR.start
FOOD = Point(370, 115)


def pair() -> PymunkWorld:
    return PymunkWorld(copies(CORRIDOR, 2), (1, 2), NONE, timing=TIMING)


def reset(world: PymunkWorld, starts: tuple[Pose, ...], foods: tuple[Point, ...] = (FOOD,)) -> None:
    world.reset(np.random.default_rng(0), Layout(starts, foods))


# ---------------------------------------------------------------- making a world


@pytest.mark.parametrize(
    ("arenas", "markers", "complaint"),
    [
        ([], (2,), "no arena"),
        ([CORRIDOR], (), r"markers \(\)"),
        ([CORRIDOR], (3,), r"markers \(3,\)"),
        ([CORRIDOR], (1, 0), r"markers \(1, 0\)"),
        ([CORRIDOR.shifted(-1, 0)], (2,), r"\(-1, 0\).*allowed"),
        ([CORRIDOR, CORRIDOR.shifted(3000, 0)], (2,), "3650.*allowed"),
    ],
)
def test_impossible_world_is_refused(arenas: list[Arena], markers: tuple[int, ...], complaint: str) -> None:
    with pytest.raises(ValueError, match=complaint):
        PymunkWorld(arenas, markers, NONE, timing=TIMING)


def test_advance_before_reset_is_refused() -> None:
    with pytest.raises(RuntimeError, match="reset"):
        PymunkWorld([CORRIDOR], (2,), timing=TIMING).advance()


# ---------------------------------------------------------------- refused layouts


@pytest.mark.parametrize(
    ("start", "complaint"),
    [
        (Pose(10, 115, 0), r"robot at \(10, 115\) mm is 10 mm from a wall"),
        (Pose(-50, 115, 0), "robot.*outside the walls"),
        (Pose(325, 265, 0), "robot.*outside the walls"),
        (Pose(math.nan, 115, 0), "robot.*nan"),
        (Pose(90, math.inf, 0), "robot.*inf"),
        (Pose(90, 115, math.nan), "robot.*nan"),
        (Pose(340, 115, 0), r"food at \(370, 115\) mm overlaps robot at \(340, 115\)"),
    ],
)
def test_reset_refuses_a_robot_off_the_free_floor(start: Pose, complaint: str) -> None:
    with pytest.raises(ValueError, match=complaint):
        reset(pair(), (start, START._replace(y=415)))


@pytest.mark.parametrize("start", [Pose(300, 202, math.pi / 2), Pose(300, 170, 1.2), Pose(600, 115, 0.0)])
def test_reset_refuses_a_gripper_in_a_wall(start: Pose) -> None:
    """The gripper would be stuck in the wall, or the solver would throw the robot out of it."""
    with pytest.raises(ValueError, match=rf"robot at \({start.x:g}, {start.y:g}\)"):
        reset(pair(), (start, START._replace(y=415)))


def test_reset_refuses_overlapping_robots() -> None:
    world = PymunkWorld([RECTANGLE], (1, 2), NONE, timing=TIMING)
    with pytest.raises(ValueError, match=r"robot at \(154, 300\) mm overlaps robot at \(100, 300\)"):
        reset(world, (Pose(100, 300, 0), Pose(154, 300, 0)), (Point(400, 300),))
    reset(world, (Pose(100, 300, 0), Pose(155, 300, 0)), (Point(400, 300),))


@pytest.mark.parametrize(
    ("food", "complaint"),
    [
        (Point(370, 5), "food.* 5 mm from a wall"),
        (Point(370, -40), "food.*outside"),
        (Point(math.nan, 0), "food.*nan"),
        (Point(390, 115), r"food at \(390, 115\) mm overlaps food at \(370, 115\)"),
        (Point(120, 115), r"food at \(120, 115\) mm overlaps robot"),
    ],
)
def test_reset_refuses_food_off_the_free_floor_or_overlapping(food: Point, complaint: str) -> None:
    with pytest.raises(ValueError, match=complaint):
        reset(pair(), (START, START._replace(y=415)), (FOOD, food))


def test_reset_refuses_places_in_an_obstacle() -> None:
    world = PymunkWorld([ELL], (2,), NONE, timing=TIMING)
    with pytest.raises(ValueError, match=r"ell: food.*inside a wall"):
        reset(world, (ELL.start,), (Point(180, 120),))
    with pytest.raises(ValueError, match=r"ell: robot.* 20 mm from a wall"):
        reset(world, (Pose(230, 120, 0),), (Point(450, 150),))


# ---------------------------------------------------------------- a user's arena


# ---------------------------------------------------------------- repeated resets


def test_amount_of_food_may_change_at_a_reset() -> None:
    world = pair()
    starts = START, START._replace(y=415)
    for count in (3, 0, 1):
        reset(world, starts, tuple(Point(250 + 60 * i, 60) for i in range(count)))
        world.advance()
        assert len(world.food_places()) == count
        assert sum(region.holes == 0 for region in world.camera.look().regions) == count
