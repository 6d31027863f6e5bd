"""DAgger: the expert labels the states that the learner visits."""

from typing import Any

import numpy as np
import pytest
from sklearn.tree import DecisionTreeClassifier

from khepera_forage.envs.behaviours_env import BehavioursEnv
from khepera_forage.policies import UniformPolicy, state_vector_of
from khepera_forage.policies.learners import LEARNERS, InteractiveImitation, OfflineImitation
from khepera_forage.rollouts.dagger import dagger
from khepera_forage.rollouts.recall import recall, recall_env
from khepera_forage.task.states import Behaviour, behaviour_for, classify
from tests.version_0_1 import V0_1


@pytest.fixture(scope="module")
def env() -> BehavioursEnv:
    return recall_env("corridor", decisions=V0_1)


def make() -> Any:
    return DecisionTreeClassifier(random_state=0)


def test_every_query_has_the_teachers_behaviour(env: BehavioursEnv) -> None:
    out = dagger(make, env, 230, 7, queries_a_round=100)
    assert [r.queries for r in out.rounds] == [100, 100, 30]
    assert out.vectors.shape == (230, 5)
    for row, behaviour in zip(out.vectors, out.behaviours, strict=True):
        assert behaviour == behaviour_for(classify(state_vector_of(row), env.home_radius, env.decisions.values()))
    assert out.rounds[0].agreed == 100, "the teacher itself acts in the first round"
    assert out.rounds[1].agreed < 100
    assert dagger(make, env, 20, 7, expert=UniformPolicy()).rounds[0].agreed == 20, "it does what it says"


def test_learner_agrees_with_the_teacher_after_enough_rounds(env: BehavioursEnv) -> None:
    out = dagger(make, env, 2_000, 14)
    assert min(r.agreed for r in out.rounds[1:]) < 60, "the learner visits states without a record"
    assert min(r.agreed for r in out.rounds[-5:]) > 90
    assert sum(recall(env, out.policy, seed).delivered for seed in range(8)) >= 7


def test_start_experience_is_learned_without_queries(env: BehavioursEnv) -> None:
    start = np.array([[0, 90, 0, 215, 60], [0, 60, 0, 255, 18]]), np.array([7, 7])
    out = dagger(make, env, 40, 3, queries_a_round=40, start=start)
    np.testing.assert_array_equal(out.vectors[:2], start[0])
    assert out.behaviours[:2].tolist() == [7, 7]
    assert len(out.vectors) == 42
    assert out.rounds[0].agreed < 40, "the learner goes home from the first step, which is wrong"


@pytest.mark.parametrize(("queries", "a_round"), [(0, 100), (10, 0)])
def test_number_of_queries_below_one_is_an_error(env: BehavioursEnv, queries: int, a_round: int) -> None:
    with pytest.raises(ValueError, match="allowed: a whole number of at least 1"):
        dagger(make, env, queries, 0, queries_a_round=a_round)


@pytest.mark.parametrize("name", [name for name, one in LEARNERS.items() if isinstance(one, InteractiveImitation)])
def test_registered_dagger_learners_work(env: BehavioursEnv, name: str) -> None:
    learner = LEARNERS[name]
    assert isinstance(learner, InteractiveImitation)
    inner: OfflineImitation = learner.learner
    out = dagger(lambda: inner.classifier(env.diagonal, 0), env, 150, 0, sample=inner.sample, **learner.settings)
    assert Behaviour(out.policy.act(out.vectors[0], np.random.default_rng(0))) < Behaviour.WAIT
