"""The learner during training: it executes the behaviour it hears (section 4.5)."""

from dataclasses import dataclass

import numpy as np

from khepera_forage.policies.policy import HEARD, Observation, is_training
from khepera_forage.task.states import Behaviour


@dataclass(frozen=True, slots=True)
class Listener:
    """Executes the behaviour it hears; silence makes it wait."""

    def act(self, observation: Observation, rng: np.random.Generator | None = None) -> Behaviour:
        """The behaviour heard.

        Args:
            observation: Of the training environment: seven integers.
            rng: Not used.

        Raises:
            ValueError: Not an observation of the training environment.
        """
        if not is_training(observation):
            raise ValueError(
                f"observation is {observation!r}; allowed: seven integers of a training environment"
            )
        return Behaviour(int(observation[HEARD]))
