"""Food delivered against steps of learning, on a logarithmic axis, corridor and rectangle side by side."""

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from khepera_forage.comparison.curves import SUCCESS, Curve
from khepera_forage.comparison.results_file import Shown
from khepera_forage.comparison.rows import ARENAS
from khepera_forage.experiments.figures import GREY, new_figure
from khepera_forage.policies.learners import Needs

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

COLOURS = {
    Needs.VECTORS: ("#08306B", "#1F78D1", "#7FB8E6", "#6A51A3", "#C08BD6", "#117A65", "#66B99A", "#000000"),
    Needs.QUERIES: ("#B8860B", "#E6B800"),
    Needs.STEPS: ("#B22222", "#F08060", "#C2185B", "#F48FB1"),
}
"""Blues, violets and greens for imitators, yellows for queries, reds for reinforcement."""
MARKS = "osD^v<>X"
FAMILIES = {Needs.VECTORS: "imitation", Needs.QUERIES: "expert queries", Needs.STEPS: "reinforcement"}


def figure(curves: Sequence[Curve], learners: Mapping[str, Shown]) -> "Figure":
    """Both arenas: one line a learner, with a band for its interval."""
    drawn = new_figure(13.0, 6.0)
    panels = dict(zip(ARENAS, drawn.subplots(1, 2, sharey=True), strict=True))
    for arena, axes in panels.items():
        _axes(axes, arena)
        for curve in (curve for curve in curves if curve.arena == arena):
            if learners[curve.learner].needs is None:
                _reference(axes, curve, learners[curve.learner].title)
            else:
                _line(axes, curve, *_style(curve.learner, learners))
    panels[ARENAS[0]].set_ylabel("food delivered (%)")
    _key(drawn, [curve.learner for curve in curves if curve.arena == ARENAS[0]], learners)
    drawn.suptitle("Food delivered against steps of learning")
    return drawn


def _axes(axes: "Axes", arena: str) -> None:
    axes.set_title(f"{arena}: {'the arena of the learning' if arena == ARENAS[0] else 'a new arena'}")
    axes.set_xscale("log")
    axes.xaxis.set_major_formatter(lambda steps, _: f"{steps:,.0f}")
    axes.xaxis.set_minor_formatter(lambda *_: "")
    axes.set_xlabel("environment steps of the learning")
    axes.set_ylim(-2, 102)
    axes.set_yticks(range(0, 101, 20))
    axes.grid(axis="both", color="0.92")
    axes.axhline(100 * SUCCESS, color="0.8", lw=1, zorder=1)
    axes.set_axisbelow(True)


def _style(name: str, learners: Mapping[str, Shown]) -> tuple[str, str]:
    needs = learners[name].needs
    assert needs is not None
    family = [other for other, learner in learners.items() if learner.needs is needs]
    place, colours = family.index(name), COLOURS[needs]
    return colours[place % len(colours)], MARKS[place % len(MARKS)]


def _line(axes: "Axes", curve: Curve, colour: str, mark: str) -> None:
    x = [point.steps.value for point in curve.points]
    low, high = ([getattr(point.delivered, end) for point in curve.points] for end in ("low", "high"))
    axes.plot(
        x,
        [point.delivered.value for point in curve.points],
        color=colour,
        marker=mark,
        ms=6,
        lw=1.6,
        mec="white",
        mew=0.6,
    )
    if all(map(math.isfinite, low)):
        axes.fill_between(x, low, high, color=colour, alpha=0.1, lw=0)


def _reference(axes: "Axes", curve: Curve, title: str) -> None:
    value = curve.end.delivered.value
    axes.axhline(value, color=GREY, lw=1.2, ls=":", zorder=1)
    axes.annotate(
        title,
        (0.995, value),
        xycoords=("axes fraction", "data"),
        xytext=(0, -3 if value > 50 else 3),
        textcoords="offset points",
        ha="right",
        va="top" if value > 50 else "bottom",
        fontsize=8,
        color=GREY,
    )


def _key(drawn: "Figure", names: Sequence[str], learners: Mapping[str, Shown]) -> None:
    """A legend on the right, by kind of learner."""
    from matplotlib.lines import Line2D

    handles = []
    for needs, family in FAMILIES.items():
        own = [name for name in names if learners[name].needs is needs]
        if own:
            handles.append(Line2D([], [], ls="", label=family))
        for name in own:
            colour, mark = _style(name, learners)
            handles.append(Line2D([], [], color=colour, marker=mark, ms=6, label=learners[name].title))
    key = drawn.legend(
        handles=handles, loc="outside right upper", frameon=False, fontsize=9, labelspacing=0.7
    )
    for text in key.get_texts():
        if text.get_text() in FAMILIES.values():
            text.set_fontweight("bold")
