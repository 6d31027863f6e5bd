"""RobotParameters: the effect of each deviation, and none by default."""

import math
from typing import Any

import pytest

from khepera_forage.robots.khepera import ARM_DOWN, BARRIER, FINGER_TIP, JAW_CLOSED, JAW_ROOT, PRESENT
from khepera_forage.robots.parameters import RobotParameters
from khepera_forage.sim.arena import Pose, copies
from khepera_forage.sim.pymunk.world import PymunkWorld
from tests.sim.worlds import make_world, run
from tests.version_0_1 import CORRIDOR, TIMING

HERE = Pose(1000, 1000, 0)


def stand(food: tuple[float, float] = (1040, 1030), **parameters: float) -> Any:
    return make_world(HERE, food, robot_parameters=(RobotParameters(**parameters),))


def test_slow_left_wheel_turns_the_robot_left() -> None:
    headings = []
    for error in (0.0, -0.2):
        world = stand((100, 100), left_wheel_error=error)
        run(world, 10, 10, 10)
        headings.append(world.poses()[0].heading)
    assert headings == [0.0, pytest.approx(0.2 * 80 / 53, rel=1e-6)]


def test_readings_are_scaled() -> None:
    full, weak, blind = (stand(infra_red_gain=gain).robots[0].sense().proximity for gain in (1.0, 0.3, 0.0))
    assert max(full) > 300
    assert weak == pytest.approx([0.3 * reading for reading in full], abs=1)
    assert set(blind) == {0}
    world = stand((100, 100), arm_reading_scale=0.6)
    assert world.robots[0].sense().arm == 231
    assert run(world, 12, arm=ARM_DOWN).arm == ARM_DOWN


@pytest.mark.parametrize(("finger_length", "grips"), [(FINGER_TIP - JAW_ROOT, True), (25.0, False)])
def test_short_fingers_miss_food_at_the_edge_of_the_optical_barrier(finger_length: float, grips: bool) -> None:
    world = stand((HERE.x + BARRIER + 16, HERE.y), finger_length=finger_length)
    assert run(world, 12, arm=ARM_DOWN).object_presence == PRESENT
    run(world, 10, arm=ARM_DOWN, jaw=JAW_CLOSED)
    run(world, 12, jaw=JAW_CLOSED)
    assert world.food_places()[0].lifted is grips


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"left_wheel_error": -1.0}, "left_wheel_error is -1.0; allowed: a finite number above -1"),
        ({"infra_red_gain": -0.1}, "infra_red_gain is -0.1; allowed: a finite number >= 0"),
        ({"infra_red_gain": math.nan}, "infra_red_gain is nan"),
        ({"arm_reading_scale": 0.0}, "arm_reading_scale is 0.0; allowed: above 0, at most 1"),
        ({"finger_length": 50.0}, "finger_length is 50.0; allowed: 20 to 37 mm"),
    ],
)
def test_values_out_of_range_are_rejected(change: dict[str, float], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        RobotParameters(**change)


def test_wrong_number_of_parameters_is_rejected() -> None:
    with pytest.raises(ValueError, match="1 robot_parameters given; allowed: 2, one per robot"):
        PymunkWorld(copies(CORRIDOR, 2), (1, 2), robot_parameters=(RobotParameters(),), timing=TIMING)
