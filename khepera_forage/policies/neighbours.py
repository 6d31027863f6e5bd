"""The nearest experience vectors and what they say: confidence levels (section 4.6.2)."""

from typing import NamedTuple

import numpy as np

from khepera_forage.task.states import Behaviour


class Neighbours(NamedTuple):
    """The experience vectors at the minimum distance from a state vector (with a threshold: near it).

    Attributes:
        votes: The behaviours they vote for, each with the number of its votes, which is above 0.
        tied: How many vectors vote; equal vectors count one by one.
        distance: The minimum distance, in the measure of section 4.6.1.
    """

    votes: tuple[tuple[Behaviour, int], ...]
    tied: int
    distance: float

    @property
    def tie(self) -> bool:
        """Whether more than one experience vector votes."""
        return self.tied > 1

    @property
    def conflict(self) -> bool:
        """Whether they vote for more than one behaviour."""
        return len(self.votes) > 1

    def confidence_levels(self) -> dict[Behaviour, float]:
        """The share of each behaviour in the votes; they sum to 1."""
        return {behaviour: count / self.tied for behaviour, count in self.votes}

    def draw(self, rng: np.random.Generator) -> Behaviour:
        """A behaviour, with its confidence level as probability. Takes one number from `rng`, always."""
        left = rng.random() * self.tied
        for behaviour, count in self.votes:  # noqa: B007 - the last one looked at is the one drawn
            left -= count
            if left < 0:
                break
        return behaviour
