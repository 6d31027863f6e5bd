"""Rounds on a disturbed line: late and garbled replies."""

import time
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from khepera_forage.estimates import Column, Table, pick, quantiles
from khepera_forage.robots.khepera import MAX_SPEED, Motors, RobotLost
from khepera_forage.robots.serial.serial_khepera import SerialKhepera
from khepera_forage.robots.virtual.faults import Faults
from serial_lines.latency import BAUD
from serial_lines.virtual_fleet import virtual_fleet

DISTURBANCES = {
    "none": Faults(),
    "20 % late by 0.2 to 0.6 s": Faults(delay=0.2, lateness=(0.2, 0.6)),
    "20 % garbled": Faults(garble=0.2),
    "5 % lost": Faults(drop=0.05),
}
_NOTE = (
    f"One robot at {BAUD} baud with random speeds of its wheels in every round. A round: `transmit` and `receive`, "
    "median [5th, 95th percentile], and the longest. Undetectable: garbled replies that are well-formed replies to the "
    "same request. Counters wrong: rounds in which a wheel's counter differed from the true one; error at the end: "
    "after the last round, which is undisturbed. Unknown: readings that "
    "could not be confirmed. Lost: rounds that ended with `RobotLost`."
)


@dataclass(frozen=True, slots=True)
class DisturbedRound:
    """One round.

    Attributes:
        disturbance: A key of `DISTURBANCES`.
        number: Of the round, from 0.
        taken: Milliseconds of `transmit` and `receive`.
        error: Pulses by which the worse counter differs from the truth; 0 after a loss.
        undetectable: Garbled replies so far that are well-formed.
        unknown: Readings so far that could not be confirmed.
        lost: Whether the robot counted as lost.
    """

    disturbance: str
    number: int
    taken: float
    error: int
    undetectable: int
    unknown: int
    lost: bool


class DisturbedLine(NamedTuple):
    """A robot on a disturbed line.

    Attributes:
        disturbance: A key of `DISTURBANCES`.
        rounds: How many.
        seed: Of the world, the speeds and the faults.
    """

    disturbance: str
    rounds: int
    seed: int

    @property
    def key(self) -> str:
        """The disturbance."""
        return f"disturbance {self.disturbance}"

    def run(self) -> list[DisturbedRound]:
        """Measure every round."""
        wheels = (
            np.random.default_rng(self.seed).integers(-MAX_SPEED, MAX_SPEED + 1, (self.rounds, 2)).tolist()
        )
        rows = []
        with (
            virtual_fleet(BAUD, 1, self.seed) as (ports, advance, truth),
            SerialKhepera(ports[0].url, baud=BAUD) as robot,
        ):
            robot.receive()
            for number, (left, right) in enumerate(wheels):
                # The last round is undisturbed: it shows what remains.
                is_last = number == len(wheels) - 1
                ports[0].faults = Faults() if is_last else DISTURBANCES[self.disturbance]
                lost, error = False, 0
                robot.drive(Motors(left, right, 215, 200))
                begin = time.perf_counter()
                try:
                    robot.transmit()
                    taken = time.perf_counter() - begin
                    advance()
                    begin = time.perf_counter()
                    robot.receive()
                    taken += time.perf_counter() - begin
                    read, true = robot.sense(), truth()
                    error = max(
                        abs(read.left_pulses - true.left_pulses), abs(read.right_pulses - true.right_pulses)
                    )
                except RobotLost:
                    taken, lost = time.perf_counter() - begin, True
                undetectable, unknown = ports[0].fault_counts.undetectable, robot.statistics.unknown
                row = DisturbedRound(
                    self.disturbance, number, 1000 * taken, error, undetectable, unknown, lost
                )
                rows.append(row)
            ports[0].faults = Faults()
        return rows


def disturbance_table(rows: Sequence[DisturbedRound]) -> Table:
    """Rounds and errors by disturbance."""
    columns = (
        Column("replies"),
        Column("rounds"),
        Column("a round (ms)", digits=0, estimate=True),
        Column("longest (ms)", digits=0),
        Column("undetectable"),
        Column("counters wrong (rounds)"),
        Column("counter error at the end (pulses)"),
        Column("unknown"),
        Column("lost"),
    )
    lines = []
    for disturbance in DISTURBANCES:
        own = pick(rows, disturbance=disturbance)
        if own:
            taken = [row.taken for row in own]
            line = (
                disturbance,
                len(own),
                quantiles(taken),
                max(taken),
                own[-1].undetectable,
                sum(row.error > 0 for row in own[:-1]),
                own[-1].error,
                own[-1].unknown,
                sum(row.lost for row in own),
            )
            lines.append(line)
    return Table("disturbances", "Disturbed lines", _NOTE, columns, lines)
