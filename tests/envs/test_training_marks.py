"""Training on other marks than those of figure 5.1, and with poison."""

from typing import Any

import numpy as np
import pytest

from khepera_forage.envs.training import TEACHER, TrainingEnv
from khepera_forage.noise import Noise
from khepera_forage.rollouts.training import attempt
from khepera_forage.sim.layout_checks import check_robot
from khepera_forage.task.states import Behaviour, FoodType, StateVector, is_raised
from tests.version_0_1 import V0_1, VALUES


def test_robots_and_food_stand_on_the_given_marks() -> None:
    env = TrainingEnv(num_learners=2, noise=Noise.none())
    env.reset(seed=1, options={"start": (110, 90, 45), "foods": [(300, 140)]})
    for arena, pose, food in zip(env.arenas, env.world.poses(), env.world.food_places(), strict=True):
        home = env.arenas[0].home
        dx, dy = arena.home.x - home.x, arena.home.y - home.y
        assert pose == pytest.approx((110 + dx, 90 + dy, np.pi / 4))
        assert food[:2] == pytest.approx((300 + dx, 140 + dy))


def test_placement_error_applies_to_given_marks() -> None:
    env = TrainingEnv()
    env.reset(seed=1, options={"start": (110, 90, 45)})
    first, second = (np.array(pose[:2]) for pose in env.world.poses())
    assert 0 < np.linalg.norm(first - (110, 90)) < 5 * Noise.laboratory().placement_error
    assert np.abs(second - first - (0, 300)).max() > 1e-3


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"begin": 1}, "'begin' is unknown; allowed: 'start', 'foods'"),
        ({"start": (0, 0, 0)}, "start at .* allowed: on the floor"),
        ({"start": (1, 2)}, "allowed: .x mm, y mm, heading degrees."),
        ({"foods": [(5, 5)]}, "food at .5, 5. mm"),
        ({"foods": [(300, 100), (400, 100)]}, "2 foods given; allowed: 1"),
    ],
)
def test_wrong_options_are_refused(options: dict[str, Any], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        TrainingEnv().reset(seed=0, options=options)


def test_robot_that_would_stand_in_a_wall_is_placed_again() -> None:
    env = TrainingEnv(noise=Noise(placement_error=15.0, placement_heading_error=30.0))
    for seed in range(100):
        env.reset(seed=seed, options={"start": (75, 75, 0)})
        for arena, start in zip(env.arenas, env.world.poses(), strict=True):
            check_robot(arena, start)
    facing_the_wall = {"start": (60, 100, 180)}
    with pytest.raises(
        ValueError, match=r"placement error of 0 mm.*\(60, 100\) mm has its gripper in a wall"
    ):
        TrainingEnv(noise=Noise.none()).reset(seed=0, options=facing_the_wall)


def test_episode_with_poison_is_complete_only_after_it_was_avoided() -> None:
    env = TrainingEnv(food_types="POISONOUS", decisions=V0_1)
    for seed in range(4):
        heard: list[Behaviour] = []

        def record(vector: StateVector, behaviour: Behaviour, heard: list[Behaviour] = heard) -> None:
            heard.append(behaviour)

        result = attempt(env, seed, record)
        assert result.complete
        assert Behaviour.AVOID_FOOD in heard
        assert env.terminations[TEACHER]
        for forager in env.foragers:
            assert [food.known for food in forager.tracker.foods] == [FoodType.POISONOUS]
            assert not forager.vector.object_presence
            assert is_raised(forager.vector.arms_height, VALUES)
