"""Serial lines: time of a round by baud rate, robots, latency and disturbance; and stopping when a process ends.

    python benchmarks/wire.py --help

Real drivers and virtual Kheperas exchange real bytes over pseudo-terminals, at the pace of the baud rate.
"""

import math
import sys
import time
from collections.abc import Sequence
from contextlib import closing
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from serial_lines.disturbances import DISTURBANCES, DisturbedLine, DisturbedRound, disturbance_table
from serial_lines.endings import ENDINGS, End, Ending, ending_table
from serial_lines.latency import LATENCIES, SlowLine, SlowRound, latency_table
from serial_lines.virtual_fleet import DECISIONS, TIMING, virtual_fleet

from khepera_forage.estimates import Column, Estimate, Table, extremes, pick, quantiles
from khepera_forage.figures import GREY, OURS, THESIS, WIDTH, legend, new_figure
from khepera_forage.robots.fleet import Fleet
from khepera_forage.robots.khepera import ARM_DOWN, ARM_RAISED, JAW_CLOSED, JAW_OPEN, Motors
from khepera_forage.robots.serial.khepera_protocol import BAUD_RATES
from khepera_forage.robots.serial.line import Traffic
from khepera_forage.robots.serial.protocol import seconds_on_wire
from khepera_forage.robots.serial.serial_khepera import SerialKhepera
from khepera_forage.study import Count, Page, Picture, Rows, collect, finish, parse

if TYPE_CHECKING:
    from matplotlib.figure import Figure

FLEETS = (1, 2, 4, 8)
"""Numbers of robots."""
FLEET_BAUD = 38400
PERIOD_MS = 1000 * TIMING.round_duration
_MOVEMENT_PERIOD = 2 * math.ceil(DECISIONS.arm_travel_time / TIMING.round_duration)
"""Rounds from one movement of the gripper to the next: in half of the rounds, the arm moves."""
_WARM_UP = 12
"""Rounds that are not counted: first readings are requested twice, and the gripper comes to rest."""
_KINDS = {False: "gripper rests", True: "gripper moves, or its position is read"}
_LINE_NOTE = (
    "One robot. The bytes are those that the driver and a virtual Khepera exchange while the robot drives about and "
    f"moves its gripper, whose arm takes {DECISIONS.arm_travel_time:g} s; a byte takes 11 bits. Bytes and "
    "time on the wire: median [lowest, highest]. Measured: `transmit` and `receive` with a virtual Khepera at the pace "
    "of the baud rate, without the time of the simulation; median [5th, 95th percentile]. Rounds in which the driver "
    "reads an unexpected value a second time are included."
)
_FLEET_NOTE = (
    f"All at {FLEET_BAUD} baud, each robot on a port of its own, virtual Kheperas and drivers on one computer. Median "
    "[5th, 95th percentile] of the rounds in which the first robot's gripper rests."
)


@dataclass(frozen=True, slots=True)
class Round:
    """One round.

    Attributes:
        baud: Of the lines.
        robots: How many took part.
        number: Of the round, from 0.
        gripper: Whether arm or jaw was commanded, or its position was read.
        sent: Bytes to the first robot.
        received: Bytes from the first robot.
        wire: Milliseconds that these bytes take on the line.
        taken: Milliseconds of `transmit` and `receive` of all robots.
    """

    baud: int
    robots: int
    number: int
    gripper: bool
    sent: int
    received: int
    wire: float
    taken: float


class Drive(NamedTuple):
    """Robots that drive about and now and then move the gripper; all drives have the same commands.

    Attributes:
        baud: Of the lines.
        robots: How many.
        rounds: How many.
        seed: Of the wheel commands.
    """

    baud: int
    robots: int
    rounds: int
    seed: int

    @property
    def key(self) -> str:
        """Baud rate and number of robots."""
        return f"{self.baud} baud, robots: {self.robots}"

    def run(self) -> list[Round]:
        """Measure every round."""
        wheels = np.random.default_rng(self.seed).integers(-12, 13, (self.rounds + _WARM_UP, 2)).tolist()
        rows = []
        with (
            virtual_fleet(self.baud, self.robots, self.seed) as (ports, advance, _),
            closing(SerialKhepera(ports[0].url, baud=self.baud)) as first,
            Fleet([first, *(SerialKhepera(port.url, baud=self.baud) for port in ports[1:])]) as fleet,
        ):
            heard: list[Traffic] = []
            first.on_traffic(heard.append)
            for number, (left, right) in enumerate(wheels, -_WARM_UP):
                down = number >= 0 and (number // _MOVEMENT_PERIOD) % 2
                arm, jaw = (ARM_DOWN, JAW_CLOSED) if down else (ARM_RAISED, JAW_OPEN)
                for robot in fleet.robots:
                    robot.drive(Motors(left, right, arm, jaw))
                heard.clear()
                begin = time.perf_counter()
                fleet.transmit()
                taken = time.perf_counter() - begin
                advance()
                begin = time.perf_counter()
                fleet.receive()
                taken += time.perf_counter() - begin
                if number >= 0:
                    rows.append(self._row(number, heard, taken))
        return rows

    def _row(self, number: int, heard: Sequence[Traffic], taken: float) -> Round:
        sent = b"".join(traffic.data for traffic in heard if traffic.sent)
        received = sum(len(traffic.data) for traffic in heard if not traffic.sent)
        gripper = any(command in sent for command in (b"T,1,D", b"T,1,E", b"T,1,H"))
        wire = 1000 * seconds_on_wire(len(sent) + received, self.baud)
        return Round(self.baud, self.robots, number, gripper, len(sent), received, wire, 1000 * taken)


def drives(rounds: int, seed: int) -> list[Drive]:
    """One robot at every baud rate, then more robots at one rate."""
    alone = [Drive(baud, 1, rounds, seed) for baud in BAUD_RATES]
    return alone + [Drive(FLEET_BAUD, robots, rounds, seed) for robots in FLEETS if robots > 1]


def lines(rounds: int, seed: int) -> list[SlowLine | DisturbedLine | Ending]:
    """Slow and disturbed lines, and ends of a process."""
    slow = [SlowLine(latency, max(10, rounds // 4), seed) for latency in LATENCIES]
    disturbed = [DisturbedLine(disturbance, rounds, seed) for disturbance in DISTURBANCES]
    return [*slow, *disturbed, *(Ending(ending, max(1, rounds // 40)) for ending in ENDINGS)]


def page(rows: Rows) -> Page:
    """Tables and a picture."""
    rounds = rows.of(Round)
    shown = Picture("wire", "milliseconds of a round by baud rate, and by number of robots", _picture(rounds))
    tables = (
        _line_table(rounds),
        _fleet_table(rounds),
        latency_table(rows.of(SlowRound)),
        disturbance_table(rows.of(DisturbedRound)),
        ending_table(rows.of(End)),
    )
    return Page("Serial lines", [*tables, shown])


def _line_table(rows: Sequence[Round]) -> Table:
    columns = (
        Column("baud"),
        Column("round"),
        Column("rounds"),
        Column("bytes sent", digits=0, estimate=True),
        Column("bytes received", digits=0, estimate=True),
        Column("on the wire (ms)", estimate=True),
        Column("measured (ms)", estimate=True),
        Column(f"within {PERIOD_MS:.0f} ms (%)", digits=0),
    )
    lines = []
    for baud in BAUD_RATES:
        for gripper, kind in _KINDS.items():
            own = pick(rows, baud=baud, robots=1, gripper=gripper)
            if own:
                line = (
                    baud,
                    kind,
                    len(own),
                    extremes([row.sent for row in own]),
                    extremes([row.received for row in own]),
                    extremes([row.wire for row in own]),
                    quantiles([row.taken for row in own]),
                    100.0 * sum(row.taken <= PERIOD_MS for row in own) / len(own),
                )
                lines.append(line)
    return Table("wire", "Time on the wire", _LINE_NOTE, columns, lines)


def _fleet_table(rows: Sequence[Round]) -> Table:
    columns = (Column("robots"), Column("a round (ms)", estimate=True), Column("times one robot's", digits=2))
    measured = _by_fleet(rows)
    lines = [(robots, taken, taken.value / measured[1].value) for robots, taken in measured.items()]
    return Table("fleet", "Several robots in parallel", _FLEET_NOTE, columns, lines)


def _by_fleet(rows: Sequence[Round]) -> dict[int, Estimate]:
    own = {robots: pick(rows, baud=FLEET_BAUD, robots=robots, gripper=False) for robots in FLEETS}
    return {robots: quantiles([row.taken for row in its]) for robots, its in own.items() if its}


def _picture(rows: Sequence[Round]) -> "Figure":
    figure = new_figure(WIDTH, 4.2)
    left, right = figure.subplots(1, 2)
    for gripper, colour, shift in ((False, OURS, -0.18), (True, THESIS, 0.18)):
        for place, baud in enumerate(BAUD_RATES):
            own = pick(rows, baud=baud, robots=1, gripper=gripper)
            for name, what, alpha in (("taken", "measured", 0.35), ("wire", "on the wire", 1.0)):
                label = f"{_KINDS[gripper]}: {what}" if place == 0 else None
                median = float(np.median([getattr(row, name) for row in own])) if own else 0.0
                left.bar(place + shift, median, 0.34, color=colour, alpha=alpha, label=label)
    left.axhline(PERIOD_MS, color=GREY, lw=1.2, ls="--", label=f"a round: {PERIOD_MS:.0f} ms")
    left.set_xticks(range(len(BAUD_RATES)), list(map(str, BAUD_RATES)))
    left.set(xlabel="baud", ylabel="time of a round (ms, median)")
    legend(figure, left, columns=2)
    measured = _by_fleet(rows)
    values = [taken.value for taken in measured.values()]
    bars = [[t.value - t.low for t in measured.values()], [t.high - t.value for t in measured.values()]]
    right.bar(range(len(values)), values, 0.5, color=OURS, yerr=bars, ecolor=GREY, capsize=3)
    right.set_xticks(range(len(values)), [str(robots) for robots in measured])
    right.set(
        xlabel=f"robots in parallel, {FLEET_BAUD} baud",
        ylabel="time of a round (ms, median)\nbars: 5th to 95th percentile",
    )
    right.set_ylim(bottom=0)
    return figure


def main() -> int:
    """Run the benchmark."""
    rounds = Count("rounds", 200, 25, "rounds at each baud rate and with each number of robots")
    given = parse("wire", __doc__, rounds, jobs=None)
    units = [*drives(given.rounds, given.seed), *lines(given.rounds, given.seed)]
    tables = {Round: "rounds", SlowRound: "slow_lines", DisturbedRound: "disturbed_lines", End: "endings"}
    return finish(given, page(collect(given, units, tables)))


if __name__ == "__main__":
    sys.exit(main())
