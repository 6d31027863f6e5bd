"""The food tracker in a simulated world: while food is pushed, carried and set down."""

import math
from collections.abc import Callable

import numpy as np
import pytest

from khepera_forage.counter_rng import key_of
from khepera_forage.envs.arguments import checked_arena, timing_of
from khepera_forage.envs.layouts import arena_map_of, tracker_of
from khepera_forage.envs.recalls import Forager
from khepera_forage.noise import Noise
from khepera_forage.sim.arena import Arena, Point
from khepera_forage.sim.pymunk.world import PymunkWorld
from khepera_forage.sim.world import Layout
from khepera_forage.task.decisions import Decisions
from khepera_forage.task.food_tracking import is_collected, is_finished
from khepera_forage.task.placement import draw_food_types
from khepera_forage.task.states import Behaviour, FoodType
from khepera_forage.vision.scene import MM_PER_PIXEL
from tests.task.food_trackers import delivered, known_types, labels_of_no_candidates, linked_food
from tests.version_0_1 import CORRIDOR, V0_1

ODDS = {
    FoodType.PICKABLE: (1.0, 0.0),
    FoodType.PUSHABLE: (0.0, 1.0),
    FoodType.POISONOUS: (0.0, 0.0),
}
"""Odds of PICKABLE and PUSHABLE food."""
B = Behaviour
Check = Callable[["Forage"], None]


class Forage:
    """One robot, its world and its food tracker, round by round."""

    def __init__(
        self,
        arena: Arena | str,
        odds: tuple[float, float],
        noise: Noise | None = None,
        seed: int = 0,
        foods: tuple[Point, ...] = (),
        decisions: Decisions = V0_1,
    ) -> None:
        arena, marker = checked_arena(arena, decisions), decisions.recall_marker
        self.arena = arena
        foods = foods or arena.foods
        self.world = PymunkWorld([arena], (marker,), noise or Noise.none(), timing=timing_of(decisions))
        self.world.reset(np.random.default_rng(seed), Layout((arena.start,), foods))
        self.tracker = tracker_of(foods, arena_map_of(arena))
        draw_food_types(self.tracker.foods, key_of(seed), (*odds, 1 - sum(odds)))
        self.robot = Forager(
            self.world.robots[0], arena_map_of(arena), marker, self.tracker, decisions.values()
        )
        self.robot.perceive(self.world.camera.look())

    def step(self, behaviour: int | None = None) -> None:
        robot = self.robot
        robot.drive(robot.motors_for(robot.correct_behaviour if behaviour is None else behaviour))
        self.world.advance()
        robot.perceive(self.world.camera.look())

    def until(self, over: Callable[["Forage"], bool], limit: int = 700, check: Check | None = None) -> None:
        for _ in range(limit):
            if over(self):
                return
            self.step()
            if check is not None:
                check(self)
        raise AssertionError(f"not over after {limit} rounds, in state {self.robot.state!r}")

    @property
    def held(self) -> int | None:
        """The food object that is really in the gripper."""
        if not self.robot.senses.object_presence:
            return None
        x, y, heading = self.world.poses()[0]
        gripper = x + 55 * math.cos(heading), y + 55 * math.sin(heading)
        places = self.world.food_places()
        return min(
            range(len(places)), key=lambda k: (not places[k].lifted, math.dist(places[k][:2], gripper))
        )


def links_are_right(forage: Forage) -> None:
    """Every region in view is linked to the food object that really lies there; so is food in the gripper."""
    tracker = forage.tracker
    for region in forage.world.camera.look().regions:
        k = None if region.holes or not region.found else linked_food(tracker, region.label)
        if k is not None:
            place = forage.world.food_places()[k]
            assert math.dist(place[:2], (region.x * MM_PER_PIXEL, region.y * MM_PER_PIXEL)) < 10
    if forage.held is not None:
        assert tracker.type_in_gripper == tracker.foods[forage.held].known
        assert forage.robot.raw.food_type == tracker.foods[forage.held].known
    else:
        assert forage.robot.raw.food_type == FoodType.UNKNOWN


def deliveries_are_right(forage: Forage) -> None:
    """What counts as delivered lies at home, within a pixel, and is not what the gripper holds."""
    arena = forage.arena
    for k, food in enumerate(forage.world.food_places()):
        if forage.tracker.foods[k].delivered:
            assert forage.held != k
            assert not food.lifted
            assert math.dist(food[:2], arena.home) <= arena.home_radius + MM_PER_PIXEL


# ---------------------------------------------------------------- types


@pytest.mark.parametrize("decisions", [V0_1, Decisions()], ids=["v0.1", "default"])
@pytest.mark.parametrize("seed", range(12))
def test_two_food_objects_keep_their_types_under_laboratory_noise(seed: int, decisions: Decisions) -> None:
    forage = Forage("rectangle", (0.4, 0.4), Noise.laboratory(), seed, decisions=decisions)

    def check(forage: Forage) -> None:
        links_are_right(forage)
        deliveries_are_right(forage)

    forage.until(lambda f: is_finished(f.tracker), limit=1200, check=check)
    known = known_types(forage.tracker)
    assert FoodType.UNKNOWN not in known
    assert [is_collected(food) for food in forage.tracker.foods] == [t != FoodType.POISONOUS for t in known]


# ---------------------------------------------------------------- delivery


def test_food_is_delivered_once_it_is_set_down_at_home_and_the_robot_is_clear() -> None:
    forage = Forage(CORRIDOR, ODDS[FoodType.PICKABLE])
    forage.until(lambda f: f.world.food_places()[0].lifted)
    # Into the home, and further in it, without releasing the food.
    for behaviour, rounds in ((B.GO_HOME, 60), (B.WAIT, 10)):
        for _ in range(rounds):
            forage.step(behaviour)
            assert not forage.tracker.foods[0].delivered
            deliveries_are_right(forage)
    food = forage.world.food_places()[0]
    assert math.dist(food[:2], CORRIDOR.home) < CORRIDOR.home_radius
    forage.until(lambda f: not f.world.food_places()[0].lifted, limit=60)
    assert not forage.tracker.foods[0].delivered, "still in the gripper"
    forage.until(lambda f: f.tracker.foods[0].delivered, limit=60, check=deliveries_are_right)
    assert forage.robot.senses.object_presence == 0
    label = next(r.label for r in forage.world.camera.look().regions if r.holes == 0)
    assert label in labels_of_no_candidates(forage.tracker)
    assert not forage.robot.raw.food_seen, "delivered food is no candidate"
    assert forage.robot.vector.robot_food_distance == arena_map_of(CORRIDOR).diagonal


# ---------------------------------------------------------------- poison


def test_poison_brought_home_is_counted_separately() -> None:
    forage = Forage(CORRIDOR, ODDS[FoodType.POISONOUS])
    forage.until(lambda f: FoodType.POISONOUS in known_types(f.tracker))
    for _ in range(25):
        forage.step(B.PICK_UP_FOOD)
    assert forage.world.food_places()[0].lifted
    for _ in range(60):
        forage.step(B.GO_HOME)
    for _ in range(60):
        forage.step(B.RELEASE_FOOD)
    tracker = forage.tracker
    assert delivered(tracker) == [True]
    assert (tracker.poison_home, tracker.delivered, tracker.deliverable) == (1, 0, 0)
    assert not is_collected(tracker.foods[0])
    assert is_finished(tracker)
