"""The outcome as two tables and a picture."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from _wire.rounds import FLEETS, Round
from khepera_forage.robots.khepera import CONTROL_PERIOD
from khepera_forage.robots.serial.port import BAUDS, BITS_PER_BYTE
from khepera_forage.thesis.figures import GREY, OURS, THESIS, new_figure
from khepera_forage.thesis.statistics import Estimate
from khepera_forage.thesis.tables import Column, Table

if TYPE_CHECKING:
    from matplotlib.figure import Figure

PERIOD = 1000 * CONTROL_PERIOD
FLEET_BAUD = 38400
_KINDS = {False: "gripper rests", True: "gripper moves, or is looked at"}
_WIRE_NOTE = (
    "One robot. The bytes are those that the driver and a virtual Khepera really exchange while the robot drives about "
    f"and moves its gripper; a byte is {BITS_PER_BYTE} bits. Median [least, most]. Measured: `transmit` and `receive` "
    "through a virtual Khepera that keeps the pace of the baud rate, without what the world takes; median [5th, 95th "
    "percentile]. Rounds that ask a surprising reading again are among them."
)
_FLEET_NOTE = (
    f"All at {FLEET_BAUD} baud, each on a port of its own, the virtual Kheperas on the same computer as the drivers. "
    "Median [5th, 95th percentile] of the rounds in which the first robot's gripper rests."
)


def wire_table(rows: Sequence[Round]) -> Table:
    """Time on the wire, by baud rate."""
    columns = (
        Column("baud"),
        Column("round"),
        Column("rounds"),
        Column("bytes sent", digits=0, estimate=True),
        Column("bytes received", digits=0, estimate=True),
        Column("on the wire (ms)", estimate=True),
        Column("measured (ms)", estimate=True),
        Column(f"within {PERIOD:.0f} ms (%)", digits=0),
    )
    lines = []
    for baud in BAUDS:
        for gripper, kind in _KINDS.items():
            own = [row for row in rows if (row.baud, row.robots, row.gripper) == (baud, 1, gripper)]
            if own:
                lines.append(
                    (
                        baud,
                        kind,
                        len(own),
                        _spread([row.sent for row in own]),
                        _spread([row.received for row in own]),
                        _spread([row.wire for row in own]),
                        _percentiles([row.taken for row in own]),
                        100.0 * sum(row.taken <= PERIOD for row in own) / len(own),
                    )
                )
    return Table("wire", "Time on the wire", _WIRE_NOTE, columns, lines)


def fleet_table(rows: Sequence[Round]) -> Table:
    """What several robots cost."""
    columns = (Column("robots"), Column("a round (ms)", estimate=True), Column("times one robot's", digits=2))
    measured = _by_fleet(rows)
    lines = [(robots, taken, taken.value / measured[1].value) for robots, taken in measured.items()]
    return Table("fleet", "Several robots in parallel", _FLEET_NOTE, columns, lines)


def picture(rows: Sequence[Round]) -> "Figure":
    """Both tables."""
    figure = new_figure(9.0, 3.6)
    left, right = figure.subplots(1, 2)
    for gripper, colour, shift in ((False, OURS, -0.18), (True, THESIS, 0.18)):
        for place, baud in enumerate(BAUDS):
            own = [row for row in rows if (row.baud, row.robots, row.gripper) == (baud, 1, gripper)]
            if own:
                wire, taken = (
                    float(np.median([getattr(r, name) for r in own])) for name in ("wire", "taken")
                )
                label = _KINDS[gripper] if place == 0 else None
                left.bar(place + shift, taken, 0.34, color=colour, alpha=0.35)
                left.bar(place + shift, wire, 0.34, color=colour, label=label)
    left.axhline(PERIOD, color=GREY, lw=1.2, ls="--")
    left.set_xticks(range(len(BAUDS)), list(map(str, BAUDS)))
    left.set_xlabel("baud")
    left.set_ylabel("ms a round (median)\nsolid: on the wire; pale: measured")
    left.legend(fontsize=8)
    measured = _by_fleet(rows)
    values = [taken.value for taken in measured.values()]
    bars = [[t.value - t.low for t in measured.values()], [t.high - t.value for t in measured.values()]]
    right.bar(range(len(values)), values, 0.5, color=OURS, yerr=bars, ecolor=GREY, capsize=3)
    right.set_xticks(range(len(values)), [str(robots) for robots in measured])
    right.set_xlabel(f"robots in parallel, {FLEET_BAUD} baud")
    right.set_ylabel("ms a round (median, 5th to 95th percentile)")
    right.set_ylim(bottom=0)
    return figure


def _by_fleet(rows: Sequence[Round]) -> dict[int, Estimate]:
    own = {
        robots: [r.taken for r in rows if (r.baud, r.robots, r.gripper) == (FLEET_BAUD, robots, False)]
        for robots in FLEETS
    }
    return {robots: _percentiles(taken) for robots, taken in own.items() if taken}


def _spread(values: Sequence[float]) -> Estimate:
    return Estimate(float(np.median(values)), float(min(values)), float(max(values)))


def _percentiles(values: Sequence[float]) -> Estimate:
    low, median, high = np.percentile(values, (5, 50, 95)).tolist()
    return Estimate(median, low, high)
