"""The page of a comparison: results in words, the picture, the tables, and every learner's settings."""

import math
from collections.abc import Mapping, Sequence
from textwrap import wrap
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from khepera_forage.comparison.learning import ARENAS, RecallBatch
from khepera_forage.comparison.results import DELIVERED, SUCCESS, Curve, ReadLearner
from khepera_forage.estimates import Column, Floats, Sample, Table, Value, combined, pick, table_of
from khepera_forage.figures import GREY, OURS, SMALL, THESIS, WIDTH, grid, new_figure, padded
from khepera_forage.policies.learners import Supervision
from khepera_forage.sim.arenas.difficulty import DIFFICULTIES
from khepera_forage.study import SMOKE_TEST, Page, Picture
from khepera_forage.task.decisions import DEFAULT_DECISIONS

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure, SubFigure

SHARE = f"{100 * SUCCESS:.0f} %"
METHOD = f"""Every learner learns in the corridor only, and then forages alone in every arena, from random places that
are the same for all learners and amounts. **Imitators** get growing numbers of the same training episodes (5.3); their
steps are the rounds of all attempts. **Learners that query the teacher** forage in the corridor, and the teacher names
its behaviour at every step. **Reinforcement learners** forage there for the environment's reward, without any
demonstration. A step is {DEFAULT_DECISIONS.round_duration:g} s of one robot's life. Seconds are wall time of one
process, simulation included. The score counts steps in which a learner does what the teacher would have done (5.4); a
learner that forages in another way scores low and may still deliver all food."""
TUNING = """`khepera-forage compare --tune` compares these settings with four others each, except those of the thesis's
imitator, which are fixed, and of reinforcement learners, whose trainings take long."""


def main_table(curves: Sequence[Curve], learners: Mapping[str, ReadLearner]) -> Table:
    """Every learner in both arenas, after all of its learning."""
    rows: list[dict[str, Value]] = []
    for curve in curves:
        learner, end = learners[curve.learner], curve.end
        rows.append(
            {
                "learner": learner.title,
                "arena": curve.arena,
                "food delivered (%)": end.delivered,
                "score (%)": end.score,
                "steps of learning": end.steps,
                f"steps to {SHARE} of the food": curve.steps_to_success,
                "gain (points)": curve.gain,
                "steps a recall": end.recall_steps,
                "vectors": end.vectors,
                "learning (s)": end.seconds,
                "learns from": learner.needs.value if learner.needs else "-",
                "seeds": end.batches,
            }
        )
    whole = ("steps of learning", f"steps to {SHARE} of the food", "steps a recall", "vectors")
    return table_of(
        "learners",
        "After all of the learning",
        f"Means with 95 % bootstrap intervals over replications. Steps to {SHARE} of the food: environment steps when "
        "a batch of recalls first delivered this share, the median over replications; ∞ if more than half never did. "
        "Gain: food delivered minus that after the first amount of learning. In arenas that are not the thesis's, "
        "learners are tested after all of the learning alone: steps are those of all of it or ∞, without a gain.",
        rows,
        dict.fromkeys(whole, 0) | {"learning (s)": 2},
    )


def amounts_table(curves: Sequence[Curve]) -> Table:
    """The values of the picture: after every amount of learning."""
    return table_of(
        "amounts",
        "After every amount of learning",
        "The values of the picture.",
        [
            {
                "learner": curve.learner,
                "arena": curve.arena,
                "amount": point.amount,
                "seeds": point.batches,
                "steps of learning": point.steps,
                "vectors": point.vectors,
                "score (%)": point.score,
                "food delivered (%)": point.delivered,
                "learning (s)": point.seconds,
            }
            for curve in curves
            for point in curve.points
        ],
        {"steps of learning": 0, "vectors": 0, "learning (s)": 2},
    )


def other_arenas(rows: Sequence[RecallBatch], learners: Mapping[str, ReadLearner], seed: int) -> list[Picture | Table]:
    """What each learner delivers in each arena after all of its learning; nothing if these are the thesis's arenas.

    The rows have increasing amounts of learning; the seed is that of the resamples.
    """
    arenas = list(dict.fromkeys(row.arena for row in rows))
    if set(arenas) <= set(ARENAS):
        return []
    most = {row.learner: row.amount for row in rows}
    ends = [row for row in rows if row.amount == most[row.learner]]
    kinds = {
        "corridor": [arena for arena in arenas if arena == ARENAS[0]],
        "other named arenas": [arena for arena in arenas if arena not in (ARENAS[0], *DIFFICULTIES)],
        "procedural arenas": [arena for arena in arenas if arena in DIFFICULTIES],
    }
    hidden = [f"in {arena}" for arena in arenas]
    columns = {kind: own for kind, own in kinds.items() if own} | {f"in {arena}": [arena] for arena in arenas}
    lines: list[dict[str, Value]] = []
    values = []
    for name in most:
        food = {arena: Sample(pick(ends, learner=name, arena=arena), *DELIVERED[1:3]) for arena in arenas}
        means = {
            column: combined([(1 / len(own), food[arena]) for arena in own], np.random.default_rng(seed))
            for column, own in columns.items()
        }
        lines.append({"learner": learners[name].title, **means})
        values.append([means[column].value for column in hidden])
    table = table_of(
        "arenas",
        "Food delivered in each kind of arena",
        "In percent of the food that is not poisonous, after all of the learning; every arena counts alike. "
        "`table_arenas.csv` has each arena.",
        lines,
        hidden=hidden,
    )
    names = [learners[name].title for name in most]
    return [Picture("arenas", "food delivered in each arena", _arenas_figure(np.array(values), names, arenas)), table]


def _arenas_figure(values: Floats, learners: Sequence[str], arenas: Sequence[str]) -> "Figure":
    """Percentages as a table of colours: a line for each learner, a column for each arena."""
    drawn = new_figure(WIDTH, 1.2 + 0.3 * len(learners))
    drawn.suptitle("Food delivered in each arena (%)")
    axes = drawn.subplots()
    axes.imshow(values, cmap="Blues", vmin=0, vmax=100, aspect="auto")
    for (line, column), value in np.ndenumerate(values):
        if not math.isnan(value):
            colour = "white" if value > _DARK else "black"
            axes.text(column, line, f"{value:.0f}", ha="center", va="center", color=colour, fontsize=SMALL)
    axes.set_xticks(range(len(arenas)), [arena.replace("_", "\n") for arena in arenas], fontsize=SMALL)
    axes.set_yticks(range(len(learners)), learners, fontsize=SMALL)
    return drawn


def page(
    curves: Sequence[Curve],
    learners: Mapping[str, ReadLearner],
    missing: Mapping[str, str],
    tuned: bool,
    quick: bool = False,
    elsewhere: Sequence[Picture | Table] = (),
) -> Page:
    """All of it: `missing` says why learners are left out, `tuned` whether settings have a page in `tuning`."""
    names = list(dict.fromkeys(curve.learner for curve in curves))
    settings = Table(
        "settings",
        "Settings",
        f"{TUNING} See [all settings](tuning/tuning.md)." if tuned else TUNING,
        (Column("name"), Column("learner"), Column("settings")),
        [
            (f"`{name}`", learners[name].title, f"`{learners[name].settings}`")
            for name in names
            if learners[name].needs is not None
        ],
    )
    drawn = [curve for curve in curves if curve.arena in STYLES]
    caption = "food delivered against steps of learning"
    absent = [f"`{name}` was left out: {why}." for name, why in missing.items() if name not in names]
    return Page(
        "All learners side by side",
        [
            "**How much experience does a learner need to forage?**",
            *([Picture("learners", caption, figure(drawn, learners))] if drawn else []),
            *absent,
            *([SMOKE_TEST] if quick else []),
            METHOD,
            main_table(curves, learners),
            *elsewhere,
            "The same after every amount of learning is in `table_amounts.csv`, every batch of recalls in `rows.csv`.",
            settings,
        ],
        (amounts_table(curves),),
    )


FAMILIES = {
    Supervision.VECTORS: "Imitation: steps of the training episodes",
    Supervision.QUERIES: "Expert queries: each step is a query",
    Supervision.STEPS: "Reinforcement learning: steps of the environment",
}
"""The kinds of learners, each with its own axis of steps."""
COLUMNS = 4
"""Panels beside each other."""
_DENSE = 50
"""An axis of steps whose ends have at most this ratio has numbers at 1, 2 and 5, and not at powers of ten alone."""


class Style(NamedTuple):
    """How the curve of an arena is drawn."""

    colour: str
    marker: str
    line: str
    reference: str


STYLES = dict(zip(ARENAS, (Style(OURS, "o", "-", ":"), Style(THESIS, "s", "--", "-.")), strict=True))
_DARK = 60
"""Percent from which a cell of the picture of arenas is dark."""
_TITLE = 24
"""Characters in a line of a panel's title."""
_PANEL, _HEADING, _LEGEND = 1.7, 0.34, 1.0
"""Inches: height of a line of panels, of the heading of a kind with its label of the steps, and of the rest."""


def figure(curves: Sequence[Curve], learners: Mapping[str, ReadLearner]) -> "Figure":
    """A block of panels for each kind of learner, and a panel for each learner with its curve in each arena."""
    shown = dict.fromkeys(curve.learner for curve in curves)
    families = {needs: [name for name in shown if learners[name].needs is needs] for needs in FAMILIES}
    families = {needs: names for needs, names in families.items() if names}
    heights = [_HEADING + _PANEL * math.ceil(len(names) / COLUMNS) for names in families.values()]
    drawn = new_figure(WIDTH, _LEGEND + sum(heights))
    drawn.suptitle("Food delivered against steps of learning in the corridor")
    references = [curve for curve in curves if learners[curve.learner].needs is None]
    _key(drawn, references, learners)
    if families:
        blocks = drawn.subfigures(len(families), 1, squeeze=False, height_ratios=heights)[:, 0]
        for block, (needs, names) in zip(blocks, families.items(), strict=True):
            block.suptitle(FAMILIES[needs], fontsize=10, fontweight="bold")
            own = [curve for curve in curves if curve.learner in names]
            _block(block, {name: learners[name].title for name in names}, own, references)
    return drawn


def _block(block: "SubFigure", titles: Mapping[str, str], curves: Sequence[Curve], references: Sequence[Curve]) -> None:
    """The panels of one kind of learner, all with the same axes."""
    lines = math.ceil(len(titles) / COLUMNS)
    panels = block.subplots(lines, COLUMNS, sharex=True, sharey=True, squeeze=False)
    for axes, (name, title) in zip(panels.flat, titles.items(), strict=False):
        axes.set_title("\n".join(wrap(title, _TITLE)), fontsize=SMALL)
        axes.set_xscale("log")
        axes.set_ylim(*padded(0, 100))
        axes.set_yticks(range(0, 101, 20))
        axes.tick_params(labelsize=SMALL)
        axes.axhline(100 * SUCCESS, color="0.6", lw=0.8, zorder=1)
        grid(axes)
        for reference in references:
            value = reference.end.delivered.value
            axes.axhline(value, color=GREY, lw=1, ls=STYLES[reference.arena].reference, zorder=1)
        for curve in curves:
            style, steps = STYLES[curve.arena], [point.steps.value for point in curve.points]
            food, low, high = zip(*(point.delivered for point in curve.points), strict=True)
            if curve.learner != name:
                axes.plot(steps, food, color="0.85", lw=0.8, ls=style.line, zorder=1)
                continue
            look = {"color": style.colour, "marker": style.marker, "ls": style.line}
            axes.plot(steps, food, **look, ms=4.5, lw=1.6, mec="white", mew=0.5)
            if all(map(math.isfinite, low)):
                axes.fill_between(steps, low, high, color=style.colour, alpha=0.15, lw=0)
    for axes in panels.flat[len(titles) :]:
        axes.set_axis_off()
    _step_axis(panels[0, 0])
    for place in range(min(COLUMNS, len(titles))):
        lowest = [axes for axes in panels[:, place] if axes.axison][-1]
        lowest.tick_params(labelbottom=True)
    for axes in panels[:, 0]:
        axes.set_ylabel("food delivered (%)", fontsize=SMALL)


def _step_axis(axes: "Axes") -> None:
    """Numbers along the axis of steps, which all panels of a block share."""
    from matplotlib.ticker import EngFormatter, LogLocator, MaxNLocator, NullLocator

    low, high = axes.get_xlim()
    few = LogLocator(subs=(1, 2, 5) if high < _DENSE * low else (1,))
    axes.xaxis.set_major_locator(few if high > 3 * low else MaxNLocator(2))
    axes.xaxis.set_minor_locator(NullLocator())
    axes.xaxis.set_major_formatter(EngFormatter(sep=""))  # 500, 2k, 1M


def _key(drawn: "Figure", references: Sequence[Curve], learners: Mapping[str, ReadLearner]) -> None:
    """One legend for all panels."""
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    handles: list[Line2D | Patch] = []
    for arena, style in STYLES.items():
        label = f"{arena} ({'the arena of the learning' if arena == ARENAS[0] else 'a new arena'})"
        handles.append(Line2D([], [], color=style.colour, marker=style.marker, ls=style.line, label=label))
    handles += [
        Patch(color=style.colour, alpha=0.15, label=f"95 % interval, {arena}") for arena, style in STYLES.items()
    ]
    handles.append(Line2D([], [], color="0.85", lw=0.8, label="other learners of the kind"))
    handles.append(Line2D([], [], color="0.6", lw=0.8, label=f"success: {100 * SUCCESS:.0f} %"))
    for curve in references:
        label = f"{learners[curve.learner].title}, {curve.arena}"
        line = STYLES[curve.arena].reference
        handles.append(Line2D([], [], color=GREY, lw=1, ls=line, label=label))
    drawn.legend(handles=handles, loc="outside lower center", ncols=3, frameon=False, fontsize=SMALL)
