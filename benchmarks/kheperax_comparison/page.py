"""The page: result, tables, differences, and the picture."""

from collections.abc import Sequence
from importlib.metadata import version
from typing import TYPE_CHECKING

from khepera_forage.estimates import UNKNOWN, Column, Estimate, Table, Value, interval
from khepera_forage.figures import GREY, OURS, SMALL, THESIS, grid, new_figure
from khepera_forage.study import Page, Picture
from kheperax_comparison.differences import EQUAL, unequal
from kheperax_comparison.measures import (
    CALLS,
    DEFAULT,
    NOISE,
    PAIRS,
    TASKS,
    Place,
    TimedLine,
    best,
    of_line,
    rate,
    ratio,
    worlds_of,
)
from kheperax_comparison.theirs import About

if TYPE_CHECKING:
    from matplotlib.figure import Figure

HEAD = """[Kheperax](https://github.com/adaptive-intelligent-robotics/Kheperax) simulates robots like the Khepera in
mazes, thousands at a time, in JAX. This page compares its speed with that of our compiled bodies on the most similar
work.

```sh
pip install -e '.[fast,plots]'
python benchmarks/kheperax.py   # the first run installs Kheperax in an environment of its own: some minutes, 1.2 GB
```

The command makes this page, its picture and its rows in `results/kheperax`, and a virtual environment with Kheperax and
JAX in `results/kheperax/venv` (or `--venv`), which later runs use again."""


def page(rows: Sequence[TimedLine], about: About, megabytes: float) -> Page:
    """The whole page.

    Args:
        rows: Of all lines and repeats.
        about: Versions and behaviour of Kheperax.
        megabytes: Size of its environment on disk.
    """
    factor = ratio(rows, best(rows, NOISE.ours), best(rows, NOISE.theirs))
    result = (
        f"**Our compiled bodies make {interval(factor)} times as many robot-steps a second as Kheperax**, each with "
        "its noise and with its fastest number of worlds. The work of a step is not the same, see below."
    )
    versions = (
        f"numba {version('numba')}. Kheperax {about.kheperax}, JAX {about.jax}, Python {about.python}, {about.devices} "
        "JAX devices (processor only; a GPU, for which JAX is made as well, was not tried); its environment takes "
        f"{megabytes:,.0f} MB."
    )
    picture = Picture("kheperax", "robot-steps a second by number of worlds", _picture(rows))
    parts: list[str | Table | Picture] = [
        HEAD,
        result,
        picture,
        versions,
        steps_table(rows),
        by_worlds(rows),
        EQUAL,
        unequal(about),
    ]
    return Page("Comparison with Kheperax", parts)


def steps_table(rows: Sequence[TimedLine]) -> Table:
    """Every line with its fastest number of worlds, and how many times as fast our lines are."""
    lines: list[tuple[Value, ...]] = []
    for pair in PAIRS:
        theirs, ours = best(rows, pair.theirs), best(rows, pair.ours)
        lines.append((*theirs, _millions(rows, theirs), UNKNOWN))
        lines.append((*ours, _millions(rows, ours), ratio(rows, ours, theirs)))
    for line in (DEFAULT, *TASKS.values()):
        place = best(rows, line)
        lines.append((*place, _millions(rows, place), UNKNOWN))
    repeats = len(of_line(rows, best(rows, NOISE.ours)))
    note = (
        f"Median [lowest, highest] of {repeats} repeats; the range contains the true median with "
        f"{100 * (1 - 0.5 ** (repeats - 1)):.1f} % confidence. Every line runs once in each repeat, the two of a pair "
        "in alternation, each with its fastest number of worlds. The ratio to the line above is taken within each "
        "repeat. The last three lines are for reference: the whole task in our kernel includes bodies, camera, "
        "tracking, perception, behaviours, food tracking, score and new episodes, and its robots touch less than those "
        "with random commands."
    )
    columns = (
        Column("line"),
        Column("worlds"),
        Column("million robot-steps/s", 2, estimate=True),
        Column("times Kheperax", 1, estimate=True),
    )
    return Table("robot_steps", "Robot-steps a second", note, columns, lines)


def by_worlds(rows: Sequence[TimedLine]) -> Table:
    """Both lines of each pair with the same number of worlds."""
    lines: list[tuple[Value, ...]] = []
    for pair in PAIRS:
        for worlds in worlds_of(rows, pair.ours):
            theirs, ours = (pair.theirs, worlds), (pair.ours, worlds)
            lines.append(
                (
                    pair.name,
                    worlds,
                    _millions(rows, theirs),
                    _millions(rows, ours),
                    ratio(rows, ours, theirs),
                    of_line(rows, theirs)[0].first_call,
                    of_line(rows, ours)[0].first_call,
                )
            )
    columns = (
        Column("pair"),
        Column("worlds"),
        Column("Kheperax (million/s)", 2, estimate=True),
        Column("compiled bodies (million/s)", 2, estimate=True),
        Column("ratio", 1, estimate=True),
        Column("Kheperax: first call (s)"),
        Column("compiled bodies: first call (s)"),
    )
    note = (
        "The first call traces and compiles, and does not count. JAX compiles in every process and for every number of "
        "worlds. Our kernels are independent of the number of worlds and are kept on disk: they compile once after an "
        "installation or a change."
    )
    return Table("by_worlds", "With the same number of worlds", note, columns, lines)


def _picture(rows: Sequence[TimedLine]) -> "Figure":
    """Robot-steps a second against the number of worlds."""
    figure = new_figure(6.4, 4.4)
    axes = figure.subplots()
    for pair, style, what in ((NOISE, "-", "stepped only"), (CALLS, "--", "read by Python at every step")):
        for line, colour, name in ((pair.ours, OURS, "compiled bodies"), (pair.theirs, THESIS, "Kheperax")):
            worlds = worlds_of(rows, line)
            rates = [_millions(rows, (line, count)) for count in worlds]
            values = [r.value for r in rates]
            ends = [[r.value - r.low for r in rates], [r.high - r.value for r in rates]]
            label = f"{name}, {what}"
            axes.errorbar(
                worlds, values, ends, color=colour, ls=style, marker="o", ms=4, capsize=3, label=label
            )
    axes.set_xscale("log", base=2)
    axes.set_yscale("log")
    shown = worlds_of(rows, NOISE.ours)
    axes.set_xticks(shown, [f"{worlds:,}" for worlds in shown])
    low, high = axes.get_ylim()
    ticks = [tick for tick in (0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 50) if low <= tick <= high]
    axes.set_yticks(ticks, [f"{tick:g}" for tick in ticks])
    axes.minorticks_off()
    grid(axes)
    axes.set_xlabel("worlds stepped together")
    axes.set_ylabel("million robot-steps a second")
    axes.legend(fontsize=SMALL, frameon=False, ncols=2, loc="lower center", bbox_to_anchor=(0.5, 1.0))
    figure.supxlabel("each with its noise; bars: lowest and highest repeat", fontsize=SMALL, color=GREY)
    return figure


def _millions(rows: Sequence[TimedLine], place: Place) -> Estimate:
    return Estimate(*(value / 1e6 for value in rate(rows, place)))
