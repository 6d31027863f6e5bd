"""All learners of the package, with their settings and the experience they need.

Benchmarks compare the entries of `LEARNERS`; a new entry adds a row. All settings are here.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from enum import Enum
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from khepera_forage.deprecation import renamed
from khepera_forage.policies.classifiers import boosting, cloning, policy_of, tree
from khepera_forage.policies.growing_memory import GrowingMemory
from khepera_forage.policies.imitator import KNearestImitator, NearestNeighbourImitator, WeightedImitator
from khepera_forage.policies.policy import Policy


class Supervision(Enum):
    """What a learner learns from."""

    VECTORS = "experience vectors"
    """State vectors and what was heard with each, recorded in training (4.5)."""
    QUERIES = "expert queries"
    """The teacher's behaviours for state vectors that the learner meets."""
    STEPS = "environment steps"
    """Rewards of the environment, without a teacher."""


@dataclass(frozen=True, slots=True)
class OfflineImitation:
    """A learner that imitates: it is fitted on experience vectors.

    Attributes:
        title: For tables and figures.
        make: Makes the classifier, not fitted, from `settings` and, if it takes them, `diagonal` and `random_state`.
        settings: Its keyword arguments.
        diagonal: Whether it takes `diagonal`, that of the arena foraged in, in pixels.
        seeded: Whether it takes `random_state`.
        sample: Whether behaviours are drawn with their probabilities, as the thesis's learner does. If not, the most
            probable one is executed.
        grouped: Whether `fit` takes `groups`, the training episode of each vector.
    """

    title: str
    make: Callable[..., Any]
    settings: Mapping[str, Any] = field(default_factory=dict)
    diagonal: bool = False
    seeded: bool = False
    sample: bool = True
    grouped: bool = False
    needs: ClassVar[Supervision] = Supervision.VECTORS

    def classifier(self, diagonal: int = 138, seed: int = 0) -> Any:
        """The classifier, not fitted; arguments as of `learn`.

        Raises:
            ValueError: It cannot be fitted.
        """
        more = {"diagonal": diagonal} if self.diagonal else {}
        if self.seeded:
            more["random_state"] = seed
        made = self.make(**self.settings, **more)
        if not callable(getattr(made, "fit", None)):
            raise ValueError(f"{self.title} makes {made!r}; allowed: a classifier with fit and predict_proba")
        return made

    def fitted(
        self,
        vectors: NDArray[np.int64],
        behaviours: NDArray[np.int64],
        diagonal: int = 138,
        seed: int = 0,
        groups: NDArray[np.int64] | None = None,
    ) -> Any:
        """The classifier, fitted; arguments and errors as of `learn`."""
        classifier = self.classifier(diagonal, seed)
        classifier.fit(vectors, behaviours, **({"groups": groups} if self.grouped else {}))
        return classifier

    def learn(
        self,
        vectors: NDArray[np.int64],
        behaviours: NDArray[np.int64],
        diagonal: int = 138,
        seed: int = 0,
        groups: NDArray[np.int64] | None = None,
    ) -> Policy:
        """A policy that has learned from experience vectors, and learns no further.

        Args:
            vectors: Of shape (n, 5).
            behaviours: Of shape (n,).
            diagonal: Of the arena that will be foraged in, in pixels.
            seed: Seed of the learner's random choices, if it makes any; the same seed gives the same policy.
            groups: The training episode of each vector, of shape (n,), for learners that use it.

        Raises:
            ValueError: It is no classifier with `fit`, `predict_proba` and `classes_`.
        """
        classifier = self.fitted(vectors, behaviours, diagonal, seed, groups)
        if isinstance(classifier, NearestNeighbourImitator):
            return classifier
        return policy_of(classifier, self.sample)


@dataclass(frozen=True, slots=True)
class InteractiveImitation:
    """A learner that queries the teacher about the state vectors it meets; `rollouts.dagger` trains it.

    Attributes:
        title: For tables and figures.
        learner: Fitted on all queries so far.
        settings: Keyword arguments of `rollouts.dagger.dagger`.
    """

    title: str
    learner: OfflineImitation
    settings: Mapping[str, Any]
    needs: ClassVar[Supervision] = Supervision.QUERIES


@dataclass(frozen=True, slots=True)
class ReinforcementLearner:
    """A reinforcement learner of stable-baselines3; `rollouts.reinforcement` trains it.

    Attributes:
        title: For tables and figures.
        algorithm: Name of the class in stable-baselines3.
        wheels: Whether its actions are motors (`CorridorWheels-v1`) and not behaviours.
        settings: Keyword arguments of the algorithm.
        sample: Whether actions are drawn with their probabilities also in recall (PPO only).
        worlds: Number of compiled environments it trains in.
        hold: Rounds that an action holds, in training and in recall.
    """

    title: str
    algorithm: str
    wheels: bool
    settings: Mapping[str, Any]
    sample: bool = False
    worlds: int = 8
    hold: int = 1
    needs: ClassVar[Supervision] = Supervision.STEPS


Learner = OfflineImitation | InteractiveImitation | ReinforcementLearner

_CLONING = OfflineImitation(
    "behavioural cloning",
    cloning,
    {"hidden_layer_sizes": (32, 32), "learning_rate_init": 0.005, "max_iter": 3_000},
    seeded=True,
)

LEARNERS: dict[str, Learner] = {
    "imitator": OfflineImitation("the thesis's imitator", NearestNeighbourImitator, diagonal=True),
    "k_nearest": OfflineImitation("5 nearest", KNearestImitator, {"k": 5}, diagonal=True),
    "distance_weighted": OfflineImitation(
        "5 nearest, by distance", KNearestImitator, {"k": 5, "weighting": "distance"}, diagonal=True
    ),
    "attribute_weights": OfflineImitation(
        "learned weights", WeightedImitator, diagonal=True, seeded=True, grouped=True
    ),
    "growing_memory": OfflineImitation("growing memory", GrowingMemory, diagonal=True),
    "tree": OfflineImitation("decision tree", tree, seeded=True),
    "boosting": OfflineImitation("gradient boosting", boosting, {"n_estimators": 50, "max_depth": 3}, seeded=True),
    "cloning": _CLONING,
    "dagger": InteractiveImitation("DAgger", _CLONING, {"queries_a_round": 100}),
    "dagger_tree": InteractiveImitation(
        "DAgger, tree", OfflineImitation("decision tree", tree, seeded=True), {"queries_a_round": 100}
    ),
    # Reinforcement learners. Their settings were found in twelve trainings in the compiled corridor, with seed 0 and at
    # most five minutes on one core each, by the share of food delivered; the rectangle and pymunk were not used. `hold`
    # matters most: a policy that draws a random behaviour in every round delivers in 0.1 % of the episodes, one that
    # draws every 5 rounds in 13 %. Next come few worlds, which means more updates for the same number of steps: PPO
    # with 64 worlds needed 0.5 million steps where it needed 2 million with 1,024.
    "ppo": ReinforcementLearner(
        "PPO on behaviours",
        "PPO",
        wheels=False,
        settings={
            "n_steps": 64,
            "batch_size": 512,
            "n_epochs": 4,
            "gamma": 0.98,
            "ent_coef": 0.01,
            "learning_rate": 1e-3,
        },
        sample=True,
        worlds=64,
        hold=5,
    ),
    "dqn": ReinforcementLearner(
        "DQN on behaviours",
        "DQN",
        wheels=False,
        settings={
            "batch_size": 256,
            "train_freq": 1,
            "gamma": 0.98,
            "learning_rate": 1e-3,
            "learning_starts": 5_000,
            "buffer_size": 500_000,
            "exploration_fraction": 0.2,
            "target_update_interval": 2_000,
        },
        worlds=16,
        hold=5,
    ),
    "ppo_wheels": ReinforcementLearner(
        "PPO on wheels",
        "PPO",
        wheels=True,
        settings={
            "n_steps": 128,
            "batch_size": 1_024,
            "n_epochs": 8,
            "gamma": 0.98,
            "ent_coef": 0.0,
            "learning_rate": 5e-4,
        },
        sample=True,
        worlds=64,
        hold=5,
    ),
    "sac_wheels": ReinforcementLearner(
        "SAC on wheels",
        "SAC",
        wheels=True,
        settings={
            "batch_size": 256,
            "train_freq": 1,
            "gamma": 0.98,
            "ent_coef": "auto_0.05",
            "learning_rate": 1e-3,
            "learning_starts": 10_000,
            "buffer_size": 500_000,
            "policy_kwargs": {"net_arch": [128, 128]},
        },
        worlds=32,
        hold=5,
    ),
}
"""All learners by name."""


_RENAMED = {
    "Needs": Supervision,
    "FromVectors": OfflineImitation,
    "FromQueries": InteractiveImitation,
    "FromSteps": ReinforcementLearner,
}


def __getattr__(name: str) -> Any:
    """Former names."""
    return renamed(__name__, name, _RENAMED)
