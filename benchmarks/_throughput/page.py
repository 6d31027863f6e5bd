"""The outcome as a page of Markdown, and as a picture."""

import os
import platform
from collections.abc import Sequence
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING

from _throughput import bare_pymunk, batch, compiling, foraging, imitating, parts, processes, scaling
from _throughput.lines import Line
from khepera_forage.thesis.figures import GREY, OURS, THESIS, new_figure
from khepera_forage.thesis.statistics import Estimate
from khepera_forage.thesis.tables import Column, Table

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_LIBRARIES = ("khepera-forage", "pymunk", "gymnasium", "pettingzoo", "numpy", "scikit-learn")
_NOTES = {
    foraging.SECTION: foraging.NOTE,
    bare_pymunk.SECTION: bare_pymunk.NOTE,
    imitating.SECTION: imitating.NOTE,
    processes.SECTION: processes.NOTE,
    parts.SECTION: parts.NOTE,
    batch.SECTION: batch.NOTE,
    scaling.SECTION: scaling.NOTE,
    compiling.SECTION: compiling.NOTE,
}
_COLUMNS = ("measure", "unit", "measured", "goal", "met", "how")


def page(lines: Sequence[Line]) -> str:
    """A table for each section, the machine named above them."""
    repeats = max(len(line.repeats) for line in lines)
    head = (
        f"# Throughput\n\n{machine()}\n\nOne process, one thread where nothing else is said. Measured: median "
        f"[lowest, highest] of {repeats} repeats; every measure is taken once in each repeat, on the same work.\n"
    )
    sections = dict.fromkeys(line.section for line in lines)
    return "\n".join([head, *(_table(section, lines).markdown() for section in sections)])


def machine() -> str:
    """The machine and the versions that the figures are for."""
    versions = ", ".join(f"{name} {version(name)}" for name in _LIBRARIES)
    load = f", load average {os.getloadavg()[0]:.1f} at the end" if hasattr(os, "getloadavg") else ""
    return f"{_processor()}, {os.cpu_count()} cores{load}; Python {platform.python_version()}, {versions}."


def picture(lines: Sequence[Line]) -> "Figure":
    """Measures against their goals, and the parts of a step."""
    figure = new_figure(10.0, 4.2)
    left, right = figure.subplots(1, 2)
    _against_goals(left, [line for line in lines if line.goal is not None])
    _by_part(right, [line for line in lines if line.section == parts.SECTION])
    return figure


def _table(section: str, lines: Sequence[Line]) -> Table:
    """The lines of a section; a column that would be empty is left out."""
    met = {True: "yes", False: "no", None: ""}
    rows = [
        (line.name, line.unit, _rounded(line), line.bound, met[line.met], line.how)
        for line in lines
        if line.section == section
    ]
    kept = [i for i in range(len(_COLUMNS)) if any(row[i] for row in rows)]
    columns = tuple(Column(_COLUMNS[i]) for i in kept)
    return Table(
        "throughput", section, _NOTES[section], columns, [tuple(row[i] for i in kept) for row in rows]
    )


def _rounded(line: Line) -> str:
    """Median, lowest and highest: three digits of what is small, none behind the point of what is large."""
    values = Estimate(line.median, line.lowest, line.highest)
    digits = 0 if line.median >= 1000 else 1 if line.median >= 10 else 2
    value, low, high = (f"{v:,.{digits}f}" for v in values)
    return value if len(line.repeats) == 1 else f"{value} [{low}, {high}]"


def _against_goals(axes: "Axes", lines: Sequence[Line]) -> None:
    """How far a goal is surpassed: at 1 it is just met."""
    lines = lines[::-1]
    for place, line in enumerate(lines):
        assert line.goal is not None
        factor = line.median / line.goal if line.bound.startswith("at least") else line.goal / line.median
        axes.barh(place, factor, color=OURS if line.met else THESIS)
        axes.text(
            max(factor, 1.0), place, f" {_rounded(line).split(' ')[0]} {line.unit}", va="center", fontsize=8
        )
    axes.axvline(1.0, color=GREY, lw=1.2, ls="--")
    axes.set_yticks(
        range(len(lines)), [f"{line.name}\n({line.bound} {line.unit})" for line in lines], fontsize=7
    )
    axes.set_xlabel("times as good as the goal (dashed)")
    axes.set_xlim(0, 1.6 * max(axes.get_xlim()))


def _by_part(axes: "Axes", lines: Sequence[Line]) -> None:
    shown = [line for line in lines if line.name in parts.PARTS][::-1]
    total = sum(line.median for line in shown)
    for place, line in enumerate(shown):
        axes.barh(place, line.median, color=OURS)
        axes.text(line.median, place, f" {100 * line.median / total:.0f} %", va="center", fontsize=8)
    axes.set_yticks(range(len(shown)), [line.name for line in shown], fontsize=7)
    axes.set_xlabel(f"µs a step of Corridor-v0 (sum {total:.0f})")
    axes.set_xlim(0, 1.1 * max(axes.get_xlim()))


def _processor() -> str:
    """The processor's model, as well as this system tells."""
    try:
        for line in Path("/proc/cpuinfo").read_text().splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    except OSError:
        pass
    return platform.processor() or platform.machine()
