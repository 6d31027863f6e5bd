"""The food tracker in a simulated world: while food is pushed, carried and set down."""

import math
from collections.abc import Callable
from typing import Any

import gymnasium as gym
import numpy as np
import pytest

import khepera_forage  # noqa: F401 (registers the environments)
from khepera_forage.task.decisions import Decisions
from khepera_forage.task.food_tracking import is_collected, is_finished
from khepera_forage.task.states import Behaviour, FoodType
from khepera_forage.vision.scene import MM_PER_PIXEL
from tests.task.test_food_tracking_scenes import linked_food
from tests.version_0_1 import CORRIDOR, V0_1

B = Behaviour
Check = Callable[[Any], None]


def forage(name: str, seed: int = 0, **kwargs: Any) -> Any:
    """An environment on pymunk after its reset."""
    kwargs.setdefault("decisions", V0_1)
    env: Any = gym.make(f"khepera_forage/{name}-v1", limit=2000, **kwargs).unwrapped
    env.reset(seed=seed)
    return env


def until(env: Any, over: Callable[[Any], bool], limit: int = 700, check: Check = lambda _: None) -> None:
    """The correct behaviour until something has happened."""
    for _ in range(limit):
        if over(env):
            return
        env.step(int(env.forager.correct_behaviour))
        check(env)
    raise AssertionError(f"not over after {limit} rounds, in state {env.forager.state!r}")


def held(env: Any) -> int | None:
    """The food object that is really in the gripper."""
    if not env.forager.senses.object_presence:
        return None
    x, y, heading = env.world.poses()[0]
    gripper = x + 55 * math.cos(heading), y + 55 * math.sin(heading)
    places = env.world.food_places()
    return min(range(len(places)), key=lambda k: (not places[k].lifted, math.dist(places[k][:2], gripper)))


def check_links(env: Any) -> None:
    """Every region in view is linked to the food object that really lies there; so is food in the gripper."""
    food = env.forager.food
    for region in env.world.camera.look().regions:
        k = None if region.holes or not region.found else linked_food(food, region.label)
        if k is not None:
            place = env.world.food_places()[k]
            assert math.dist(place[:2], (region.x * MM_PER_PIXEL, region.y * MM_PER_PIXEL)) < 10
    number = held(env)
    known = FoodType.UNKNOWN if number is None else food.objects[number].known
    assert number is None or food.tracker.type_in_gripper == known
    assert env.forager.raw.food_type == known


def check_deliveries(env: Any) -> None:
    """What counts as delivered lies at home, within a pixel, and is not what the gripper holds."""
    for k, food in enumerate(env.world.food_places()):
        if env.forager.food.objects[k].delivered:
            assert held(env) != k
            assert not food.lifted
            assert math.dist(food[:2], env.arena.home) <= env.arena.home_radius + MM_PER_PIXEL


@pytest.mark.parametrize("decisions", [V0_1, Decisions()], ids=["v0.1", "default"])
@pytest.mark.parametrize("seed", range(12))
def test_two_food_objects_keep_their_types_under_laboratory_noise(seed: int, decisions: Decisions) -> None:
    odds = {"PICKABLE": 0.4, "PUSHABLE": 0.4, "POISONOUS": 0.2}
    env = forage("Rectangle", seed, food_types=odds, decisions=decisions)

    def check(env: Any) -> None:
        check_links(env)
        check_deliveries(env)

    until(env, lambda env: is_finished(env.forager.tracker), limit=1200, check=check)
    foods = env.forager.food.objects
    assert [food.known for food in foods] == [food.type for food in foods]
    assert [is_collected(food) for food in foods] == [food.type != FoodType.POISONOUS for food in foods]


def test_food_is_delivered_once_it_is_set_down_at_home_and_the_robot_is_clear() -> None:
    env = forage("Corridor", noise="none", food_types="PICKABLE")
    food = env.forager.food.objects[0]
    until(env, lambda env: env.world.food_places()[0].lifted)
    # Into the home, and further in it, without releasing the food.
    for behaviour, rounds in ((B.GO_HOME, 60), (B.RELEASE_FOOD, 4)):
        for _ in range(rounds):
            env.step(int(behaviour))
            assert not food.delivered
            check_deliveries(env)
    assert math.dist(env.world.food_places()[0][:2], CORRIDOR.home) < CORRIDOR.home_radius
    until(env, lambda env: not env.world.food_places()[0].lifted, limit=60)
    assert not food.delivered, "still in the gripper"
    until(env, lambda env: food.delivered, limit=60, check=check_deliveries)
    assert env.forager.senses.object_presence == 0
    assert not env.forager.raw.food_seen, "delivered food is no candidate"
    assert env.forager.vector.robot_food_distance == env.diagonal


def test_food_is_identified_once_the_wheels_rest() -> None:
    env = forage("CorridorWheels", noise="none")
    env.reset(seed=0, options={"start": (200, 115, 0), "foods": [(257, 115)]})
    for left, right in ((0.05, 0), (0, 0.05), (-0.05, 0), (0, -0.05)) * 6:
        env.step(np.array((left, right, -1, -1)))
    assert (env.forager.senses.arm, env.forager.senses.object_presence) == (255, 255)
    assert env.forager.raw.food_type == FoodType.UNKNOWN
    env.step(np.array((0, 0, -1, -1)))
    assert env.forager.raw.food_type == FoodType.PICKABLE
