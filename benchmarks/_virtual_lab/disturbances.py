"""Sums over the attempts on lines with one fault at one rate."""

from collections.abc import Sequence
from dataclasses import dataclass, fields

from _virtual_lab.faults import NOTHING, RATES, DisturbedRow
from khepera_forage.robots.virtual.faults import FAULTS


@dataclass(frozen=True, slots=True)
class Disturbance:
    """All attempts with one fault at one rate; the fields are those of `DisturbedRow`, summed.

    Attributes:
        losses: Attempts that ended with a robot lost.
        losses_kept: Of these, those whose experience is on disk.
        forgotten: Experience vectors of attempts that are not on disk.
        longest: Seconds of the longest round.
    """

    fault: str
    rate: float
    rounds: int
    replies: int
    faults: int
    unseen: int
    disturbed: int
    recovered: int
    halted: int
    misread: int
    miscounted: int
    moving: int
    vectors: int
    stored: int
    forgotten: int
    altered: int
    wrong: int
    seconds: float
    longest: float
    losses: int
    losses_kept: int


def disturbances(rows: Sequence[DisturbedRow]) -> list[Disturbance]:
    """One a fault and rate, the undisturbed one first."""
    conditions = [(NOTHING, 0.0), *((fault, rate) for fault in FAULTS for rate in RATES)]
    return [
        _summed(fault, rate, [row for row in rows if (row.fault, row.rate) == (fault, rate)])
        for fault, rate in conditions
    ]


def _summed(fault: str, rate: float, rows: Sequence[DisturbedRow]) -> Disturbance:
    names = {field.name for field in fields(DisturbedRow)} & {field.name for field in fields(Disturbance)}
    sums = {name: sum(getattr(row, name) for row in rows) for name in names - {"fault", "rate", "longest"}}
    lost = [row for row in rows if row.lost]
    return Disturbance(
        fault=fault,
        rate=rate,
        longest=max(row.longest for row in rows),
        forgotten=sum(row.vectors for row in rows if not row.kept),
        losses=len(lost),
        losses_kept=sum(row.kept for row in lost),
        **sums,
    )
