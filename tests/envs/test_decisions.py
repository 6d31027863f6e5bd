"""Environments under other decisions: set-up, rules and markers."""

from dataclasses import replace
from typing import Any

import gymnasium as gym
import pytest

from khepera_forage import Decisions
from khepera_forage.envs import paired_corridors_v1
from khepera_forage.envs.arguments import checked_arena, set_up_of
from khepera_forage.envs.behaviours_env import BehavioursEnv
from khepera_forage.envs.recall import RecallEnv
from khepera_forage.envs.training import TEACHER, TrainingEnv
from khepera_forage.envs.wheels_env import WheelsEnv
from khepera_forage.noise import Noise
from khepera_forage.sim.arena import Pose
from khepera_forage.sim.arenas.named import named_arena
from khepera_forage.sim.arenas.thesis import THESIS_ARENAS
from khepera_forage.task.states import Behaviour
from tests.version_0_1 import CORRIDOR, V0_1

IDS = [f"khepera_forage/{name}-v1" for name in ("Corridor", "Rectangle", "CorridorWheels", "RectangleWheels")]


def recall_env(env_id: str = IDS[0], **kwargs: Any) -> RecallEnv[Any]:
    env = gym.make(env_id, **kwargs).unwrapped
    assert isinstance(env, RecallEnv)
    return env


# ---------------------------------------------------------------- how decisions are given


@pytest.mark.parametrize(
    "decisions", [17, "next_to_food=17", {"next_to_food": 17}, [], Noise.none(), Decisions]
)
@pytest.mark.parametrize("make", [BehavioursEnv, WheelsEnv, TrainingEnv, paired_corridors_v1.env])
def test_decisions_of_the_wrong_type_are_refused(make: Any, decisions: Any) -> None:
    with pytest.raises(ValueError, match=r"allowed: a khepera_forage\.Decisions, or None") as error:
        make(decisions=decisions)
    assert repr(decisions) in str(error.value)


# ---------------------------------------------------------------- the set-up of figure 5.1


@pytest.mark.parametrize("name", THESIS_ARENAS)
def test_set_up_of_a_named_arena_follows_the_decisions(name: str) -> None:
    decisions = Decisions(start_to_wall=120, food_to_home=200, home_to_wall=90, home_radius=80)
    arena = checked_arena(name, decisions)
    assert arena.start.x == 120
    assert arena.home.x == 650 - 90
    assert arena.home_radius == 80
    assert {arena.home.x - food.x for food in arena.foods} == {200}
    assert checked_arena(name, Decisions()) == named_arena(name, set_up_of(Decisions()))
    env = BehavioursEnv(arena=name, decisions=decisions)
    assert (env.arena, env.home_radius) == (arena, 16)
    assert TrainingEnv(arena=name, decisions=decisions).arenas[0] == arena


def test_given_arena_stays_whatever_the_decisions() -> None:
    env = BehavioursEnv(arena=CORRIDOR, decisions=Decisions(start_to_wall=120, home_radius=80))
    assert env.arena is CORRIDOR


@pytest.mark.parametrize("name", ["start_to_wall", "food_to_home", "home_to_wall", "home_radius"])
def test_ends_of_the_set_up_ranges_fit_in_the_named_arenas(name: str) -> None:
    known = Decisions.__dataclass_fields__[name].metadata["decision"]
    for value in (known.least, known.most):
        changes = {name: value}
        if name == "home_to_wall" and value < 100:
            changes["home_radius"] = value
        if name == "home_radius" and value > 100:
            changes["home_to_wall"] = value
        decisions = Decisions.from_changes(changes)
        for arena in THESIS_ARENAS:
            env = BehavioursEnv(arena=arena, decisions=decisions)
            env.reset(seed=1)


# ---------------------------------------------------------------- rules


def test_separation_and_patience_of_training_follow_the_decisions() -> None:
    env = TrainingEnv(noise=Noise.none(), decisions=Decisions(separation=30, patience=5))
    assert env.patience == 5
    assert TrainingEnv(patience=7, decisions=Decisions(patience=5)).patience == 7
    env.reset(seed=0)
    rounds = []
    for dx in (100.0, 100.0):
        x, y, heading = env.world.poses()[1]
        env.world.place(1, Pose(x + dx, y, heading))
        for _ in env.possible_agents:
            env.step(int(Behaviour.WAIT))
        rounds.append(env.infos["learner_0"]["separated_rounds"])
    assert rounds == [0, 1], "20 pixels apart, then 40"
    while not env.truncations[TEACHER]:
        for _ in env.possible_agents:
            env.step(int(Behaviour.EXPLORE_FOOD))
    assert env.infos["learner_0"]["separated_rounds"] == 5


def test_recall_marker_is_that_of_the_robot() -> None:
    for holes in (1, 2):
        env = recall_env(decisions=Decisions(recall_marker=holes))
        env.reset(seed=1)
        assert env.forager.holes == holes
        assert {region.holes for region in env.world.camera.look().regions} == {0, holes}


def test_teacher_delivers_under_other_decisions() -> None:
    """A changed reading of the thesis stays a task that the teacher can do."""
    changes: dict[str, Any] = {
        "next_to_food": 19.0,
        "close_to_food": 35.0,
        "home_radius": 90.0,
        "search_speed": 10.0,
    }
    decisions = replace(V0_1, round_duration=0.08, arm_travel_time=0.8, **changes)
    env = BehavioursEnv(decisions=decisions)
    delivered = 0
    for seed in range(5):
        env.reset(seed=seed)
        over = False
        while not over:
            _, _, terminated, truncated, info = env.step(int(env.forager.correct_behaviour))
            over = terminated or truncated
        delivered += info["delivered"]
    assert delivered >= 4
