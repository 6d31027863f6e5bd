"""The random baseline: every behaviour equally likely."""

from dataclasses import dataclass

import numpy as np

from khepera_forage.policies.policy import Observation
from khepera_forage.task.states import Behaviour


@dataclass(frozen=True, slots=True)
class UniformPolicy:
    """Draws one of the ten behaviours and ignores the observation."""

    def act(self, observation: Observation, rng: np.random.Generator | None = None) -> Behaviour:
        """A random behaviour.

        Args:
            observation: Not used.
            rng: Must be given: one number is drawn at every call.

        Raises:
            TypeError: `rng` is not a NumPy generator.
        """
        if not isinstance(rng, np.random.Generator):
            raise TypeError(f"rng is {rng!r}; allowed: a numpy.random.Generator to draw behaviours from")
        return Behaviour(int(rng.integers(Behaviour.WAIT)))
