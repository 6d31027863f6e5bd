"""Robots whose bodies differ: what each peculiarity does, and that none changes nothing."""

import math
from typing import Any

import numpy as np
import pytest

from khepera_forage.robots.khepera import (
    ARM_DOWN,
    ARM_RAISED,
    BARRIER,
    FINGER_TIP,
    JAW_CLOSED,
    JAW_OPEN,
    JAW_ROOT,
    PRESENT,
    Motors,
    Senses,
)
from khepera_forage.robots.parameters import Body
from khepera_forage.sim.arena import CORRIDOR, Point, Pose, copies
from khepera_forage.sim.pymunk.world import PymunkWorld
from khepera_forage.sim.world import Layout
from tests.sim.stage import FIELD, NONE

HERE = Pose(1000, 1000, 0)


def stand(body: Body, start: Pose = HERE, food: Point = Point(100, 100), arena: Any = FIELD) -> PymunkWorld:  # noqa: B008
    world = PymunkWorld([arena], (2,), NONE, bodies=(body,))
    world.reset(np.random.default_rng(0), Layout((start,), (food,)))
    return world


def run(world: PymunkWorld, motors: Motors, rounds: int) -> Senses:
    for _ in range(rounds):
        world.robots[0].drive(motors)
        world.advance()
    return world.robots[0].sense()


def test_a_lazy_wheel_bends_the_way_to_its_side() -> None:
    straight, lazy = stand(Body()), stand(Body(left_wheel=-0.2))
    for world in (straight, lazy):
        run(world, Motors(10, 10, ARM_RAISED, JAW_OPEN), 10)
    assert straight.poses()[0].heading == 0.0
    assert lazy.poses()[0].heading == pytest.approx(0.2 * 80 / 53, rel=1e-6)
    travel = math.dist(lazy.poses()[0][:2], HERE[:2])
    assert travel < math.dist(straight.poses()[0][:2], HERE[:2])


def test_weak_infra_reds_read_a_share() -> None:
    near_wall = Pose(40, 115, math.pi / 2)
    full, weak, blind = (
        stand(Body(infra_reds=gain), near_wall, Point(400, 115), CORRIDOR).robots[0].sense().proximity
        for gain in (1.0, 0.3, 0.0)
    )
    assert max(full) > 300
    for clear, faint in zip(full, weak, strict=True):
        assert abs(faint - 0.3 * clear) <= 1
    assert set(blind) == {0}


def test_an_arm_reports_a_share_of_its_travel_from_the_floor() -> None:
    world = stand(Body(arm_reading=0.6))
    assert world.robots[0].sense().arm == 231
    assert run(world, Motors(0, 0, ARM_DOWN, JAW_OPEN), 12).arm == ARM_DOWN


@pytest.mark.parametrize(("fingers", "grips"), [(FINGER_TIP - JAW_ROOT, True), (25.0, False)])
def test_short_fingers_do_not_close_on_food_that_only_just_crosses_the_barrier(
    fingers: float, grips: bool
) -> None:
    world = stand(Body(fingers=fingers), food=Point(HERE.x + BARRIER + 16, HERE.y))
    lowered = run(world, Motors(0, 0, ARM_DOWN, JAW_OPEN), 12)
    assert lowered.object_presence == PRESENT
    run(world, Motors(0, 0, ARM_DOWN, JAW_CLOSED), 10)
    assert (world.robots[0].gripper.held is not None) is grips


def test_a_world_without_bodies_is_one_of_equal_robots() -> None:
    layout = Layout(
        tuple(arena.start for arena in copies(CORRIDOR, 2)), tuple(a.foods[0] for a in copies(CORRIDOR, 2))
    )
    histories = []
    for bodies in (None, (Body(), Body())):
        world = PymunkWorld(copies(CORRIDOR, 2), (1, 2), bodies=bodies)
        world.reset(np.random.default_rng(3), layout)
        history = []
        for turn in range(40):
            for robot in world.robots:
                robot.drive(Motors(12, 12 - turn % 5, ARM_DOWN if turn > 20 else ARM_RAISED, JAW_OPEN))
            world.advance()
            history.append((world.poses(), [robot.sense() for robot in world.robots]))
        histories.append(history)
    assert histories[0] == histories[1]


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"left_wheel": -1.0}, "left_wheel is -1.0; allowed: a finite number above -1"),
        ({"infra_reds": -0.1}, "infra_reds is -0.1; allowed: a finite number >= 0"),
        ({"infra_reds": math.nan}, "infra_reds is nan"),
        ({"arm_reading": 0.0}, "arm_reading is 0.0; allowed: above 0, at most 1"),
        ({"fingers": 50.0}, "fingers is 50.0; allowed: 20 to 37 mm"),
    ],
)
def test_bodies_are_checked(change: dict[str, float], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        Body(**change)


def test_one_body_a_robot() -> None:
    with pytest.raises(ValueError, match="1 bodies given; allowed: 2, one a robot"):
        PymunkWorld(copies(CORRIDOR, 2), (1, 2), bodies=(Body(),))
