"""Compiled bodies and camera against those of `PymunkWorld`, and what must hold of any simulation."""

import math
from typing import Any

import gymnasium as gym
import numpy as np
import pytest

import khepera_forage  # noqa: F401 (registers the environments)
from khepera_forage.noise import Noise
from khepera_forage.robots.khepera import (
    ARM_ON_FLOOR,
    FINGER_THICKNESS,
    FINGER_TIP,
    FOOD_RADIUS,
    JAW_OPEN,
    RADIUS,
    Motors,
    half_gap,
)
from khepera_forage.sim.arena import MOST_FOODS, Arena, Point, Pose
from khepera_forage.sim.compiled.world import CompiledWorld
from khepera_forage.sim.pymunk.world import PymunkWorld
from khepera_forage.sim.world import Layout
from tests.version_0_1 import CORRIDOR, RECTANGLE, TIMING

HALL = Arena(
    name="hall",
    walls=(Point(0, 0), Point(2300, 0), Point(2300, 2300), Point(0, 2300)),
    home=Point(1150, 1150),
    home_radius=100,
    start=Pose(1150, 1150, 0),
    foods=(Point(100, 100),),
)
PILLAR = Arena(
    name="pillar",
    walls=RECTANGLE.walls,
    home=RECTANGLE.home,
    home_radius=90,
    start=RECTANGLE.start,
    foods=RECTANGLE.foods,
    obstacles=((Point(300, 280), Point(340, 300), Point(300, 320)),),
)


def compiled_world(arena: Arena, start: tuple[float, ...], *foods: tuple[float, ...]) -> CompiledWorld:
    """A world without noise, after a reset."""
    world = CompiledWorld([arena], (2,), Noise.none(), timing=TIMING)
    world.reset(np.random.default_rng(0), Layout((Pose(*start),), tuple(Point(*food) for food in foods)))
    return world


def test_both_backends_report_the_same_to_the_last_bit_while_nothing_touches_anything() -> None:
    """Under all noise, with the arm up and down and the jaw on its way; food is seen, hidden and lost."""
    noise, rng = Noise(loss_rate_food=0.02, loss_rate_two_holes=0.02), np.random.default_rng(0)
    start, foods = Pose(150, 150, 0.8), (Point(700, 700), Point(221.2, 78.8), Point(78.8, 221.2))
    worlds = [kind([HALL], (2,), noise, timing=TIMING) for kind in (PymunkWorld, CompiledWorld)]
    for world in worlds:
        world.reset(np.random.default_rng(7), Layout((start,), foods))
    reported = []
    for step in range(600):
        if step % 8 == 0:
            turn, arm, jaw = int(rng.integers(-9, 10)), int(rng.choice((215, 255))), int(rng.choice((0, 200)))
        wheels = (-turn, turn) if step % 8 < 4 else (turn, -turn)
        now = []
        for world in worlds:
            world.robots[0].drive(Motors(*wheels, arm, jaw))
            world.advance()
            robot, scene = world.robots[0].sense(), world.camera.look()
            now.append((robot, scene, world.poses(), world.food_places()))
        assert now[0] == now[1]
        reported.append(now[0])
    assert len({pose for _, _, pose, _ in reported}) > 500
    assert max(max(robot.proximity[:6]) for robot, *_ in reported if robot.arm == 215) > 7, (
        "the infra-reds see food, beyond their noise of 6"
    )
    assert any(not region.found for _, scene, *_ in reported for region in scene.regions)


def test_picking_up_carrying_and_releasing_is_that_of_pymunk_within_3_mm() -> None:
    """The same commands in both, every round; arm, jaw and barrier read the same."""
    start, food = Pose(200, 115, 0.05), Point(330, 120)
    pymunk, compiled = (
        PymunkWorld([CORRIDOR], (2,), Noise.none(), timing=TIMING),
        compiled_world(CORRIDOR, start, food),
    )
    pymunk.reset(np.random.default_rng(0), Layout((start,), (food,)))
    script = (
        [Motors(0, 0, 255, 200)] * 11  # lower
        + [Motors(5, 5, 255, 200)] * 16  # push up to it
        + [Motors(0, 0, 255, 0)] * 8  # grip
        + [Motors(0, 0, 215, 0)] * 11  # raise
        + [Motors(8, 9, 215, 0)] * 15  # carry
        + [Motors(0, 0, 255, 0)] * 11  # lower
        + [Motors(0, 0, 255, 200)] * 7  # let go
        + [Motors(-6, -6, 255, 200)] * 10  # back off
    )
    held = []
    for motors in script:
        for world in (pymunk, compiled):
            world.robots[0].drive(motors)
            world.advance()
        assert math.dist(pymunk.poses()[0][:2], compiled.poses()[0][:2]) < 3.0
        assert abs(pymunk.poses()[0].heading - compiled.poses()[0].heading) < 0.03
        place, other = pymunk.food_places()[0], compiled.food_places()[0]
        assert math.dist(place[:2], other[:2]) < 3.0
        assert place.lifted == other.lifted
        senses, others = pymunk.robots[0].sense(), compiled.robots[0].sense()
        assert (senses.arm, senses.jaw, senses.object_presence) == (
            others.arm,
            others.jaw,
            others.object_presence,
        )
        held.append(compiled.held())
    assert 0 in held
    assert held[-1] == -1
    assert math.dist(compiled.food_places()[0][:2], food) > 60


def test_held_food_moves_along_when_an_operator_moves_the_robot() -> None:
    world = compiled_world(CORRIDOR, (200, 115, 0), (200 + FINGER_TIP - 15, 115))
    for motors in [Motors(0, 0, 255, 200)] * 12 + [Motors(0, 0, 255, 0)] * 8:
        world.robots[0].drive(motors)
        world.advance()
    assert world.held() == 0
    before = world.food_places()[0]
    world.place(0, Pose(300, 115, 0))
    after = world.food_places()[0]
    assert (after.x - before.x, after.y - before.y) == pytest.approx((100, 0))
    world.advance()
    assert world.food_places()[0][:2] == pytest.approx(after[:2])


@pytest.mark.parametrize(
    ("off", "stays"), [(-0.7, True), (0.0, True), (0.7, True), (0.9, False), (-0.9, False)]
)
def test_food_before_a_fingertip_stays_within_the_cone_of_friction(off: float, stays: bool) -> None:
    """At 0.04 a tip carries food along that is up to 0.78 mm off its middle; further off, it slips aside."""
    aside, ahead = half_gap(JAW_OPEN) + FINGER_THICKNESS / 2 + off, FINGER_TIP + FOOD_RADIUS
    world = compiled_world(HALL, HALL.start, (HALL.start.x + ahead + 3.0, HALL.start.y + aside))
    for motors in [Motors(0, 0, 255, 200)] * 11 + [Motors(8, 8, 255, 200)] * 30:
        world.robots[0].drive(motors)
        world.advance()
    food, robot = world.food_places()[0], world.poses()[0]
    assert (abs(food.x - robot.x - ahead) < 0.1) == stays
    assert (abs(food.y - robot.y - aside) < 0.1) == stays


def test_arm_is_not_lowered_onto_food() -> None:
    world = compiled_world(CORRIDOR, (200, 115, 0), (200 + FINGER_TIP, 115 + 28))
    world.robots[0].drive(Motors(0, 0, 255, 200))
    for _ in range(15):
        world.advance()
    assert world.robots[0].sense().arm == 234


@pytest.mark.parametrize("arena", [CORRIDOR, RECTANGLE, PILLAR], ids=lambda arena: arena.name)
def test_random_commands_put_nothing_into_a_wall_or_into_food(arena: Arena) -> None:
    rng, worlds, foods = np.random.default_rng(5), 256, 3
    env: Any = gym.make_vec(
        "khepera_forage/RectangleWheels-v1", worlds, arena=arena, foods=foods, limit=999, noise="none"
    )
    places = [(150, 60), (250, 170), (420, 60)]
    env.reset(seed=5, options={"start": (80, 115, 0), "foods": places})
    batch = env.unwrapped.batch.worlds
    for step in range(150):
        if step % 10 == 0:
            arms, jaws = rng.choice((1, -1), worlds), rng.choice((1, -1), worlds)
            wheels = rng.integers(-12, 19, (worlds, 2)) / 20
        env.step(np.column_stack((wheels, arms, jaws)))
        robots, where = batch.robots[:, 0], np.stack((batch.foods["x"], batch.foods["y"]), axis=2)
        for world in range(0, worlds, 16):
            robot = robots[world]
            x, y, raised = float(robot["x"]), float(robot["y"]), robot["arm"] < ARM_ON_FLOOR
            assert arena.clearance(Point(x, y)) > RADIUS - 1.0
            for k in range(foods):
                assert arena.clearance(Point(*where[world, k])) > FOOD_RADIUS - 1.5
                if k != robot["held"]:
                    assert math.dist((x, y), where[world, k]) > RADIUS + FOOD_RADIUS - 1.5
                for other in range(k):
                    lifted = raised and robot["held"] in (k, other)
                    assert lifted or math.dist(where[world, k], where[world, other]) > 2 * FOOD_RADIUS - 1.5
    moved = np.abs(where - np.array(places)).max(axis=(1, 2))
    assert (moved > 5).mean() > 0.5


def test_bad_arguments_are_quoted() -> None:
    with pytest.raises(ValueError, match=r"markers \(3,\)"):
        CompiledWorld([CORRIDOR], (3,), timing=TIMING)
    world = CompiledWorld([RECTANGLE], (2,), timing=TIMING)
    with pytest.raises(RuntimeError, match="before reset"):
        world.advance()
    foods = tuple(Point(60 + 40 * (k % 5), 60 + 40 * (k // 5)) for k in range(MOST_FOODS + 1))
    with pytest.raises(ValueError, match="17 food objects; allowed: at most 16"):
        world.reset(np.random.default_rng(0), Layout((Pose(500, 500, 0),), foods))
