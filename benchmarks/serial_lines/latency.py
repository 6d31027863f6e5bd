"""Rounds on a line with a constant latency."""

import math
import time
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

from khepera_forage.estimates import UNKNOWN, Column, Table, pick, quantiles
from khepera_forage.lab.clock import WallClock
from khepera_forage.robots.khepera import ARM_DOWN, ARM_RAISED, JAW_CLOSED, JAW_OPEN, Motors
from khepera_forage.robots.serial.line_timing import LineTooSlow
from khepera_forage.robots.serial.serial_khepera import SerialKhepera
from khepera_forage.robots.virtual.faults import Faults
from serial_lines.virtual_fleet import TIMING, virtual_fleet

LATENCIES = (0, 5, 16, 40, 80, 100, 200, 300, 1000)
"""Milliseconds: 16 is that of a USB adapter with the usual setting; 100 and more do not allow a period of 0.1 s."""
BAUD = 38400
_GRIPPER_PERIOD = 5
"""Rounds from one movement of the gripper to the next."""
_NOTE = (
    f"One robot at {BAUD} baud; wheels and gripper move. Opening: until the line is measured and accepted or rejected. "
    "Periods begin at a fixed rate. At the beginning of a period, the readings are requested; when they have arrived, "
    "the next commands are sent. From the beginning of the period: until these are sent; bound: the period and one "
    "latency. Between rounds: from the arrival of a round's readings to that of the next round's; bound: the period, "
    "and the latency or the time that the transmission of two rounds can differ, whichever is longer. Median [5th, "
    "95th percentile], and the longest."
)


@dataclass(frozen=True, slots=True)
class SlowRound:
    """One round.

    Attributes:
        latency: Of the line, in ms.
        opening: Milliseconds that opening took.
        pipelined: Whether requests are pipelined.
        number: Of the round, from 0; -1 for a line that was rejected.
        exchanged: Milliseconds from the beginning of the period to the end of its exchange; 0 for a rejected line.
        latest: Milliseconds that these may be.
        taken: Milliseconds from the arrival of the last round's readings to that of this one's; 0 for a rejected line.
        bound: Milliseconds that these may be.
    """

    latency: int
    opening: float
    pipelined: bool
    number: int
    exchanged: float
    latest: float
    taken: float
    bound: float


class SlowLine(NamedTuple):
    """A robot on a line with a constant latency.

    Attributes:
        latency: In ms.
        rounds: How many.
        seed: Of the world.
    """

    latency: int
    rounds: int
    seed: int

    @property
    def key(self) -> str:
        """The latency."""
        return f"latency {self.latency} ms"

    def run(self) -> list[SlowRound]:
        """Measure every round."""
        seconds = self.latency / 1000
        late = Faults(delay=1.0 if self.latency else 0.0, lateness=(seconds, seconds))
        with virtual_fleet(BAUD, 1, self.seed) as (ports, advance, _):
            ports[0].faults = late
            begin = time.perf_counter()
            try:
                robot = SerialKhepera(ports[0].url, baud=BAUD, period=TIMING.round_duration)
            except LineTooSlow:
                opening = 1000 * (time.perf_counter() - begin)
                return [SlowRound(self.latency, opening, False, -1, 0.0, 0.0, 0.0, 0.0)]
            opening = 1000 * (time.perf_counter() - begin)
            timing = robot.timing._replace(latency=seconds)
            latest, bound = (
                1000 * limit(TIMING.round_duration) for limit in (timing.latest_end, timing.longest_round)
            )
            rows = []
            with robot:
                robot.receive()  # as at the reset of a laboratory: all readings, twice
                clock = WallClock(TIMING.round_duration, time.perf_counter)
                _command(robot, -1)
                end = clock.beginning
                # Round -1 gives the moment from which the next one is measured.
                for number in range(-1, self.rounds):
                    clock.wait()
                    # A long delay shortens the next period, which then begins at once.
                    beginning = min(clock.beginning, time.perf_counter())
                    advance()  # by a whole round, after the command has arrived
                    robot.receive()
                    taken = time.perf_counter() - end
                    end += taken
                    _command(robot, number + 1)
                    exchanged = time.perf_counter() - beginning
                    if number >= 0:
                        times = (1000 * exchanged, latest, 1000 * taken, bound)
                        pipelined = robot.timing.pipelined
                        rows.append(SlowRound(self.latency, opening, pipelined, number, *times))
                ports[0].faults = Faults()
        return rows


def _command(robot: SerialKhepera, number: int) -> None:
    """Send the commands of a round."""
    down = number // _GRIPPER_PERIOD % 2
    robot.drive(Motors(5, number % 9, *((ARM_DOWN, JAW_CLOSED) if down else (ARM_RAISED, JAW_OPEN))))
    robot.transmit()


def latency_table(rows: Sequence[SlowRound]) -> Table:
    """Opening and rounds by latency."""
    columns = (
        Column("latency (ms)"),
        Column("opening (ms)", digits=0),
        Column("requests"),
        Column("from the beginning of the period (ms)", digits=0, estimate=True),
        Column("longest (ms)", digits=0),
        Column("bound: period + latency (ms)", digits=0),
        Column("between rounds (ms)", digits=0, estimate=True),
        Column("longest time between (ms)", digits=0),
        Column("bound (ms)", digits=0),
    )
    lines = []
    for latency in LATENCIES:
        own = pick(rows, latency=latency)
        if not own:
            continue
        if own[0].number < 0:
            lines.append((latency, own[0].opening, "rejected", *(2 * (UNKNOWN, math.nan, math.nan))))
            continue
        requests = "pipelined" if own[0].pipelined else "one by one"
        exchanged, taken = [row.exchanged for row in own], [row.taken for row in own]
        lines.append(
            (
                latency,
                own[0].opening,
                requests,
                *(quantiles(exchanged), max(exchanged), own[0].latest),
                *(quantiles(taken), max(taken), own[0].bound),
            )
        )
    return Table("latency", "Lines with a latency", _NOTE, columns, lines)
