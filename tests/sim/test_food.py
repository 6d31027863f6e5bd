"""Food on the floor: pushed by contact, slowed by friction, and between the fingers."""

import pytest

from khepera_forage.robots.khepera import ARM_DOWN, BARRIER, FOOD_RADIUS, RADIUS
from khepera_forage.sim.arena import Pose
from tests.sim.worlds import apart, make_world, run

CENTRE = Pose(1000, 1000, 0)


@pytest.mark.parametrize("speed", [5, 10, 20])
def test_pushed_food_stays_ahead_and_stops_soon_after(speed: int) -> None:
    world = make_world(CENTRE, (1080, 1000))
    run(world, 20, speed, speed)
    food, robot = world.food_places()[0], world.poses()[0]
    assert robot.x > 1080 - RADIUS
    assert RADIUS + FOOD_RADIUS - 1 < apart(food, robot) < RADIUS + FOOD_RADIUS + 5
    run(world, 10)
    slid = world.food_places()[0].x - food.x
    # v^2 / 2a at 0.3 g: 0.3, 1.1 and 4.3 mm, and what the last steps of the push add.
    assert 0 <= slid < (8 * speed) ** 2 / (2 * 0.3 * 9810) + 8 * speed * 0.03
    rest = world.food_places()[0]
    run(world, 20)
    assert apart(rest, world.food_places()[0]) < 1e-3


@pytest.mark.parametrize(
    ("ahead", "aside", "present"),
    [
        (BARRIER, 0, True),
        (BARRIER + FOOD_RADIUS - 0.5, 0, True),
        (BARRIER + FOOD_RADIUS + 0.5, 0, False),
        (64.0, 8, True),
        (64.0, -8, True),
        (90.0, 0, False),
        (60.0, 60, False),
    ],
)
def test_barrier_is_interrupted_by_food_between_the_fingers(ahead: float, aside: float, present: bool) -> None:
    # The palm just clears food at the barrier: half a millimetre further out than it would push.
    world = make_world(CENTRE, (1000 + max(ahead, 54.0), 1000 + aside))
    assert run(world, 1).object_presence == 0, "above it, a raised arm sees nothing"
    senses = run(world, 12, arm=ARM_DOWN)
    assert (senses.arm, senses.object_presence) == (255, 255 if present else 0)
    assert run(world, 12).object_presence == 0
