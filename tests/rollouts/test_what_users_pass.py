"""Rollouts take what users have: wrapped environments, plain seeds, noise by name."""

from dataclasses import replace
from importlib.util import find_spec
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
from khepera_forage.policies import ModelPolicy, NearestNeighbourImitator, Neighbours, Teacher
from khepera_forage.policies.classifiers import tree
from khepera_forage.rollouts.dagger import dagger
from khepera_forage.rollouts.recall import recall, recall_env, recall_wheels
from khepera_forage.rollouts.training import train
from khepera_forage.sim.arenas.named import named_arena
from khepera_forage.task.decisions import Decisions

NAME = "khepera_forage/Corridor-v1"
SET_UP = set_up_of(Decisions())
needs_numba = pytest.mark.skipif(find_spec("numba") is None, reason="needs numba")


@pytest.mark.parametrize("backend", ["pymunk", pytest.param("compiled", marks=needs_numba)])
def test_recall_takes_what_make_returns(backend: str) -> None:
    env = gym.make(NAME, backend=backend, noise="none")
    row = recall(env, Teacher.of(env), seed=1)
    assert row.delivered == 1
    assert row == recall(env.unwrapped, Teacher.of(env), seed=1)


@pytest.mark.parametrize(
    "given",
    [
        {"decisions": Decisions(next_to_food=22)},
        {"arena": replace(named_arena("corridor", SET_UP), home_radius=60.0)},
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


def test_imitator_learns_the_diagonal_of_the_arena() -> None:
    used = set()

    class Spy(NearestNeighbourImitator):
        def neighbours(self, observation: Any) -> Neighbours:
            used.add(self.diagonal)
            return super().neighbours(observation)

    vectors, behaviours = train(TrainingEnv(), 1)[0].arrays()
    for diagonal in (None, 138):
        recall(recall_env("rectangle", limit=10), Spy(diagonal).fit(vectors, behaviours), seed=0)
    assert used == {177, 138}
    given = NearestNeighbourImitator().fit(vectors, behaviours)
    assert (
        given.predict_proba(vectors).tolist()
        == given.set_params(diagonal=138).predict_proba(vectors).tolist()
    )


def test_train_takes_a_number_as_seed_and_a_wrapped_environment() -> None:
    made: Any = pettingzoo.make("aec", "khepera_forage/PairedCorridors-v1")
    results = [
        train(paired_corridors_v1.raw_env(), np.random.SeedSequence(3))[1],
        train(paired_corridors_v1.env(), 3)[1],
        train(made, 3)[1],
    ]
    assert results[0] == results[1] == results[2]


@pytest.mark.parametrize("seed", [-1, 1.5, "1", None])
def test_train_names_a_wrong_seed(seed: Any) -> None:
    with pytest.raises(ValueError, match=f"seed is {seed!r}; allowed: a whole number of at least 0"):
        train(paired_corridors_v1.env(), seed)


@pytest.mark.parametrize("env", [gym.make("CartPole-v1"), paired_corridors_wheels_v1.env()])
def test_train_names_another_environment(env: Any) -> None:
    with pytest.raises(TypeError, match="allowed: a TrainingEnv of behaviours, such as paired_corr"):
        train(env, 0)


@pytest.mark.parametrize("backend", ["pymunk", pytest.param("compiled", marks=needs_numba)])
def test_noise_has_names(backend: str) -> None:
    shown = []
    for noise in ("none", Noise.none(), "laboratory", None, Noise.laboratory()):
        env = gym.make(NAME, backend=backend, noise=noise)
        env.reset(seed=2)
        for _ in range(5):
            _, _, _, _, info = env.step(0)
        shown.append((info["pose"].tolist(), info["steps"]))
    assert shown[0] == shown[1] != shown[2] == shown[3] == shown[4]


@pytest.mark.parametrize("noise", ["quiet", 0.5, {"wheel_slip": 0}])
def test_other_noise_is_named(noise: Any) -> None:
    message = "noise is .*; allowed: a Noise, 'laboratory' or 'none'"
    with pytest.raises(ValueError, match=message):
        gym.make(NAME, noise=noise)
    with pytest.raises(ValueError, match=message):
        recall_env("corridor", noise)
    with pytest.raises(ValueError, match=message):
        paired_corridors_v1.env(noise=noise)
    if find_spec("numba") is not None:
        with pytest.raises(ValueError, match=message):
            gym.make_vec(NAME, num_envs=2, noise=noise)


THREE: Any = 3
HALF: Any = 0.5
TWO: Any = np.int64(2)


class Fixed:
    """Always the same action, as the simplest agent and as a model."""

    def __init__(self, action: Any) -> None:
        self.action = action

    def act(self, observation: Any, rng: Any = None) -> Any:
        return self.action

    def predict(self, observation: Any, deterministic: bool = True) -> Any:
        return self.action, None


class OnlyObserves(Fixed):
    """Decides by the observation alone."""

    def act(self, observation: Any) -> Any:  # type: ignore[override]
        return self.action


def test_recall_takes_an_agent_without_rng_and_a_seed_of_numpy() -> None:
    env = recall_env("corridor", limit=5)
    assert recall(env, OnlyObserves(np.array([3])), seed=TWO) == recall(env, Fixed(3), seed=2)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (
            lambda: recall(recall_env("corridor"), THREE, seed=0),
            "learner is 3; allowed: an instance with act",
        ),
        (
            lambda: recall(recall_env("corridor"), Teacher, seed=0),
            "learner is <class .*; allowed: an instance",
        ),
        (
            lambda: recall(recall_env("corridor"), Fixed(1.5), seed=0),
            "action of Fixed is 1.5; allowed: a whole",
        ),
        (
            lambda: recall(recall_env("corridor"), Teacher(), seed=HALF),
            "seed is 0.5; allowed: a whole number",
        ),
        (lambda: ModelPolicy(Fixed(0), hold=0), "hold is 0; allowed: a whole number of at least 1"),
        (lambda: recall(THREE, Teacher(), seed=0), "env is 3; allowed: Corridor-v1"),
        (lambda: Teacher.of(THREE), "env is 3; allowed: one environment of this package, not a batch"),
        (lambda: train(THREE, 0), "env is 3; allowed: a TrainingEnv"),
        (lambda: recall_env(THREE), "arena is 3; allowed: an Arena"),
        (lambda: gym.make(NAME, food_types={"PICKABLE": "a"}), "odds of PICKABLE are 'a'; allowed: a number"),
        (
            lambda: gym.make(NAME, food_types=["PICKABLE"]),
            r"food type \['PICKABLE'\] is unknown; allowed: PICK",
        ),
    ],
)
def test_argument_of_a_wrong_type_is_named(call: Any, message: str) -> None:
    with pytest.raises((TypeError, ValueError), match=message):
        call()


def test_recall_names_another_environment() -> None:
    for env in (gym.make("khepera_forage/CorridorWheels-v1"), gym.make("CartPole-v1")):
        with pytest.raises(TypeError, match=r"env is <.*>; allowed: Corridor-v1, Rectangle-v1"):
            recall(env, Teacher(), seed=0)
    with pytest.raises(TypeError, match=r"env is <.*>; allowed: CorridorWheels-v1"):
        recall_wheels(gym.make(NAME), Teacher(), 1)
