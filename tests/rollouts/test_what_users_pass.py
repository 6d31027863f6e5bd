"""Rollouts take what users have: wrapped environments, plain seeds, noise by name."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import gymnasium as gym
import numpy as np
import pettingzoo
import pytest

import khepera_forage  # noqa: F401 (registers the environments)
from khepera_forage.envs import paired_corridors_v1, paired_corridors_wheels_v1
from khepera_forage.envs.arguments import set_up_of
from khepera_forage.envs.training import TrainingEnv
from khepera_forage.noise import Noise
from khepera_forage.policies import KNearestImitator, ModelPolicy, NearestNeighbourImitator, Neighbours, Teacher
from khepera_forage.policies.classifiers import tree
from khepera_forage.rollouts.dagger import dagger
from khepera_forage.rollouts.recall import recall, recall_env, recall_wheels, recall_wheels_env
from khepera_forage.rollouts.training import train
from khepera_forage.sim.arenas.named import named_arena
from khepera_forage.task.decisions import Decisions

NAME = "khepera_forage/Corridor-v1"
SET_UP = set_up_of(Decisions())


@pytest.mark.parametrize("backend", ["pymunk", "compiled"])
def test_recall_takes_what_make_returns(backend: str) -> None:
    env = gym.make(NAME, backend=backend, noise="none")
    row = recall(env, Teacher.of(env), seed=1)
    assert row.delivered == 1
    assert row == recall(env.unwrapped, Teacher.of(env), seed=1)


@pytest.mark.parametrize(
    "given",
    [{"decisions": Decisions(next_to_food=22)}, {"arena": replace(named_arena("corridor", SET_UP), home_radius=60.0)}],
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


def test_imitators_learn_the_diagonal_of_the_arena() -> None:
    used = set()

    class Spy(NearestNeighbourImitator):
        def neighbours(self, observation: Any) -> Neighbours:
            used.add(self.diagonal)
            return super().neighbours(observation)

    class SpyOfAnother(KNearestImitator):
        def predict_proba(self, X: Any) -> Any:
            used.add(self.diagonal)
            return super().predict_proba(X)

    vectors, behaviours = train(TrainingEnv(), 1)[0].arrays()
    for kind in (Spy, SpyOfAnother):
        used.clear()
        for diagonal in (None, 138):
            imitator: Any = kind(diagonal=diagonal).fit(vectors, behaviours)
            recall(recall_env("rectangle", limit=10), imitator, seed=0)
        assert used == {177, 138}
    given = NearestNeighbourImitator().fit(vectors, behaviours)
    assert given.predict_proba(vectors).tolist() == given.set_params(diagonal=138).predict_proba(vectors).tolist()


def test_train_takes_a_number_as_seed_and_a_wrapped_environment() -> None:
    made: Any = pettingzoo.make("aec", "khepera_forage/PairedCorridors-v1")
    results = [
        train(paired_corridors_v1.raw_env(), np.random.SeedSequence(3))[1],
        train(paired_corridors_v1.env(), 3)[1],
        train(made, 3)[1],
    ]
    assert results[0] == results[1] == results[2]


@pytest.mark.parametrize("backend", ["pymunk", "compiled"])
def test_noise_has_names(backend: str) -> None:
    shown = []
    for noise in ("none", Noise.none(), "laboratory", None, Noise.laboratory()):
        env = gym.make(NAME, backend=backend, noise=noise)
        env.reset(seed=2)
        for _ in range(5):
            _, _, _, _, info = env.step(0)
        shown.append((info["pose"].tolist(), info["steps"]))
    assert shown[0] == shown[1] != shown[2] == shown[3] == shown[4]


@pytest.mark.parametrize(("noise", "name"), [("none", "none"), (None, "laboratory"), (Noise(wheel_slip=0.1), "other")])
def test_rows_name_the_noise_of_the_environment(noise: Noise | str | None, name: str) -> None:
    _, attempts = train(TrainingEnv(noise=noise), 1)
    assert {row.noise for row in attempts} == {name}
    alone = recall_env("corridor", noise, limit=1)
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


class Interrupted(Fixed):
    """Whose user presses Ctrl-C in the fourth round."""

    rounds = 0

    def act(self, observation: Any, rng: Any = None) -> Any:
        self.rounds += 1
        if self.rounds == 4:
            raise KeyboardInterrupt
        return self.action


class OnlyObserves(Fixed):
    """Decides by the observation alone."""

    def act(self, observation: Any) -> Any:  # type: ignore[override]
        return self.action


def test_recall_takes_an_agent_without_rng_and_a_seed_of_numpy() -> None:
    env = recall_env("corridor", limit=5)
    assert recall(env, OnlyObserves(np.array([3])), seed=TWO) == recall(env, Fixed(3), seed=2)
    wheels = recall_wheels_env("corridor", limit=5)
    assert recall_wheels(wheels, Fixed(np.zeros(4)), TWO) == recall_wheels(wheels, Fixed(np.zeros(4)), 2)


def test_robot_stops_after_an_interrupt_of_its_policy() -> None:
    for run, env, action in (
        (recall, recall_env("corridor", noise="none"), 0),
        (recall_wheels, recall_wheels_env("corridor", noise="none"), np.ones(4)),
    ):
        with pytest.raises(KeyboardInterrupt):
            run(env, Interrupted(action), 1)
        before = env.world.robots[0].sense()
        env.world.advance()
        assert env.world.robots[0].sense()[1:3] == before[1:3]


def test_confidence_levels_of_an_earlier_policy_are_not_shown() -> None:
    env, shown = recall_env("corridor", limit=3), []
    for policy in (NearestNeighbourImitator().fit([(0, 60, 0, 215, 40)], [0]), Teacher()):
        recall(env, policy, 1, callback=lambda: shown.append(env.confidence is None))
    assert shown == [False] * 4 + [True] * 4


WRONG: list[tuple[Callable[..., Any], tuple[Any, ...], str]] = [
    (recall, (recall_env("corridor"), 3, 0), "learner is 3; allowed: an instance with act"),
    (recall, (recall_env("corridor"), Fixed(1.5), 0), "action of Fixed is 1.5; allowed: a whole"),
    (recall, (recall_env("corridor"), Teacher(), 0.5), "seed is 0.5; allowed: a whole number"),
    (recall, (3, Teacher(), 0), "env is 3; allowed: Corridor-v1"),
    (recall, (gym.make("khepera_forage/CorridorWheels-v1"), Teacher(), 0), "env is <.*>; allowed: Corridor-v1, Rec"),
    (recall, (gym.make("CartPole-v1"), Teacher(), 0), "env is <.*>; allowed: Corridor-v1, Rectangle-v1"),
    (recall_wheels, (gym.make(NAME), Teacher(), 1), "env is <.*>; allowed: CorridorWheels-v1"),
    (recall_env, (3,), "arena is 3; allowed: an Arena"),
    (ModelPolicy, (Fixed(0), None, 0), "hold is 0; allowed: a whole number of at least 1"),
    (Teacher.of, (3,), "env is 3; allowed: one environment of this package, not a batch"),
    *((train, (paired_corridors_v1.env(), seed), f"seed is {seed!r}; allowed: a whole number of at least 0")
      for seed in (-1, 1.5, "1", None)),
    *((train, (env, 0), "allowed: a TrainingEnv of behaviours, such as paired_corr")
      for env in (3, gym.make("CartPole-v1"), paired_corridors_wheels_v1.env())),
]  # fmt: skip


@pytest.mark.parametrize(("call", "arguments", "message"), WRONG)
def test_wrong_argument_is_named(call: Callable[..., Any], arguments: tuple[Any, ...], message: str) -> None:
    with pytest.raises((TypeError, ValueError), match=message):
        call(*arguments)
