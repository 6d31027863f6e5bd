"""Other learners as policies: classifiers of scikit-learn, models of stable-baselines3, and objects with `act`."""

import copy
import inspect
from dataclasses import dataclass, field
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from khepera_forage.policies.distance import STATE_WIDTH
from khepera_forage.policies.model_observations import training_of
from khepera_forage.policies.model_policy import ModelPolicy
from khepera_forage.policies.policy import Observation, Policy, state_vector_of
from khepera_forage.task.states import Behaviour, StateVector, behaviour_number

CACHE_SIZE = 32768
"""State vectors whose probabilities are cached."""
TOLERANCE = 1e-3
"""How much the sum of probabilities may differ from 1: learners with 32-bit floats round."""


class Classifier(Protocol):
    """A fitted scikit-learn classifier of state vectors (`Experience.arrays`)."""

    classes_: NDArray[Any]

    def predict_proba(self, rows: NDArray[np.int64], /) -> NDArray[np.float64]:
        """The probability of each class, one row for each row given."""
        ...


@dataclass(frozen=True, slots=True)
class ClassifierPolicy:
    """Executes the behaviour that a classifier predicts from the state vector.

    Attributes:
        classifier: Fitted on state vectors of five columns and behaviours as numbers.
        sample: Whether a behaviour is drawn with its probability, like the imitator's with its confidence level.
            If not, the most probable behaviour is executed.
        remember: Whether probabilities are cached by state vector, which makes decisions ten to a thousand times as
            fast. Only for a classifier that learns no further.
    """

    classifier: Classifier
    sample: bool = True
    remember: bool = False
    _cache: dict[StateVector, NDArray[np.float64]] = field(
        default_factory=dict, init=False, repr=False, compare=False
    )

    def act(self, observation: Observation, rng: np.random.Generator | None = None) -> Behaviour:
        """The behaviour drawn, or the most probable one.

        Args:
            observation: What the robot perceives; see `policies.policy.state_vector_of`.
            rng: Must be given with `sample`: one number is drawn at every call.

        Raises:
            TypeError: A behaviour is to be drawn and `rng` is not a NumPy generator.
            ValueError: The observation holds no state vector, the classifier's probabilities are none, or the label
                found is not a behaviour.
        """
        levels = self._levels(state_vector_of(observation))
        if not self.sample:
            return Behaviour(self.classifier.classes_[levels.argmax()].item())
        if not isinstance(rng, np.random.Generator):
            raise TypeError(f"rng is {rng!r}; allowed: a numpy.random.Generator, to draw behaviours from")
        steps = levels.cumsum()
        drawn = steps.searchsorted(rng.random() * steps[-1], side="right")
        return Behaviour(self.classifier.classes_[drawn].item())

    def _levels(self, vector: StateVector) -> NDArray[np.float64]:
        if not self.remember:
            return self._predicted(vector)
        levels = self._cache.get(vector)
        if levels is None:
            if len(self._cache) >= CACHE_SIZE:
                self._cache.clear()
            levels = self._cache[vector] = self._predicted(vector)
        return levels

    def _predicted(self, vector: StateVector) -> NDArray[np.float64]:
        classes = self.classifier.classes_
        if len(classes) == 1:  # for which scikit-learn's networks predict two probabilities
            return np.ones(1)
        levels = np.asarray(self.classifier.predict_proba(np.array([vector], np.int64)))[0]
        fine = levels.shape == np.shape(classes) and np.all(levels >= 0.0)  # NaN fails the comparison
        if not fine or abs(levels.sum() - 1.0) > TOLERANCE:
            raise ValueError(
                f"{type(self.classifier).__name__} predicts the probabilities {levels} of the classes {classes}; "
                "allowed: one for each class, none negative, with the sum 1"
            )
        probabilities: NDArray[np.float64] = levels.astype(np.float64, copy=False)
        return probabilities


class Agent(Protocol):
    """An object that decides by the observation alone."""

    def act(self, observation: Observation, /) -> Any:
        """The behaviour to execute now, as its number in table 4.1."""
        ...


@dataclass(frozen=True, slots=True)
class AgentPolicy:
    """Executes the behaviours of an agent that takes no `rng`.

    Attributes:
        agent: It gets the observations as the environment gives them.
    """

    agent: Agent

    def act(self, observation: Observation, rng: np.random.Generator | None = None) -> Behaviour:
        """The agent's behaviour.

        Args:
            observation: What the robot perceives, passed on unchanged.
            rng: Not used: the agent has no argument for it.

        Raises:
            ValueError: The agent's action is not a behaviour.
        """
        return Behaviour(behaviour_number(self.agent.act(observation), who=type(self.agent).__name__))


def as_policy(learner: Any) -> Policy:
    """A policy made of any learner that can decide.

    Args:
        learner: One of these, the first that fits: something with `act(observation, rng)`, which is a policy
            already; with `act(observation)`; a fitted classifier with `predict_proba`, whose behaviours are drawn
            with their probabilities (the policy copies the classifier, so that later learning does not change it); a
            trained model with `predict(observation, deterministic=...)`, which is shown what it was trained on, and
            whose actions hold as long as in training. For other choices make `ClassifierPolicy` or `ModelPolicy`
            yourself.

    Raises:
        TypeError: The learner is none of these, or a class where an instance is needed.
        ValueError: A classifier has no `classes_` or was not fitted on five columns; or it is not known how a model
            was trained.
    """
    if not isinstance(learner, type):
        if callable(getattr(learner, "act", None)):
            return learner if _takes(learner.act, 2) else AgentPolicy(learner)
        if callable(getattr(learner, "predict_proba", None)):
            check_classifier(learner)
            return ClassifierPolicy(copy.deepcopy(learner), remember=True)
        predict = getattr(learner, "predict", None)
        if callable(predict) and "deterministic" in inspect.signature(predict).parameters:
            return ModelPolicy(learner, *training_of(learner))
    raise TypeError(
        f"learner is {learner!r}; allowed: an instance with act(observation), act(observation, rng), "
        "predict_proba(rows) or predict(observation, deterministic=...)"
    )


def check_classifier(learner: Any) -> None:
    """Check that a fitted classifier has probabilities, says what their columns are, and knows state vectors.

    Raises:
        ValueError: It does not.
    """
    kind = type(learner).__name__
    if not callable(getattr(learner, "predict_proba", None)):
        raise ValueError(
            f"{kind} has no predict_proba; allowed: a classifier that gives each behaviour a probability"
        )
    if not hasattr(learner, "classes_"):
        raise ValueError(
            f"{kind} has no classes_; allowed: a fitted classifier, whose classes_ are the behaviours that the columns "
            "of predict_proba stand for"
        )
    columns = getattr(learner, "n_features_in_", STATE_WIDTH)
    if columns != STATE_WIDTH:
        raise ValueError(f"{kind} was fitted on {columns} columns; allowed: {STATE_WIDTH}, state vectors")


def _takes(method: Any, count: int) -> bool:
    """Whether a method can be called with that many arguments in a row."""
    try:
        inspect.signature(method).bind(*range(count))
    except TypeError:
        return False
    return True
