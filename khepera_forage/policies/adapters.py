"""Other learners as policies: scikit-learn's classifiers, and models in the manner of Stable-Baselines3."""

from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from khepera_forage.foraging.states import Behaviour
from khepera_forage.policies.policy import Observation, state_vector_of


class Classifier(Protocol):
    """A fitted scikit-learn classifier of state vectors (`Experience.arrays`)."""

    classes_: NDArray[Any]

    def predict_proba(self, rows: NDArray[np.int64], /) -> NDArray[np.float64]:
        """The probability of each class, one row for each row given."""
        ...


@dataclass(frozen=True, slots=True)
class ClassifierPolicy:
    """Executes what a classifier makes of the state vector.

    Attributes:
        classifier: Fitted on state vectors of five columns and behaviours as numbers.
        sample: Whether a behaviour is drawn with its probability, as with the imitator's confidence levels,
            or the most probable one executed.
    """

    classifier: Classifier
    sample: bool = True

    def act(self, observation: Observation, rng: np.random.Generator | None = None) -> Behaviour:
        """The behaviour drawn, or the most probable one.

        Args:
            observation: What the robot perceives; see `policies.policy.state_vector_of`.
            rng: Must be given if behaviours are drawn: one number is drawn at every call.

        Raises:
            TypeError: A behaviour is to be drawn and `rng` is not a NumPy generator.
            ValueError: The observation holds no state vector, or the label found is not a behaviour.
        """
        row = np.array([state_vector_of(observation)], np.int64)
        levels = self.classifier.predict_proba(row)[0]
        if not self.sample:
            return Behaviour(self.classifier.classes_[levels.argmax()].item())
        if not isinstance(rng, np.random.Generator):
            raise TypeError(f"rng is {rng!r}; allowed: a numpy.random.Generator, to draw behaviours from")
        steps = levels.cumsum()
        drawn = steps.searchsorted(rng.random() * steps[-1], side="right")
        return Behaviour(self.classifier.classes_[drawn].item())


class Model(Protocol):
    """A trained model of Stable-Baselines3 or of its kind."""

    def predict(self, observation: Any, *, deterministic: bool) -> tuple[Any, Any]:
        """The action, and the state of a recurrent model."""
        ...


@dataclass(frozen=True, slots=True)
class ModelPolicy:
    """Executes what a model without memory says; it is shown observations as the environment gives them.

    Attributes:
        model: Trained in an environment with the same observations.
        deterministic: Whether the model takes its most probable action. If not, it draws from its own source
            of chance, which has to be seeded where the model is made.
    """

    model: Model
    deterministic: bool = True

    def act(self, observation: Observation, rng: np.random.Generator | None = None) -> Behaviour:
        """The behaviour that the model says.

        Args:
            observation: What the robot perceives, passed on unchanged.
            rng: Not used.

        Raises:
            ValueError: The model's action is not a behaviour.
        """
        action, _ = self.model.predict(observation, deterministic=self.deterministic)
        return Behaviour(int(action))
