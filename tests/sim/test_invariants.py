"""Properties that hold in every state that random driving reaches."""

import math

import numpy as np
from hypothesis import Phase, given, settings
from hypothesis import strategies as st

from khepera_forage.counter_rng import key_of
from khepera_forage.envs.layouts import random_layout
from khepera_forage.noise import Noise
from khepera_forage.robots.khepera import FOOD_RADIUS, RADIUS, Motors
from khepera_forage.sim.arena import Arena, Point
from khepera_forage.sim.pymunk.world import PymunkWorld
from khepera_forage.task.decisions import DEFAULT_VALUES
from tests.arenas import BLOCKS, L_ROOM
from tests.sim.worlds import Kind, of_both_kinds
from tests.version_0_1 import CORRIDOR, RECTANGLE, TIMING

SPEEDS = st.integers(-20, 20) | st.sampled_from((-1e9, -20, 20, 1e9))
COMMANDS = st.tuples(SPEEDS, SPEEDS, st.sampled_from((215, 255)), st.sampled_from((0, 200)), st.integers(1, 15))
TOUCH = 1.0


@of_both_kinds
@settings(max_examples=25, phases=(Phase.explicit, Phase.generate))
@given(
    arena=st.sampled_from([CORRIDOR, RECTANGLE, L_ROOM, BLOCKS]),
    seed=st.integers(0, 10_000),
    commands=st.lists(COMMANDS, min_size=10, max_size=25),
)
def test_bodies_stay_inside_the_walls_apart_and_move_at_their_speed(
    kind: Kind, arena: Arena, seed: int, commands: list[tuple[float, float, int, int, int]]
) -> None:
    layout = random_layout(arena, 1 + seed % 3 if arena is RECTANGLE else 1 + seed % 2, key_of(seed), DEFAULT_VALUES)
    world = kind([arena], (2,), Noise.laboratory(), timing=TIMING)
    world.reset(np.random.default_rng(seed), layout)
    pose, places = layout.starts[0], list(layout.foods)
    for left, right, arm, jaw, rounds in commands:
        world.robots[0].drive(Motors(left, right, arm, jaw))
        for _ in range(rounds):
            world.advance()
            x, y, heading = world.poses()[0]
            assert math.isfinite(x + y + heading)
            foods = world.food_places()
            assert len(foods) == len(layout.foods), "food is conserved"
            assert arena.clearance(Point(x, y)) >= RADIUS - TOUCH
            for food in foods:
                assert arena.clearance(Point(food.x, food.y)) >= FOOD_RADIUS - TOUCH
            now = [Point(food.x, food.y) for food in foods]
            # Wheels at most 160 mm/s, with five standard deviations of slip and bias; compiled corners push as well.
            assert math.dist((x, y), pose[:2]) <= (21.0 if kind is PymunkWorld else 25.0)
            assert abs(heading - pose.heading) <= 0.8
            # A finger's tip sweeps at 7 rad/s and 80 mm, and the jaw adds 4.5 mm.
            assert all(math.dist(*moved) <= 65.0 for moved in zip(places, now, strict=True))
            pose, places = world.poses()[0], now
            on_floor = [food for food in foods if not food.lifted]
            for i, food in enumerate(on_floor):
                assert math.dist((food.x, food.y), (x, y)) > RADIUS + FOOD_RADIUS - 5.0
                for other in on_floor[:i]:
                    assert math.dist(food[:2], other[:2]) > 2 * FOOD_RADIUS - 5.0
