"""Food on the floor: pushed by contact, slowed by friction, and sensed by a robot."""

import pytest

from khepera_forage.noise import Noise
from khepera_forage.robots.khepera import ARM_DOWN, BARRIER, FOOD_RADIUS, RADIUS
from khepera_forage.sim.arena import Arena, Point, Pose
from khepera_forage.sim.arenas.named import box
from tests.sim.worlds import apart, holding, make_world, run

CENTRE = Pose(1000, 1000, 0)

# ---------------------------------------------------------------- pushing


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


# ---------------------------------------------------------------- the optical barrier


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


# ---------------------------------------------------------------- infra-reds


@pytest.mark.parametrize("noise", [Noise.none(), Noise.laboratory()])
def test_lowered_arm_hides_the_front_infra_reds_but_not_the_back(noise: Noise) -> None:
    tight = Arena("tight", box(0, 0, 400, 120), Point(300, 60), 50, Pose(200, 60, 0), (Point(360, 60),))
    world = make_world(Pose(45, 60, 0), (360, 60), arena=tight, noise=noise)
    up = run(world, 1).proximity
    down = run(world, 12, arm=ARM_DOWN).proximity
    assert all(1015 <= reading <= 1022 for reading in down[:6])
    assert max(up[1:5]) < 500
    assert min(up[6:]) > 300
    assert all(0.75 < b / a < 1.35 for a, b in zip(up[6:], down[6:], strict=True))


def test_infra_reds_see_food_ahead_but_not_lifted_food() -> None:
    world = make_world(CENTRE, (1070, 1000))
    left, right = world.robots[0].sense().proximity[2:4]
    assert left == right > 100
    assert holding().robots[0].sense().proximity[2:4] == (0, 0)
