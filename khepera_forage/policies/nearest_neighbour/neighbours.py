"""The nearest experience vectors of a state vector and their confidence levels (section 4.6.2)."""

from typing import NamedTuple, Protocol, runtime_checkable

import numpy as np

from khepera_forage.policies.nearest_neighbour.votes import draw_label
from khepera_forage.policies.policy import Observation
from khepera_forage.task.states import Behaviour


class Neighbours(NamedTuple):
    """The experience vectors at the minimum distance from a state vector (with a threshold: near it).

    Attributes:
        behaviours: The behaviours heard with them, in increasing order.
        counts: How many of the vectors vote for each of these behaviours, above 0.
        tied: How many vectors vote; equal vectors count one by one.
        distance: The minimum distance of section 4.6.1.
    """

    behaviours: tuple[Behaviour, ...]
    counts: tuple[int, ...]
    tied: int
    distance: float

    @property
    def votes(self) -> tuple[tuple[Behaviour, int], ...]:
        """Each behaviour with the number of its votes."""
        return tuple(zip(self.behaviours, self.counts, strict=True))

    @property
    def tie(self) -> bool:
        """Whether more than one experience vector votes."""
        return self.tied > 1

    @property
    def conflict(self) -> bool:
        """Whether they vote for more than one behaviour."""
        return len(self.behaviours) > 1

    def confidence_levels(self) -> dict[Behaviour, float]:
        """The share of each behaviour in the votes; the shares sum to 1."""
        return {behaviour: count / self.tied for behaviour, count in self.votes}

    def draw(self, rng: np.random.Generator) -> Behaviour:
        """A behaviour, with its confidence level as probability. Draws exactly one number from `rng`."""
        return self.behaviours[draw_label(self.counts, self.tied, rng.random())]


@runtime_checkable
class HasNeighbours(Protocol):
    """A policy that draws its behaviours from the votes of neighbours, such as `NearestNeighbourImitator`."""

    def neighbours(self, observation: Observation) -> Neighbours:
        """The experience vectors that vote on an observation."""
        ...
