"""Rollouts take what users have: wrapped environments, plain seeds, noise by name."""

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from types import SimpleNamespace
from typing import Any
from unittest.mock import MagicMock

import gymnasium as gym
import numpy as np
import pettingzoo
import pytest

import khepera_forage  # noqa: F401 (registers the environments)
from khepera_forage.envs import paired_corridors_v1, paired_corridors_wheels_v1
from khepera_forage.envs.arguments import checked_arena
from khepera_forage.envs.training import TrainingEnv
from khepera_forage.noise import Noise
from khepera_forage.policies import KNearestImitator, ModelPolicy, NearestNeighbourImitator, Teacher, state_vector_of
from khepera_forage.policies.classifiers import tree
from khepera_forage.rollouts.dagger import dagger
from khepera_forage.rollouts.recall import recall, recall_env, recall_wheels, recall_wheels_env
from khepera_forage.rollouts.training import train
from khepera_forage.task.decisions import Decisions

NAME = "khepera_forage/Corridor-v1"


@pytest.mark.parametrize("backend", ["pymunk", "compiled"])
def test_recall_takes_what_make_returns(backend: str) -> None:
    env = gym.make(NAME, backend=backend, noise="none")
    row = recall(env, Teacher.of(env), seed=1)
    assert row.delivered == 1
    assert row == recall(env.unwrapped, Teacher.of(env), seed=1)


@pytest.mark.parametrize(
    "given",
    [
        {"decisions": Decisions(next_to_food=22)},
        {"arena": replace(checked_arena("corridor", Decisions()), home_radius=60.0)},
    ],
)
def test_teacher_learns_what_it_needs_of_the_environment(given: Any) -> None:
    env: Any = gym.make(NAME, noise="none", **given).unwrapped
    row = recall(env, Teacher(), seed=1)
    assert (row.delivered, row.correct) == (1, row.steps)
    labels = dagger(tree, env, queries=60, seed=0)
    expected = [Teacher.of(env).act(vector) for vector in labels.vectors.tolist()]
    assert labels.behaviours.tolist() == expected
    paired = TrainingEnv(noise="none", **given)
    assert train(paired, 1, teacher=Teacher())[0] == train(paired, 1)[0]


@pytest.mark.parametrize("kind", [NearestNeighbourImitator, partial(KNearestImitator, 1)])
def test_imitators_learn_the_diagonal_of_the_arena(kind: Any) -> None:
    """Which of two vectors is nearer depends on it: one differs by 11 positions of the arm, one by 30 pixels."""
    env = recall_env("rectangle", limit=1)
    vector = state_vector_of(env.reset(seed=0)[0])
    food = vector.robot_food_distance - 30
    vectors = [vector._replace(arms_height=226), vector._replace(robot_food_distance=food)]
    imitators = [kind(diagonal=one).fit(vectors, [0, 7]) for one in (None, 177, 138)]
    assert [recall(env, imitator, seed=0).correct for imitator in imitators] == [0, 0, 1]
    levels = [kind(diagonal=one).fit(vectors, [0, 7]).predict([vector]) for one in (None, 138)]
    assert levels == [[0], [0]], "without an environment, that of the corridor"


def test_train_takes_a_number_as_seed_and_a_wrapped_environment() -> None:
    made: Any = pettingzoo.make("aec", "khepera_forage/PairedCorridors-v1")
    results = [
        train(paired_corridors_v1.raw_env(), np.random.SeedSequence(3))[1],
        train(paired_corridors_v1.env(), 3)[1],
        train(made, 3)[1],
    ]
    assert results[0] == results[1] == results[2]


@pytest.mark.parametrize("backend", ["pymunk", "compiled"])
@pytest.mark.parametrize(
    ("noise", "name"),
    [("none", "none"), ("laboratory", "laboratory"), (None, "laboratory"), (Noise(wheel_slip=0.1), "other")],
)
def test_rows_name_the_noise_of_the_environment(noise: Noise | str | None, name: str, backend: str) -> None:
    _, attempts = train(TrainingEnv(noise=noise, backend=backend), 1)
    assert {row.noise for row in attempts} == {name}
    alone = recall_env("corridor", noise, limit=1, backend=backend)
    assert recall(alone, Teacher(), 1).noise == name
    assert recall(alone, Teacher(), 1, noise="of my own").noise == "of my own"


TWO: Any = np.int64(2)


class Fixed:
    """Always the same action, as the simplest agent and as a model."""

    def __init__(self, action: Any) -> None:
        self.action = action

    def act(self, observation: Any, rng: Any = None) -> Any:
        return self.action

    def predict(self, observation: Any, deterministic: bool = True) -> Any:
        return self.action, None


def test_recall_takes_an_agent_without_rng_and_a_seed_of_numpy() -> None:
    env, observes = recall_env("corridor", limit=5), SimpleNamespace(act=lambda observation: np.array([3]))
    assert recall(env, observes, seed=TWO) == recall(env, Fixed(3), seed=2)
    wheels = recall_wheels_env("corridor", limit=5)
    assert recall_wheels(wheels, Fixed(np.zeros(4)), TWO) == recall_wheels(wheels, Fixed(np.zeros(4)), 2)
    own = recall_wheels_env(checked_arena("corridor", Decisions()), limit=5)
    assert recall_wheels(own, Fixed(np.ones(4)), 1) == recall_wheels(wheels, Fixed(np.ones(4)), 1)


def test_robot_stops_after_an_interrupt_of_its_policy() -> None:
    runs: list[tuple[Any, Any, Any]] = [(recall, recall_env, 0), (recall_wheels, recall_wheels_env, np.ones(4))]
    for run, make, action in runs:
        env = make("corridor", noise="none")
        policy = SimpleNamespace(act=MagicMock(side_effect=[action] * 3 + [KeyboardInterrupt]))
        with pytest.raises(KeyboardInterrupt):
            run(env, policy, 1)
        before = env.world.robots[0].sense()
        env.world.advance()
        assert env.world.robots[0].sense()[1:3] == before[1:3]


def test_confidence_levels_of_an_earlier_policy_are_not_shown() -> None:
    env, shown = recall_env("corridor", limit=3), []
    for policy in (NearestNeighbourImitator().fit([(0, 60, 0, 215, 40)], [0]), Teacher()):
        recall(env, policy, 1, callback=lambda: shown.append(env.confidence is None))
    assert shown == [False] * 4 + [True] * 4


NO_COUNTS: list[Any] = [-1, 0, "a", 1.5]
WRONG: list[tuple[Callable[..., Any], tuple[Any, ...], str]] = [
    (recall, (recall_env("corridor"), 3, 0), "learner is 3; allowed: an instance with act"),
    (recall, (recall_env("corridor"), Fixed(1.5), 0), "action of Fixed is 1.5; allowed: a whole"),
    (recall, (recall_env("corridor"), ModelPolicy(Fixed(np.array([2.7]))), 0), "action of Fixed is .*; allowed: "),
    (recall, (recall_env("corridor"), Teacher(), 0.5), "seed is 0.5; allowed: a whole number"),
    (recall, (3, Teacher(), 0), "env is 3; allowed: Corridor-v1"),
    (recall, (gym.make("khepera_forage/CorridorWheels-v1"), Teacher(), 0), "env is <.*>; allowed: .*; recall_wheels"),
    (recall, (gym.make("CartPole-v1"), Teacher(), 0), "env is <.*>; allowed: Corridor-v1, Rectangle-v1"),
    (recall_wheels, (gym.make(NAME), Teacher(), 1), "env is <.*>; allowed: CorridorWheels-v1"),
    (recall_env, (3,), "arena is 3; allowed: an Arena"),
    (recall_wheels_env, ("corridr",), "arena is 'corridr'; allowed: an Arena, or one of 'corridor', "),
    (ModelPolicy, (Fixed(0), None, 0), "hold is 0; allowed: a whole number of at least 1"),
    (Teacher.of, (3,), "env is 3; allowed: one environment of this package, not a batch"),
    *((train, (paired_corridors_v1.env(), seed), f"seed is {seed!r}; allowed: a whole number of at least 0")
      for seed in (-1, 1.5, "1", None)),
    *((partial(train, attempts=wrong), (paired_corridors_v1.env(), 0), f"attempts is {wrong!r}; allowed: a whole n")
      for wrong in NO_COUNTS),
    (dagger, (tree(), recall_env("corridor"), 1, 0), "make is .*Tree.*; allowed: what makes a classifier"),
    (dagger, (tree, recall_env("corridor"), 1, -1), "seed is -1; allowed: a whole number of at least 0"),
    *((dagger, (tree, recall_env("corridor"), wrong, 0), f"queries is {wrong!r}; allowed: a whole number of at least 1")
      for wrong in (1.5, "a")),
    *((train, (env, 0), "allowed: a TrainingEnv of behaviours, such as paired_corr")
      for env in (3, gym.make("CartPole-v1"), paired_corridors_wheels_v1.env())),
]  # fmt: skip


@pytest.mark.parametrize(("call", "arguments", "message"), WRONG)
def test_wrong_argument_is_named(call: Callable[..., Any], arguments: tuple[Any, ...], message: str) -> None:
    with pytest.raises((TypeError, ValueError), match=message):
        call(*arguments)
