"""Parts of figures, drawn with matplotlib's figure objects directly, without a window system or global state."""

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from khepera_forage.estimates import Estimate
from khepera_forage.files import naming_file

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

OURS, THESIS, GREY = "#0072B2", "#D55E00", "#6E6E6E"
"""Blue and vermilion of Okabe and Ito, which colour-blind readers can distinguish, and grey."""
DPI = 150
WIDTH = 8.0
"""Inches. Pages show a figure about 800 pixels wide, where the smallest text, of 8 points, is then 11 pixels high."""
SMALL = 8.0
"""Points: the smallest text in figures."""
MARGIN = 0.02
"""Share of the length of an axis with fixed ends that is added at each end, so that marks there are shown whole."""
COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000")
"""Okabe and Ito's colours, which colour-blind readers can tell apart."""
MARKERS = ("o", "s", "D", "^", "v", "P", "X")
"""One for each colour, so that a picture can be read in grey, too."""


def new_figure(width: float, height: float) -> "Figure":
    """An empty figure; width and height are in inches."""
    from matplotlib.figure import Figure

    return Figure(figsize=(width, height), dpi=DPI, layout="constrained")


def save(figure: "Figure", path: Path) -> None:
    """Write a figure as PNG."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    path.parent.mkdir(parents=True, exist_ok=True)
    figure.set_dpi(DPI)
    figure.set_facecolor("white")
    with naming_file(path):
        # `Figure.savefig` would draw everything once more, only for the layout.
        FigureCanvasAgg(figure).print_png(path)  # type: ignore[no-untyped-call]


def mark(
    axes: "Axes", x: float, y: float, estimate: Estimate, colour: str, level: bool = False, marker: str = "o"
) -> None:
    """Draw an estimate as a marker with its interval as a bar, vertical or `level`."""
    if not math.isfinite(estimate.value):
        return
    axes.plot(x, y, marker, color=colour, ms=7, mec="white", zorder=5)
    if math.isfinite(estimate.low):
        ends = np.array([[estimate.value - estimate.low], [estimate.high - estimate.value]]).clip(min=0)
        xerr, yerr = (ends, None) if level else (None, ends)
        axes.errorbar([x], [y], xerr=xerr, yerr=yerr, fmt="none", color=colour, capsize=4, lw=1.8, zorder=4)


def padded(low: float, high: float) -> tuple[float, float]:
    """The limits of an axis from `low` to `high` that show marks at its ends whole."""
    pad = MARGIN * (high - low)
    return low - pad, high + pad


def panels(count: int, title: str) -> tuple["Figure", list["Axes"]]:
    """A figure with panels, two in a line."""
    lines = math.ceil(count / 2)
    figure = new_figure(WIDTH, 1.2 + 2.9 * lines)
    axes = figure.subplots(lines, 2, squeeze=False)
    figure.suptitle(title)
    return figure, list(axes.flat)


def levels(
    axes: "Axes",
    estimates: Mapping[str, Sequence[Estimate]],
    label: str,
    names: Sequence[str] = (),
    colours: Sequence[str] = COLOURS,
) -> None:
    """Estimates as level bars, several in a line.

    Args:
        axes: Where.
        estimates: By the name of the line, one of each kind.
        label: What is shown.
        names: Of the kinds, for a legend.
        colours: Of the kinds.
    """
    for place, line in enumerate(reversed(list(estimates.values()))):
        known = [(i, estimate) for i, estimate in enumerate(line) if math.isfinite(estimate.value)]
        for row, (i, estimate) in enumerate(known):
            height = place + 0.32 * ((len(known) - 1) / 2 - row)
            mark(axes, estimate.value, height, estimate, colours[i], level=True, marker=MARKERS[i])
    for name, colour, marker in zip(names, colours, MARKERS, strict=False):
        entry(axes, name, colour, marker)
    axes.set_yticks(range(len(estimates)), list(estimates)[::-1], fontsize=SMALL)
    axes.set_ylim(-0.6, len(estimates) - 0.4)
    axes.set_xlabel(label)
    grid(axes, "x")


def entry(axes: "Axes", label: str, colour: str, marker: str, line: str = "") -> None:
    """An entry of the legend for what `mark` draws, on a thin line if marks are connected."""
    axes.plot([], [], color=colour, marker=marker, ls=line, lw=1, ms=7, mec="white", label=label)


def grid(axes: "Axes", axis: str = "y") -> None:
    """Pale lines behind everything that is drawn; `axis` is x, y or both."""
    axes.grid(axis=axis, color="0.9")  # type: ignore[arg-type]
    axes.set_axisbelow(True)


def legend(figure: "Figure", axes: "Axes", title: str = "", columns: int = 4) -> None:
    """One legend below all panels, with the labels of one of them, each once."""
    entries = {label: handle for handle, label in zip(*axes.get_legend_handles_labels(), strict=True)}
    figure.legend(
        entries.values(),
        entries.keys(),
        loc="outside lower center",
        ncols=columns,
        frameon=False,
        fontsize=SMALL,
        title=title,
        title_fontsize=SMALL,
    )
