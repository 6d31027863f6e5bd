"""Food that is pushed, sensed and gripped; what is below the arm; and fingers that meet a wall."""

import math

import pytest

from khepera_forage.robots.khepera import (
    ARM_DOWN,
    ARM_ON_FLOOR,
    ARM_RAISED,
    BARRIER,
    FINGER_TIP,
    FOOD_RADIUS,
    JAW_CLOSED,
    JAW_ON_FOOD,
    JAW_OPEN,
    RADIUS,
)
from khepera_forage.sim.arena import Point, Pose
from tests.sim.worlds import Kind, apart, holding, make_world, of_both_kinds, run
from tests.version_0_1 import CORRIDOR

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


@of_both_kinds
@pytest.mark.parametrize("below", [(57, 29), (57, -20), (70, 25), (45, 24)])
def test_arm_stops_above_food(below: tuple[float, float], kind: Kind) -> None:
    world = make_world(CENTRE, (1000 + below[0], 1000 + below[1]), kind=kind)
    food = world.food_places()[0]
    assert run(world, 20, arm=ARM_DOWN).arm == ARM_ON_FLOOR - 1
    assert apart(world.food_places()[0], food) < 0.01
    run(world, 12, -8, -8, arm=ARM_DOWN)
    assert run(world, 10, arm=ARM_DOWN).arm == ARM_DOWN
    assert apart(world.food_places()[0], food) < 0.01


@of_both_kinds
@pytest.mark.parametrize("beside", [(0, 36), (10, -35), (-8, 36), (-15, 34), (-15, -34)])
def test_arm_with_food_stops_above_other_food(beside: tuple[float, float], kind: Kind) -> None:
    """The fingers are 4 mm thick, and the palm is wider than the food."""
    world = holding(CENTRE, (1500, 1500), kind=kind)
    world.place(0, Pose(1500 - 57 - beside[0], 1500 - beside[1], 0))
    run(world, 20, arm=ARM_DOWN, jaw=JAW_CLOSED)
    assert apart(world.food_places()[1], Point(1500, 1500)) < 0.01


@pytest.mark.parametrize("aside", [-9.0, -3.0, 2.0, 9.0])
def test_closing_fingers_centre_food_at_their_own_speed(aside: float) -> None:
    world = make_world(CENTRE, (1057, 1000 + aside))
    run(world, 12, arm=ARM_DOWN)
    before = world.food_places()[0]
    for _ in range(20):
        run(world, 1, arm=ARM_DOWN, jaw=JAW_CLOSED)
        after = world.food_places()[0]
        assert apart(before, after) < 8  # 4.5 mm a round, and what it slides on
        before = after
    run(world, 12, arm=ARM_RAISED, jaw=JAW_CLOSED)
    assert world.food_places()[0].lifted
    food, (x, y, heading) = world.food_places()[0], world.poses()[0]
    assert (food.y - y) * math.cos(heading) - (food.x - x) * math.sin(heading) == pytest.approx(0, abs=1)
    assert abs(heading) < 0.01  # the wheels hold better than the food


@of_both_kinds
def test_raised_arm_carries_food(kind: Kind) -> None:
    world = holding(kind=kind)
    for left, right, rounds in [(10, 10, 10), (-5, 5, 12), (12, 8, 15), (-10, -10, 8)]:
        run(world, rounds, left, right, jaw=JAW_CLOSED)
        x, y, heading = world.poses()[0]
        food = world.food_places()[0]
        assert food.lifted
        assert food[:2] == pytest.approx((x + 57 * math.cos(heading), y + 57 * math.sin(heading)), abs=2)
    assert world.robots[0].sense().object_presence == 255
    assert world.robots[0].sense().proximity[:6] == (0,) * 6  # lifted food hides no infra-red


@pytest.mark.parametrize("arm", [ARM_DOWN, ARM_RAISED])
def test_opening_jaw_leaves_food_in_place(arm: int) -> None:
    world = holding()
    run(world, 12, arm=arm, jaw=JAW_CLOSED)
    before = world.food_places()[0]
    run(world, 8, arm=arm, jaw=JAW_OPEN)
    after = world.food_places()[0]
    assert not after.lifted
    assert apart(before, after) < 0.5
    run(world, 10, -8, -8, arm=arm, jaw=JAW_OPEN)
    assert apart(after, world.food_places()[0]) < 0.5


@of_both_kinds
def test_lifted_food_passes_above_other_food_and_is_not_set_down_on_it(kind: Kind) -> None:
    world = holding(CENTRE, (1150, 1000), kind=kind)
    other = world.food_places()[1]
    while world.food_places()[0].x < other.x - 3:
        run(world, 1, 5, 5, jaw=JAW_CLOSED)
    assert apart(world.food_places()[1], other) < 0.01
    # Above other food, the jaw does not open, and the arm does not come down.
    assert run(world, 10, jaw=JAW_OPEN).jaw == round(JAW_ON_FOOD)
    assert world.food_places()[0].lifted
    assert run(world, 15, arm=ARM_DOWN, jaw=JAW_CLOSED).arm < ARM_ON_FLOOR
    assert apart(world.food_places()[1], other) < 0.01
    # Away from it, both do.
    run(world, 12, -5, -5, jaw=JAW_CLOSED)
    assert run(world, 15, arm=ARM_DOWN, jaw=JAW_CLOSED).arm == ARM_DOWN
    run(world, 8, arm=ARM_DOWN, jaw=JAW_OPEN)
    first, second = world.food_places()
    assert apart(first, second) >= 2 * FOOD_RADIUS - 0.1


@of_both_kinds
@pytest.mark.parametrize(("ahead", "heading"), [(57, 0.4), (69, 1.5)])  # between the fingers, and beyond their tips
def test_lifted_food_does_not_pass_through_a_wall(ahead: float, heading: float, kind: Kind) -> None:
    world = holding(Pose(300, 100, heading), arena=CORRIDOR, kind=kind, ahead=ahead)
    for _ in range(60):
        run(world, 1, 15, 15, jaw=JAW_CLOSED)
        food = world.food_places()[0]
        assert CORRIDOR.clearance(Point(food.x, food.y)) >= FOOD_RADIUS - 1
    run(world, 10, jaw=JAW_OPEN)
    food = world.food_places()[0]
    assert not food.lifted
    assert CORRIDOR.clearance(Point(food.x, food.y)) >= FOOD_RADIUS - 1


@pytest.mark.parametrize("degrees", range(10, 90, 20))
@pytest.mark.parametrize("wheels", [(-20, 10), (-5, 10), (0, 10), (10, 10)])
@pytest.mark.parametrize("closing", [3, 5])
def test_finger_pressed_against_a_wall_does_not_throw_the_robot(
    degrees: int, wheels: tuple[int, int], closing: int
) -> None:
    heading = math.radians(degrees)
    tip = (FINGER_TIP + 2) * math.sin(heading) + 31.5 * math.cos(heading)
    world = make_world(Pose(300, 230 - tip - 0.5, heading), (60, 60), arena=CORRIDOR)
    pose = world.poses()[0]
    for i in range(closing + 5):
        if i < closing:
            run(world, 1, *wheels, jaw=JAW_CLOSED)
        else:
            run(world, 1, jaw=JAW_OPEN)
        after = world.poses()[0]
        assert apart(pose, after) < 16.5
        assert abs(after.heading - pose.heading) < 0.65  # 2 x 160 mm/s over 53 mm, for 0.1 s, and little more
        pose = after
