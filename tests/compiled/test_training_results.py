"""The result of training many compiled learners: experience, attempts, distributions and errors."""

from typing import Any

import numba
import numpy as np
import pytest
from scipy import stats

from khepera_forage.envs.training import TrainingEnv
from khepera_forage.experience import Experience
from khepera_forage.noise import Noise
from khepera_forage.policies.policy import HEARD
from khepera_forage.rollouts.compiled import training
from khepera_forage.rollouts.compiled.training import train_learners
from khepera_forage.rollouts.rows import TrainingRow
from khepera_forage.rollouts.training import IncompleteTrainingError, train
from khepera_forage.task.states import Behaviour
from tests.version_0_1 import V0_1

MIXED = {"pickable": 1, "pushable": 1, "poisonous": 1}
ROUGH = Noise(placement_error=15.0, placement_heading_error=20.0, wheel_bias=0.1, wheel_slip=0.2)
"""Robots so bad that learners often get separated."""


def test_a_learner_does_not_depend_on_the_number_of_learners(monkeypatch: pytest.MonkeyPatch) -> None:
    many = train_learners(300, seed=5, noise=ROUGH, food_types=MIXED, episodes=2)
    threads = numba.get_num_threads()
    monkeypatch.setattr(training, "_ROOM", 1)  # one block of episodes at a time
    numba.set_num_threads(1)
    few = train_learners(40, seed=5, noise=ROUGH, food_types=MIXED, episodes=5)
    numba.set_num_threads(threads)
    for learner in range(40):
        for episode in range(2):
            assert (many.vectors_of(learner, episode) == few.vectors_of(learner, episode)).all()
    for name in ("complete", "rounds", "vectors", "separations", "reason"):
        of_many = getattr(many.attempts, name)[many.attempts.learner < 40]
        of_few = getattr(few.attempts, name)[few.attempts.episode < 2]
        assert (of_many == of_few).all()


def test_attempts_are_valid_training_rows() -> None:
    """Incomplete attempts are counted, and what they recorded is forgotten (5.2)."""
    trained = train_learners(400, seed=1, noise=ROUGH, food_types=MIXED, episodes=2, decisions=V0_1)
    rows = [
        TrainingRow(0, learner + 1, attempt, trained.seed, "rough", complete, rounds, vectors, apart, reason)
        for learner, _, attempt, complete, rounds, vectors, apart, reason in zip(
            *(column.tolist() for column in trained.attempts), strict=True
        )
    ]
    assert sum(row.complete for row in rows) == 800
    assert {row.reason for row in rows} == {"", "separated", "out of time"}
    assert all(row.rounds < 600 for row in rows if row.reason == "separated")
    assert sum(row.separations for row in rows) > 100
    assert sum(row.vectors < row.rounds for row in rows) > 100  # nothing is recorded in silence
    assert np.diff(trained.offsets).ravel().tolist() == [row.vectors for row in rows if row.complete]
    assert trained.offsets[-1, -1] == len(trained.experience)
    assert (trained.experience[:, HEARD] < Behaviour.WAIT).all()


def test_training_takes_as_long_as_on_pymunk() -> None:
    """Some tens of trainings here; thousands in docs/compiled.md."""
    env = TrainingEnv(noise=ROUGH, food_types=MIXED)
    single = [train(env, seed)[1] for seed in np.random.SeedSequence(1).spawn(60)]
    compiled = train_learners(4000, seed=2, noise=ROUGH, food_types=MIXED).attempts
    for name in ("rounds", "vectors", "separations"):
        ours = getattr(compiled, name)[compiled.complete]
        assert stats.ks_2samp(ours, [getattr(rows[-1], name) for rows in single]).pvalue > 1e-3
    assert stats.ks_2samp(np.bincount(compiled.learner), [len(rows) for rows in single]).pvalue > 1e-3


def test_training_that_is_never_complete_raises_the_same_error_as_on_pymunk() -> None:
    with pytest.raises(RuntimeError, match="none of 3 attempts") as compiled:
        train_learners(2, max_cycles=9, attempts=3)
    with pytest.raises(IncompleteTrainingError) as single:
        train(TrainingEnv(max_cycles=9), np.random.SeedSequence(0), attempts=3)
    assert str(compiled.value) == str(single.value)


@pytest.mark.parametrize(("learner", "episode", "name"), [(1, None, "learner"), (0, 2, "episode")])
def test_missing_learner_or_episode_is_quoted(learner: int, episode: int | None, name: str) -> None:
    trained = train_learners(1)
    value = learner if episode is None else episode
    with pytest.raises(ValueError, match=f"{name} is {value}; allowed: 0 to"):
        trained.vectors_of(learner, episode)


def test_experience_of_a_learner_can_be_saved_and_loaded(tmp_path: Any) -> None:
    trained = train_learners(2, seed=3, episodes=2)
    whole = trained.experience_of(1)
    assert whole.episodes == 2
    first, second = (trained.experience_of(1, episode) for episode in range(2))
    assert first + second == whole
    whole.save(tmp_path / "g1.csv")
    assert Experience.load(tmp_path / "g1.csv") == whole
