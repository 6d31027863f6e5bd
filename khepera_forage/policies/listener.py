"""The learner in training: it does what it hears (section 4.5)."""

from dataclasses import dataclass

import numpy as np

from khepera_forage.foraging.states import Behaviour
from khepera_forage.policies.policy import Observation

HEARD, SEPARATED = 5, 6
"""Where a training observation has what is heard and whether robots are separated."""


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
        if isinstance(observation, dict) or len(observation) != SEPARATED + 1:
            raise ValueError(
                f"observation is {observation!r}; allowed: seven integers of a training environment"
            )
        return Behaviour(int(observation[HEARD]))
