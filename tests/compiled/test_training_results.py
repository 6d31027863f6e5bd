"""The result of training many compiled learners: experience, attempts, distributions and errors."""

from typing import Any

import numba
import numpy as np
import pytest
from scipy import stats

from khepera_forage.envs.training import TrainingEnv
from khepera_forage.experience import Experience
from khepera_forage.noise import Noise
from khepera_forage.rollouts.compiled import training
from khepera_forage.rollouts.compiled.training import HEARD, train_learners
from khepera_forage.rollouts.rows import TrainingRow
from khepera_forage.rollouts.training import IncompleteTrainingError, train
from khepera_forage.task.states import Behaviour, FoodType
from tests.version_0_1 import CORRIDOR, V0_1

MIXED = {"pickable": 1, "pushable": 1, "poisonous": 1}
ROUGH = Noise(placement_error=15.0, placement_heading_error=20.0, wheel_bias=0.1, wheel_slip=0.2)
"""Robots so bad that learners often get separated."""


def test_corresponding_food_has_one_type_and_poison_is_always_avoided() -> None:
    """What is heard follows the teacher's food, and what is perceived the learner's own."""
    trained = train_learners(600, food_types=MIXED, decisions=V0_1)
    shown = {
        FoodType.PICKABLE: Behaviour.PICK_UP_FOOD,
        FoodType.PUSHABLE: Behaviour.PUSH_FOOD,
        FoodType.POISONOUS: Behaviour.AVOID_FOOD,
    }
    types: list[FoodType] = []
    both = 0
    for learner in range(600):
        rows = trained.vectors_of(learner)
        perceived = {FoodType(t) for t in rows[:, 2].tolist()} - {FoodType.UNKNOWN}
        heard = {t for t, behaviour in shown.items() if behaviour in rows[:, HEARD]}
        # A robot with nothing in its gripper when the other identifies the food may never show, or perceive, its type.
        assert len(heard | perceived) <= 1
        types += heard | perceived
        both += bool(heard and perceived)
    assert both > 350
    assert len(types) > 590
    assert stats.chisquare(np.bincount(types)[1:]).pvalue > 1e-3


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


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"n": 0}, "n is 0"),
        ({"episodes": 0}, "episodes is 0"),
        ({"seed": -1}, "seed is -1"),
        ({"patience": 0}, "patience is 0"),
        ({"max_cycles": 1.5}, "max_cycles is 1.5"),
        ({"arena": "moon"}, "arena is 'moon'"),
        ({"arena": CORRIDOR.shifted(3000.0, 0.0)}, "what the camera sees"),
        ({"options": {"foods": [(90.0, 115.0)]}, "decisions": V0_1}, "overlaps"),
        ({"options": {"place": 1}}, "reset option 'place'"),
        ({"noise": Noise(placement_error=1e6)}, "too near a wall for a placement error"),
        ({"decisions": 17}, "decisions is 17"),
    ],
)
def test_bad_arguments_are_quoted(arguments: Any, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        train_learners(**{"n": 1, **arguments})


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
