"""The outcome as a page of Markdown, and as a picture."""

from collections.abc import Sequence
from importlib.metadata import version
from typing import TYPE_CHECKING

from _throughput.page import machine

from _kheperax.differences import EQUAL, unequal
from _kheperax.lines import (
    AS_IT_COMES,
    CALLS,
    NOISE,
    PAIRS,
    TASKS,
    Pair,
    Row,
    best,
    of_line,
    rate,
    ratio,
    worlds_of,
)
from _kheperax.theirs import About
from khepera_forage.thesis.figures import GREY, OURS, THESIS, new_figure
from khepera_forage.thesis.statistics import UNKNOWN, Estimate
from khepera_forage.thesis.tables import Column, Table, Value, interval

if TYPE_CHECKING:
    from matplotlib.figure import Figure

STEM = "kheperax"
_HEAD = """# Beside Kheperax

[Kheperax](https://github.com/adaptive-intelligent-robotics/Kheperax) simulates robots like the Khepera in mazes,
thousands at a time, in JAX. This page sets its speed beside that of our batched bodies (`BatchWorld`) on the nearest
equal work.

```sh
pip install -e '.[fast,plots]'
python benchmarks/kheperax.py   # the first time, some minutes more and 1.2 GB for Kheperax' own environment
```

The command makes this page, its picture and its rows in `results/kheperax`, and a virtual environment with Kheperax and
JAX in `results/kheperax/venv` (or `--venv`); one that is there is used again.
"""
_MILLION = 1e6


def page(rows: Sequence[Row], about: About, megabytes: float) -> str:
    """The whole page.

    Args:
        rows: Of all lines and repeats.
        about: What Kheperax' process said of itself.
        megabytes: That its environment takes on disk.
    """
    factor = ratio(rows, _best(rows, NOISE.ours), _best(rows, NOISE.theirs))
    result = (
        f"**BatchWorld makes {interval(factor)} times as many robot-steps a second as Kheperax**, each with its noise "
        "on and with the number of worlds that suits it best; what the two do in a step is not the same, see below."
    )
    where = (
        f"{machine()} numba {version('numba')}. Kheperax {about.kheperax}, JAX {about.jax}, Python {about.python}, "
        f"{about.devices} JAX devices (processor only; a GPU, for which JAX is made too, was not tried); its "
        f"environment takes {megabytes:,.0f} MB."
    )
    parts = [_HEAD, f"{result}\n\n![robot-steps a second by number of worlds]({STEM}.png)\n\n{where}\n"]
    parts += [
        steps_table(rows).markdown(),
        by_worlds(rows, [NOISE]).markdown(),
        EQUAL,
        unequal(about).markdown(),
    ]
    return "\n".join(parts)


def steps_table(rows: Sequence[Row]) -> Table:
    """Every line with the number of worlds that suits it best, and how many times as fast ours are."""
    lines: list[tuple[Value, ...]] = []
    for pair in PAIRS:
        theirs, ours = _best(rows, pair.theirs), _best(rows, pair.ours)
        lines.append((*theirs, _millions(rows, *theirs), UNKNOWN))
        lines.append((*ours, _millions(rows, *ours), ratio(rows, ours, theirs)))
    for line in (AS_IT_COMES, *TASKS.values()):
        lines.append((*_best(rows, line), _millions(rows, *_best(rows, line)), UNKNOWN))
    repeats = len(of_line(rows, *_best(rows, NOISE.ours)))
    note = (
        f"Median [lowest, highest] of {repeats} repeats, a range that holds the true median with "
        f"{100 * (1 - 0.5 ** (repeats - 1)):.1f} % confidence; every line once in each repeat, the two of a pair in "
        "alternation. Each of a pair with the number of worlds with which it is fastest. The ratio is taken within "
        "each repeat, to the line above. The last three lines are for reference: the whole task in our kernel is "
        "bodies, camera, tracking, perception, behaviours, food register, score and new episodes, and its robots "
        "touch less than those driven at random."
    )
    columns = (
        Column("line"),
        Column("worlds"),
        Column("million robot-steps/s", 2, estimate=True),
        Column("times Kheperax", 1, estimate=True),
    )
    return Table("robot_steps", "Robot-steps a second", note, columns, lines)


def by_worlds(rows: Sequence[Row], pairs: Sequence[Pair] = PAIRS) -> Table:
    """Both lines of each pair with the same number of worlds."""
    lines: list[tuple[Value, ...]] = []
    for pair in pairs:
        for worlds in worlds_of(rows, pair.ours):
            theirs, ours = (pair.theirs, worlds), (pair.ours, worlds)
            lines.append(
                (
                    pair.name,
                    worlds,
                    _millions(rows, *theirs),
                    _millions(rows, *ours),
                    ratio(rows, ours, theirs),
                    of_line(rows, *theirs)[0].first_call,
                    of_line(rows, *ours)[0].first_call,
                )
            )
    columns = (
        Column("pair"),
        Column("worlds"),
        Column("Kheperax (million/s)", 2, estimate=True),
        Column("BatchWorld (million/s)", 2, estimate=True),
        Column("ratio", 1, estimate=True),
        Column("Kheperax: first call (s)"),
        Column("BatchWorld: first call (s)"),
    )
    note = (
        "The first call traces and compiles, and is not counted. JAX compiles anew in every process and for every "
        "number of worlds; our kernels do not depend on it and are kept on disk, so that they take some 30 s once, "
        "after an installation or a change."
    )
    return Table("by_worlds", "With the same number of worlds", note, columns, lines)


def picture(rows: Sequence[Row]) -> "Figure":
    """Robot-steps a second against the number of worlds."""
    figure = new_figure(6.4, 4.4)
    axes = figure.subplots()
    for pair, style, what in ((NOISE, "-", "stepped only"), (CALLS, "--", "read by Python at every step")):
        for line, colour, name in ((pair.ours, OURS, "BatchWorld"), (pair.theirs, THESIS, "Kheperax")):
            worlds = worlds_of(rows, line)
            rates = [_millions(rows, line, count) for count in worlds]
            ends = [[r.value - r.low for r in rates], [r.high - r.value for r in rates]]
            values = [r.value for r in rates]
            axes.errorbar(
                worlds,
                values,
                ends,
                color=colour,
                ls=style,
                marker="o",
                ms=4,
                capsize=3,
                label=f"{name}, {what}",
            )
    axes.set_xscale("log", base=2)
    axes.set_yscale("log")
    shown = worlds_of(rows, NOISE.ours)
    axes.set_xticks(shown, [f"{worlds:,}" for worlds in shown])
    low, high = axes.get_ylim()
    ticks = [tick for tick in (0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 50) if low <= tick <= high]
    axes.set_yticks(ticks, [f"{tick:g}" for tick in ticks])
    axes.minorticks_off()
    axes.grid(axis="y", color="0.9")
    axes.set_axisbelow(True)
    axes.set_xlabel("worlds stepped together")
    axes.set_ylabel("million robot-steps a second")
    axes.legend(fontsize=8, frameon=False, ncols=2, loc="lower center", bbox_to_anchor=(0.5, 1.0))
    figure.supxlabel("each with its noise on; bars: lowest and highest repeat", fontsize=8, color=GREY)
    return figure


def _best(rows: Sequence[Row], line: str) -> tuple[str, int]:
    return line, best(rows, line)


def _millions(rows: Sequence[Row], line: str, worlds: int) -> Estimate:
    return Estimate(*(value / _MILLION for value in rate(rows, line, worlds)))
