"""What a reader needs of every figure, checked on matplotlib's objects after the layout."""

import itertools
from collections.abc import Iterator

import numpy as np
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import PathCollection, PolyCollection
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from matplotlib.legend import Legend
from matplotlib.patches import Patch
from matplotlib.text import Text

SHOWN_WIDTH = 800
"""Pixels: width of a figure on a page."""
LEGIBLE = 10.5
"""Pixels: least height of text in a figure as it is shown."""


def lay_out(figure: Figure) -> Figure:
    """A figure after the layout, as the checks need it; one that was saved has been laid out already."""
    FigureCanvasAgg(figure)
    figure.draw_without_rendering()
    return figure


def check_readable(figure: Figure) -> None:
    """Every text is large enough at the size at which the figure is shown, whole, and apart from all other texts."""
    texts = list(texts_of(figure))
    assert texts
    scale = SHOWN_WIDTH / (72 * figure.get_figwidth())
    for text in texts:
        assert float(text.get_fontsize()) * scale >= LEGIBLE, f"too small: {text.get_text()!r}"
    boxes = [(text.get_text(), text.get_window_extent().padded(-1.0)) for text in texts]
    for name, box in boxes:
        inside = figure.bbox.padded(1.0)
        assert inside.contains(box.x0, box.y0), f"cut: {name!r}"
        assert inside.contains(box.x1, box.y1), f"cut: {name!r}"
    for (name, box), (other, its) in itertools.combinations(boxes, 2):
        assert not box.overlaps(its), f"{name!r} lies over {other!r}"


def texts_of(figure: Figure) -> Iterator[Text]:
    """All texts that are drawn and not empty."""
    found: list[Text | None] = [*figure.texts]
    for axes in figure.axes:
        found += [axes.title, *axes.texts]
        if axes.axison:
            for axis in (axes.xaxis, axes.yaxis):
                found += [axis.label, axis.get_offset_text(), *_tick_labels(axis)]
    for legend in legends_of(figure):
        found += [legend.get_title(), *legend.get_texts()]
    for part in figure.subfigs:
        found += part.texts
    yield from (text for text in found if text is not None and text.get_visible() and text.get_text().strip())


def legends_of(figure: Figure) -> list[Legend]:
    """The legends of a figure and of its panels."""
    own = [axes.get_legend() for axes in figure.axes]
    return [*figure.legends, *(legend for legend in own if legend is not None)]


def check_shading_is_explained(figure: Figure) -> None:
    """Each shaded area has the colour of a patch in a legend."""
    handles = [handle for legend in legends_of(figure) for handle in legend.legend_handles]
    explained = {to_rgb(handle.get_facecolor()) for handle in handles if isinstance(handle, Patch)}
    shaded = [area for axes in figure.axes for area in axes.collections if type(area).__name__ in _AREAS]
    for area in shaded:
        assert isinstance(area, PolyCollection)
        colours = np.asarray(area.get_facecolor()).reshape(-1, 4)
        assert {(red, green, blue) for red, green, blue, _ in colours.tolist()} <= explained, f"no legend for {colours}"


_AREAS = ("FillBetweenPolyCollection", "PolyCollection")
"""Names of the classes of filled areas in several versions of matplotlib."""


def check_points_are_shown(axes: Axes) -> None:
    """All marks lie inside the limits of the axes."""
    points = [np.column_stack(line.get_data()) for line in axes.lines if line.get_marker() not in ("", "None", None)]
    points += [np.asarray(dots.get_offsets()) for dots in axes.collections if isinstance(dots, PathCollection)]
    x_limits, y_limits = sorted(axes.get_xlim()), sorted(axes.get_ylim())
    for found in points:
        known = np.asarray(found, dtype=float)[np.isfinite(np.asarray(found, dtype=float)).all(axis=1)]
        for values, (low, high) in ((known[:, 0], x_limits), (known[:, 1], y_limits)):
            assert ((low <= values) & (values <= high)).all(), f"marks outside {low} to {high}"


def _tick_labels(axis: Axis) -> list[Text]:
    low, high = sorted(axis.get_view_interval())
    margin = 1e-9 * (high - low)
    ticks = [*axis.get_major_ticks(), *axis.get_minor_ticks()]
    return [
        label
        for tick in ticks
        if low - margin <= tick.get_loc() <= high + margin
        for label in (tick.label1, tick.label2)
    ]
