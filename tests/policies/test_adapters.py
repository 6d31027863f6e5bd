"""Learners of all kinds become policies in one line: what they decide, and what models of our own are shown."""

import pickle
from typing import Any

import gymnasium as gym
import numpy as np
import pytest
from gymnasium import spaces
from gymnasium.wrappers import DtypeObservation, FlattenObservation, RescaleObservation
from sklearn.naive_bayes import GaussianNB
from sklearn.svm import LinearSVC

import khepera_forage  # noqa: F401 (registers the environments)
from khepera_forage.policies import (
    AgentPolicy,
    ClassifierPolicy,
    ContiguousLabels,
    ModelPolicy,
    NearestNeighbourImitator,
    Teacher,
    as_policy,
    state_vector_of,
)
from khepera_forage.task.states import Behaviour

X = np.array([[0, 90, 0, 215, 60], [0, 50, 0, 215, 18], [1, 48, 0, 255, 14], [1, 48, 1, 215, 14]] * 3)
Y = np.array([0, 2, 3, 7] * 3)


class Answer:
    """Gives one answer."""

    def __init__(self, answer: Any) -> None:
        self.answer = answer

    def act(self, observation: Any) -> Any:
        return self.answer

    def predict(self, observation: Any, *, deterministic: bool) -> tuple[Any, None]:
        return self.answer, None


def test_learners_become_the_policy_of_their_kind() -> None:
    teacher, imitator = Teacher(), NearestNeighbourImitator().fit(X, Y)
    assert as_policy(teacher) is teacher
    assert as_policy(imitator) is imitator, "the imitator is a policy already"
    assert type(as_policy(GaussianNB().fit(X, Y))) is ClassifierPolicy
    assert type(as_policy(Recurrent())) is ModelPolicy
    assert type(as_policy(Answer(0))) is AgentPolicy


@pytest.mark.parametrize("answer", [2, np.int8(2), np.array(2), np.array([[2]])])
def test_one_whole_number_in_any_form_is_a_behaviour(answer: Any) -> None:
    assert as_policy(Answer(answer)).act(X[0], None) is Behaviour.ORIENT_WITH_FOOD


class Probabilities:
    """A classifier with given probabilities."""

    classes_: Any = np.array([0, 2, 3])

    def __init__(self, *levels: float) -> None:
        self.levels = levels

    def predict_proba(self, rows: Any) -> Any:
        return np.array([self.levels] * len(rows))


@pytest.mark.parametrize(
    "levels", [(np.nan, 0.5, 0.5), (0.5, 0.5, 0.5), (-0.5, 1.0, 0.5), (0.5, 0.5), (0.0, 0.0, 0.0), [1 / 30] * 30]
)
def test_numbers_that_are_no_probabilities_are_refused(levels: tuple[float, ...]) -> None:
    policy = as_policy(Probabilities(*levels))
    with pytest.raises(ValueError, match=r"Probabilities predicts the probabilities .* of the classes .*; allowed"):
        policy.act(X[0], np.random.default_rng(0))


def labelled(labels: Any) -> Probabilities:
    classifier = Probabilities(0.0, 1.0, 0.0)
    classifier.classes_ = labels
    return classifier


@pytest.mark.parametrize("labels", [[0, 2, 3], np.array([0.0, 2.0, 3.0])])
def test_labels_may_be_a_list_or_floats(labels: Any) -> None:
    assert as_policy(labelled(labels)).act(X[0], np.random.default_rng(0)) == 2


class OnlyContiguous(GaussianNB):  # type: ignore[misc]  # scikit-learn is untyped
    """Refuses labels with gaps, as XGBoost does."""

    def fit(self, rows: Any, labels: Any) -> Any:
        if not np.array_equal(np.unique(labels), np.arange(len(np.unique(labels)))):
            raise ValueError("invalid classes")
        return super().fit(rows, labels)


def test_labels_with_gaps_are_learned_by_classifiers_that_know_none() -> None:
    with pytest.raises(ValueError, match="invalid classes"):
        OnlyContiguous().fit(X, Y)
    wrapped, plain = ContiguousLabels(OnlyContiguous()).fit(X, Y), GaussianNB().fit(X, Y)
    assert wrapped.classes_.tolist() == [0, 2, 3, 7]
    np.testing.assert_array_equal(wrapped.predict_proba(X), plain.predict_proba(X))
    np.testing.assert_array_equal(wrapped.predict(X), Y)
    assert [as_policy(wrapped).act(row, np.random.default_rng(1)) for row in X] == Y.tolist()
    with pytest.raises(ValueError, match="ContiguousLabels was fitted on 4 columns"):
        as_policy(ContiguousLabels(OnlyContiguous()).fit(X[:, :4], Y))


# ---------------------------------------------------------------- models, without stable-baselines3

OBSERVATION = (0, 60, 0, 215, 40)


class Model:
    """Notes what it is shown, and returns one behaviour after the other, for a batch of one."""

    def __init__(self, space: spaces.Space[Any] | None = None) -> None:
        self.observation_space = space
        self.shown: list[Any] = []

    def predict(self, observation: Any, *, deterministic: bool) -> tuple[Any, None]:
        self.shown.append(observation)
        return np.array([len(self.shown) % 10]), None


def test_action_holds_for_its_rounds_and_its_generator() -> None:
    policy = ModelPolicy(Model(), hold=3)
    first, second = np.random.default_rng(0), np.random.default_rng(0)
    assert [int(policy.act(OBSERVATION, first)) for _ in range(5)] == [1, 1, 1, 2, 2]
    assert [int(policy.act(OBSERVATION, second)) for _ in range(2)] == [3, 3]
    assert int(policy.act(OBSERVATION, first)) == 4, "another generator means another episode"


class Recurrent:
    """Counts its own steps in its state, as a recurrent model of sb3-contrib carries its memory."""

    def predict(
        self, observation: Any, state: Any = None, episode_start: Any = None, deterministic: bool = False
    ) -> tuple[Any, Any]:
        assert episode_start.shape == (1,)
        count = 0 if episode_start[0] else state[0] + 1
        return np.array([count]), (count,)


def test_recurrent_model_remembers_within_an_episode_and_forgets_after_it() -> None:
    policy = ModelPolicy(Recurrent())
    first, second = np.random.default_rng(0), np.random.default_rng(0)
    assert [int(policy.act(OBSERVATION, first)) for _ in range(4)] == [0, 1, 2, 3]
    assert [int(policy.act(OBSERVATION, second)) for _ in range(3)] == [0, 1, 2]
    assert int(pickle.loads(pickle.dumps(policy)).act(OBSERVATION, second)) == 0
    with pytest.raises(TypeError, match="rng is None; allowed for a recurrent model"):
        policy.act(OBSERVATION)


class Masked:
    """A model like sb3-contrib's MaskablePPO: it prefers the last behaviour that its mask allows."""

    def predict(self, observation: Any, deterministic: bool = False, action_masks: Any = None) -> tuple[Any, None]:
        return np.flatnonzero(action_masks)[-1:], None


def test_masked_model_gets_the_masks_of_the_environment() -> None:
    assert ModelPolicy(Masked()).act((0, 90, 0, 215, 60)) == Behaviour.AVOID_HOME
    assert ModelPolicy(Masked()).act((1, 90, 3, 215, 60)) == Behaviour.RELEASE_FOOD


@pytest.mark.filterwarnings("ignore:.*Box (low|high)'s precision lowered")
@pytest.mark.parametrize("name", ["Corridor", "CorridorWheels"])
def test_model_is_shown_the_observations_that_its_space_has(name: str) -> None:
    env = gym.make(f"khepera_forage/{name}-v1")
    flat = FlattenObservation(env)
    shown, _ = env.reset(seed=3)
    row, _ = flat.reset(seed=3)
    for space, expected in (
        (env.observation_space, shown),
        (flat.observation_space, row),
        (DtypeObservation(flat, np.float32).observation_space, row),
    ):
        model = Model(space)
        as_policy(model).act(shown)
        np.testing.assert_equal(model.shown[0], expected)
    if name == "Corridor":
        as_policy(model).act([*state_vector_of(shown), 10, 0])
        np.testing.assert_equal(model.shown[1], row)


CORRIDOR: Any = FlattenObservation(gym.make("khepera_forage/Corridor-v1"))
AS_FLOATS = DtypeObservation(CORRIDOR, np.float32)


SPACES = (
    RescaleObservation(AS_FLOATS, np.float32(0), np.float32(1)).observation_space,
    *(spaces.Box(-np.inf, np.inf, (9,), np.float32), spaces.Box(0, 138, (9,), np.float32), spaces.Discrete(10)),
    spaces.Dict(arms_height=spaces.Box(215, 255, (1,), np.int64)),
    spaces.Dict({**CORRIDOR.unwrapped.observation_space, "more": spaces.Discrete(2)}),
)
UNDECIDED = (Teacher, GaussianNB, 7, None, LinearSVC().fit(X, Y), lambda observation: 3)
REFUSED: list[tuple[Any, type[Exception], str]] = [
    *((learner, TypeError, r"learner is .*; allowed: an instance with act\(observation\), ") for learner in UNDECIDED),
    *(
        (Model(space), ValueError, r"model was trained on observations .*; allowed: .*ModelPolicy\(")
        for space in SPACES
    ),
    (labelled(np.array(["2", "50"])), ValueError, r"labels learned are \['2', '50'\]; allowed: behaviours, 0 to 10"),
    (GaussianNB(), ValueError, "GaussianNB has no classes_; allowed: a fitted classifier"),
    (GaussianNB().fit(X[:, :4], Y), ValueError, "GaussianNB was fitted on 4 columns; allowed: 5"),
]


@pytest.mark.parametrize(("learner", "error", "message"), REFUSED)
def test_what_cannot_decide_is_refused(learner: Any, error: type[Exception], message: str) -> None:
    with pytest.raises(error, match=message):
        as_policy(learner)
