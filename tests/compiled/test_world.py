"""Compiled bodies and camera against those of `PymunkWorld`, and what must hold of any simulation."""

import math

import numpy as np
import pytest

import khepera_forage  # noqa: F401 (registers the environments)
from khepera_forage.noise import Noise
from khepera_forage.robots.khepera import (
    FINGER_THICKNESS,
    FINGER_TIP,
    FOOD_RADIUS,
    JAW_OPEN,
    Motors,
    half_gap,
)
from khepera_forage.sim.arena import Arena, Point, Pose
from khepera_forage.sim.compiled.world import CompiledWorld
from khepera_forage.sim.pymunk.world import PymunkWorld
from khepera_forage.sim.world import Layout
from tests.sim.worlds import FIELD
from tests.version_0_1 import CORRIDOR, TIMING


def compiled_world(arena: Arena, start: tuple[float, ...], *foods: tuple[float, ...]) -> CompiledWorld:
    """A world without noise, after a reset."""
    world = CompiledWorld([arena], (2,), Noise.none(), timing=TIMING)
    world.reset(np.random.default_rng(0), Layout((Pose(*start),), tuple(Point(*food) for food in foods)))
    return world


def test_both_backends_report_the_same_to_the_last_bit_while_nothing_touches_anything() -> None:
    """Under all noise, with the arm up and down and the jaw on its way; food is seen, hidden and lost."""
    noise, rng = Noise(loss_rate_food=0.02, loss_rate_two_holes=0.02), np.random.default_rng(0)
    start, foods = Pose(150, 150, 0.8), (Point(700, 700), Point(221.2, 78.8), Point(78.8, 221.2))
    worlds = [kind([FIELD], (2,), noise, timing=TIMING) for kind in (PymunkWorld, CompiledWorld)]
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


@pytest.mark.parametrize(
    ("off", "stays"), [(-0.7, True), (0.0, True), (0.7, True), (0.9, False), (-0.9, False)]
)
def test_food_before_a_fingertip_stays_within_the_cone_of_friction(off: float, stays: bool) -> None:
    """At 0.04 a tip carries food along that is up to 0.78 mm off its middle; further off, it slips aside."""
    aside, ahead = half_gap(JAW_OPEN) + FINGER_THICKNESS / 2 + off, FINGER_TIP + FOOD_RADIUS
    world = compiled_world(FIELD, FIELD.start, (FIELD.start.x + ahead + 3.0, FIELD.start.y + aside))
    for motors in [Motors(0, 0, 255, 200)] * 11 + [Motors(8, 8, 255, 200)] * 30:
        world.robots[0].drive(motors)
        world.advance()
    food, robot = world.food_places()[0], world.poses()[0]
    assert (abs(food.x - robot.x - ahead) < 0.1) == stays
    assert (abs(food.y - robot.y - aside) < 0.1) == stays
