"""Sums over the attempts on lines with one fault at one rate."""

from collections.abc import Sequence
from typing import Any, NamedTuple

from khepera_forage.estimates import pick
from khepera_forage.robots.virtual.faults import FAULTS
from lab_comparison.faults import NO_FAULT, RATES, DisturbedAttempt


class FaultSums(NamedTuple):
    """All attempts with one fault at one rate.

    Attributes:
        fault: Which, or `NO_FAULT`.
        rate: Of the fault.
        attempts: Their rows.
    """

    fault: str
    rate: float
    attempts: Sequence[DisturbedAttempt]

    def sum(self, name: str) -> Any:
        """The sum of a field."""
        return sum(getattr(row, name) for row in self.attempts)

    @property
    def lost(self) -> list[DisturbedAttempt]:
        """Attempts that ended with a robot lost."""
        return [row for row in self.attempts if row.lost]

    @property
    def ms_a_round(self) -> float:
        """Mean time of a round in ms."""
        return float(1000 * self.sum("seconds") / self.sum("rounds"))

    @property
    def forgotten(self) -> int:
        """Experience vectors of attempts that are not on disk."""
        return sum(row.vectors for row in self.attempts if not row.kept)


def fault_sums(rows: Sequence[DisturbedAttempt]) -> list[FaultSums]:
    """One a fault and rate, the undisturbed one first."""
    conditions = [(NO_FAULT, 0.0), *((fault, rate) for fault in FAULTS for rate in RATES)]
    return [FaultSums(fault, rate, pick(rows, fault=fault, rate=rate)) for fault, rate in conditions]
