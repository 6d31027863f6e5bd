"""Every learner that imitates: the contract of policies, the same outcome for the same seed, pickling."""

import pickle
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from sklearn.utils.estimator_checks import parametrize_with_checks

from khepera_forage.policies import (
    GrowingMemory,
    KNearestImitator,
    NearestNeighbourImitator,
    Policy,
    WeightedImitator,
    state_vector_of,
)
from khepera_forage.policies.learners import LEARNERS, OfflineImitation
from khepera_forage.task.decisions import Decisions
from khepera_forage.task.states import behaviour_for, classify
from tests.contracts.suites import PolicyContract, observations

IMITATING = {name: learner for name, learner in LEARNERS.items() if isinstance(learner, OfflineImitation)}


def experience(seed: int, count: int = 300) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """State vectors of a forage and the teacher's behaviour for each."""
    rng = np.random.default_rng(seed)
    held = rng.integers(0, 3, count)
    rows = np.column_stack(
        (
            held > 0,
            rng.integers(5, 100, count),
            held // 2,
            rng.choice([215, 235, 255], count),
            rng.integers(0, 60, count),
        )
    )
    decisions = Decisions().values()
    return rows, np.array([behaviour_for(classify(state_vector_of(row), 20, decisions)) for row in rows])


class TestLearners(PolicyContract):
    @pytest.fixture(params=IMITATING)
    def policy(self, request: pytest.FixtureRequest) -> Policy:
        return IMITATING[request.param].learn(*experience(0))


@pytest.mark.parametrize("name", IMITATING)
def test_same_seed_gives_the_same_policy_also_pickled(name: str) -> None:
    shown = [*observations(), *experience(1, 60)[0]]
    once = IMITATING[name].learn(*experience(0), seed=3)
    decisions = []
    for policy in (once, IMITATING[name].learn(*experience(0), seed=3), pickle.loads(pickle.dumps(once))):
        rng = np.random.default_rng(5)
        decisions.append([int(policy.act(observation, rng)) for observation in shown])
    assert decisions[0] == decisions[1] == decisions[2]


@pytest.mark.parametrize("name", IMITATING)
def test_learner_agrees_with_the_teacher(name: str) -> None:
    """Far above chance on new state vectors: the teacher's most frequent behaviour is below a half."""
    policy = IMITATING[name].learn(*experience(0), seed=1, groups=np.arange(300) // 30)
    rows, said = experience(2, 200)
    rng = np.random.default_rng(4)
    agreed = np.mean([policy.act(row, rng) == word for row, word in zip(rows, said, strict=True)])
    assert np.bincount(said).max() / 200 < 0.5
    assert agreed > 0.65


@parametrize_with_checks(  # type: ignore[untyped-decorator]
    [
        NearestNeighbourImitator(),
        NearestNeighbourImitator(diagonal=177, arithmetic="32-bit floats"),
        KNearestImitator(k=3, weighting="distance"),
        WeightedImitator(random_state=0),
        GrowingMemory(),
    ]
)
def test_classifiers_pass_check_estimator(estimator: Any, check: Any) -> None:
    check(estimator)
