"""Arm and jaw: how fast they move, and that an arm does not come down on food."""

import pytest

from khepera_forage.robots.khepera import ARM_DOWN, ARM_ON_FLOOR, ARM_RAISED, JAW_CLOSED, JAW_OPEN
from khepera_forage.sim.arena import Point, Pose
from tests.sim.worlds import apart, holding, make_world, run

CENTRE = Pose(1000, 1000, 0)
FAR = (100.0, 100.0)

# ---------------------------------------------------------------- speeds


def test_arm_travels_in_one_second() -> None:
    world = make_world(CENTRE, FAR)
    assert [run(world, 1, arm=ARM_DOWN).arm for _ in range(11)] == [*range(219, 256, 4), 255]
    assert [run(world, 1, arm=ARM_RAISED).arm for _ in range(11)] == [*range(251, 214, -4), 215]


def test_jaw_travels_in_six_tenths_of_a_second() -> None:
    world = make_world(CENTRE, FAR)
    closing = [run(world, 1, jaw=JAW_CLOSED).jaw for _ in range(7)]
    assert closing == pytest.approx([200 - 33.3 * i for i in range(1, 7)] + [0], abs=1)
    opening = [run(world, 1, jaw=JAW_OPEN).jaw for _ in range(7)]
    assert opening == pytest.approx([33.3 * i for i in range(1, 7)] + [200], abs=1)


# ---------------------------------------------------------------- the arm and what is below it


@pytest.mark.parametrize("below", [(57, 29), (57, -20), (70, 25), (45, 24)])
def test_arm_stops_above_food(below: tuple[float, float]) -> None:
    world = make_world(CENTRE, (1000 + below[0], 1000 + below[1]))
    food = world.food_places()[0]
    assert run(world, 20, arm=ARM_DOWN).arm == ARM_ON_FLOOR - 1
    assert apart(world.food_places()[0], food) < 0.01
    run(world, 12, -8, -8, arm=ARM_DOWN)
    assert run(world, 10, arm=ARM_DOWN).arm == ARM_DOWN
    assert apart(world.food_places()[0], food) < 0.01


@pytest.mark.parametrize("beside", [(0, 36), (10, -35), (-8, 36), (-15, 34), (-15, -34)])
def test_arm_with_food_stops_above_other_food(beside: tuple[float, float]) -> None:
    """The fingers are 4 mm thick, and the palm is wider than the food."""
    world = holding(CENTRE, (1500, 1500))
    world.place(0, Pose(1500 - 57 - beside[0], 1500 - beside[1], 0))
    run(world, 20, arm=ARM_DOWN, jaw=JAW_CLOSED)
    assert apart(world.food_places()[1], Point(1500, 1500)) < 0.01
