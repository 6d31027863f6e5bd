"""What is inferred, as numbers: the decisions and sizes of noise that the prior draws, of many laboratories."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from khepera_forage.thesis.inference.prior import Laboratory, Prior, Range

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Parameter:
    """A field that the prior draws, and its values in some sets.

    Attributes:
        name: Of the field of `Decisions` or `Noise`.
        readings: Its named readings; empty if it is a number.
        values: One a set; a reading is its place among the readings.
    """

    name: str
    readings: tuple[Any, ...]
    values: Floats

    def of(self, sets: NDArray[np.intp]) -> "Parameter":
        """The same in some of the sets."""
        return Parameter(self.name, self.readings, self.values[sets])

    @property
    def indicators(self) -> Floats:
        """Whether a set has a reading, 0 or 1; shape (sets, readings)."""
        return np.asarray(self.values[:, None] == np.arange(len(self.readings)), dtype=np.float64)

    @property
    def targets(self) -> Floats:
        """What a forest predicts, shape (sets, columns): the number, or one column a reading; variance 1 together."""
        columns = self.indicators if self.readings else self.values[:, None]
        variance = columns.var(axis=0).sum()
        return np.asarray(columns / np.sqrt(variance) if variance > 0 else columns)


def parameters_of(prior: Prior, laboratories: Sequence[Laboratory]) -> list[Parameter]:
    """What the prior draws, in the order of the prior.

    Args:
        prior: Says what is drawn.
        laboratories: One a set.
    """
    found = []
    for name, part in (*prior.decisions.items(), *prior.noise.items()):
        readings = () if isinstance(part, Range) else tuple(part.of)
        drawn = [_value_of(laboratory, name) for laboratory in laboratories]
        values = [readings.index(value) for value in drawn] if readings else drawn
        found.append(Parameter(name, readings, np.array(values, dtype=np.float64)))
    return found


def _value_of(laboratory: Laboratory, name: str) -> Any:
    decisions, noise = laboratory
    return getattr(decisions if hasattr(decisions, name) else noise, name)
