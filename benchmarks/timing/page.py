"""The page: a table for each section, and pictures."""

import re
import textwrap
from collections.abc import Sequence
from typing import TYPE_CHECKING

from khepera_forage.estimates import Column, Table
from khepera_forage.figures import GREY, OURS, SMALL, THESIS, WIDTH, grid, new_figure
from khepera_forage.study import Page, Picture
from timing import bare_pymunk, compiled, compiling, environments, fresh_processes, imitator, parts, scaling
from timing.measures import Line, digits

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_SECTIONS = (
    environments,
    bare_pymunk,
    imitator,
    fresh_processes,
    parts,
    compiled,
    scaling,
    compiling,
)
_NOTES = {module.SECTION: module.NOTE for module in _SECTIONS}
_NAME = 52
"""Most characters in a line of a measure's name in the picture."""
_COLUMNS = ("measure", "unit", "measured", "goal", "met", "how")


def page(lines: Sequence[Line]) -> Page:
    """All sections that have lines."""
    repeats = max(len(line.values) for line in lines)
    head = (
        "One process and one thread where nothing else is said. Measured: median [lowest, highest] of "
        f"{repeats} repeats; every measure is taken once in each repeat, on the same work. "
        "`python benchmarks/throughput.py --beside b91f85b` compares the speed with version 0.1 (or any commit): both "
        "versions run the same cases alternately on the same machine, and each ratio has a target."
    )
    sections = dict.fromkeys(line.measure.section for line in lines)
    content: list[str | Table | Picture] = [head, *(_table(section, lines) for section in sections)]
    content.append(
        Picture("throughput", "measures against their goals, and the parts of a step", _picture(lines))
    )
    if scaling.SECTION in sections:
        caption = "the cost of a step against worlds and food"
        content.append(Picture("throughput_compiled", caption, scaling.picture(lines)))
    return Page("Throughput", content)


def _table(section: str, lines: Sequence[Line]) -> Table:
    """The lines of a section; a column without any value is left out."""
    met = {True: "yes", False: "no", None: ""}
    rows = []
    for line in lines:
        if line.measure.section == section:
            reached = None if line.factor is None else line.factor >= 1
            rows.append(
                (
                    line.measure.name,
                    line.measure.unit,
                    _rounded(line),
                    line.bound,
                    met[reached],
                    line.measure.how,
                )
            )
    kept = [i for i in range(len(_COLUMNS)) if any(row[i] for row in rows)]
    stem = re.sub(r"\W+", "_", section.lower())
    columns = tuple(Column(_COLUMNS[i]) for i in kept)
    return Table(stem, section, _NOTES[section], columns, [tuple(row[i] for i in kept) for row in rows])


def _rounded(line: Line) -> str:
    """Median, lowest and highest."""
    shown = digits(line.median)
    median, low, high = (f"{v:,.{shown}f}" for v in (line.median, min(line.values), max(line.values)))
    return median if len(line.values) == 1 else f"{median} [{low}, {high}]"


def _picture(lines: Sequence[Line]) -> "Figure":
    """Measures against their goals, and the parts of a step below."""
    goals = [line for line in lines if line.measure.goal is not None]
    by_part = [line for line in lines if line.measure in parts.PARTS.values()]
    heights = [0.9 + 0.44 * len(goals), 0.7 + 0.24 * len(by_part)]
    figure = new_figure(WIDTH, sum(heights))
    upper, lower = figure.subplots(2, 1, height_ratios=heights)
    _against_goals(upper, goals)
    _by_part(lower, by_part)
    return figure


def _against_goals(axes: "Axes", lines: Sequence[Line]) -> None:
    """How many times as good as its goal each measure is: at 1 the goal is just met."""
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    lines = lines[::-1]
    factors = [line.factor or 0.0 for line in lines]
    names = []
    for place, (line, factor) in enumerate(zip(lines, factors, strict=True)):
        unit = line.measure.unit
        names.append(f"{textwrap.fill(line.measure.name, _NAME)}\n({line.bound} {unit})")
        axes.barh(place, factor, color=OURS if factor >= 1 else THESIS)
        label = f" {_rounded(line).split(' ')[0]} {unit}"
        axes.text(max(factor, 1.0), place, label, va="center", fontsize=SMALL)
    axes.axvline(1.0, color=GREY, lw=1.2, ls="--")
    axes.set_yticks(range(len(lines)), names, fontsize=SMALL)
    axes.set_ylim(-0.6, len(lines) - 0.4)
    axes.set_xlabel("times as good as the goal; numbers: medians")
    axes.set_xlim(0, 1.6 * max([1.0, *factors]))  # room for the numbers beside the bars
    grid(axes, "x")
    handles = [
        Patch(color=OURS, label="goal met"),
        Patch(color=THESIS, label="goal missed"),
        Line2D([], [], color=GREY, lw=1.2, ls="--", label="goal"),
    ]
    axes.legend(
        handles=handles, ncols=3, frameon=False, fontsize=SMALL, loc="lower right", bbox_to_anchor=(1.0, 1.0)
    )


def _by_part(axes: "Axes", lines: Sequence[Line]) -> None:
    lines = lines[::-1]
    total = sum(line.median for line in lines)
    for place, line in enumerate(lines):
        axes.barh(place, line.median, color=OURS)
        axes.text(line.median, place, f" {100 * line.median / total:.0f} %", va="center", fontsize=SMALL)
    axes.set_yticks(range(len(lines)), [line.measure.name for line in lines], fontsize=SMALL)
    axes.set_xlabel(f"time of the parts of a step of Corridor-v1 (µs; sum {total:.0f})")
    axes.set_xlim(0, 1.1 * max(axes.get_xlim()))
    grid(axes, "x")
