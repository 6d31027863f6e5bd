"""The figures of the page, one a question."""

import math
from typing import TYPE_CHECKING

import numpy as np

from arena_generalisation.analysis import WRONG, Analysis, arena_title, title
from arena_generalisation.attribution import CHANGES
from arena_generalisation.recall_arenas import NAMED
from arena_generalisation.replication import PATH
from arena_generalisation.rows import IMITATOR, RANDOM, TEACHER
from arena_generalisation.trainings import CORRIDOR, VARIED, WHOLE
from khepera_forage.experiments.figures import (
    GREY,
    OURS,
    SMALL,
    THESIS,
    WIDTH,
    entry,
    grid,
    legend,
    levels,
    mark,
    new_figure,
    padded,
)
from khepera_forage.experiments.measures import mean
from khepera_forage.task.states import State, StateVector

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

TRAINED = {CORRIDOR: "trained in the corridor", VARIED: "trained in varied arenas"}
_COLOURS = {CORRIDOR: OURS, VARIED: THESIS}
_MARKERS = {CORRIDOR: "o", VARIED: "s"}
_DARK = 55
"""Percent of the food from which the colour of a cell needs white text."""
_LINE = 3
"""Panels side by side."""


def arenas_picture(found: Analysis) -> "Figure":
    """Food delivered by every learner in every arena that has a name."""
    figure = new_figure(WIDTH, 1.6 + 0.44 * len(found.bounded))
    panels = figure.subplots(2, 1, sharex=True)
    for axes, (training, name) in zip(panels, TRAINED.items(), strict=True):
        shares = np.array(
            [
                [found.delivered(learner, training, arena=arena).value for arena in found.arenas]
                for learner in found.bounded
            ]
        )
        axes.imshow(shares, cmap="Blues", vmin=0, vmax=100, aspect="auto")
        for (y, x), share in np.ndenumerate(shares):
            colour = "white" if share > _DARK else "black"
            text = "-" if math.isnan(share) else f"{share:.0f}"
            axes.text(x, y, text, ha="center", va="center", color=colour, fontsize=SMALL)
        axes.set_title(f"{name}: food delivered (%)", fontsize=9)
        axes.set_yticks(range(len(shares)), [title(learner) for learner in found.bounded], fontsize=SMALL)
        axes.tick_params(length=0)
    panels[1].set_xticks(
        range(len(found.arenas)), [arena_title(name) for name in found.arenas], fontsize=SMALL
    )
    return figure


def difficulty_picture(found: Analysis) -> "Figure":
    """Food delivered against difficulty, one panel a learner."""
    lines = math.ceil(len(found.learners) / _LINE)
    figure = new_figure(WIDTH, 0.8 + 1.8 * lines)
    panels = figure.subplots(lines, _LINE, squeeze=False, sharex=True, sharey=True).flat
    places = range(len(found.difficulties))
    for panel, (learner, axes) in enumerate(zip(found.learners, panels, strict=False)):
        for bound in (TEACHER, RANDOM):
            level = [found.delivered(bound, CORRIDOR, group=group).value for group in found.difficulties]
            axes.plot(places, level, color=GREY, ls="--" if bound == TEACHER else ":", lw=1.2)
        for number, training in enumerate(TRAINED):
            xs = [place + 0.16 * (number - 0.5) for place in places]
            shares = [found.delivered(learner, training, group=group) for group in found.difficulties]
            colour = _COLOURS[training]
            axes.plot(xs, [share.value for share in shares], color=colour, lw=1)
            for x, share in zip(xs, shares, strict=True):
                mark(axes, x, share.value, share, colour, marker=_MARKERS[training])
        axes.set_title(title(learner), fontsize=9)
        axes.set_ylim(*padded(0, 100))
        axes.set_xlim(-0.5, len(places) - 0.5)
        axes.set_xticks(places, found.difficulties, fontsize=SMALL)
        axes.tick_params(axis="y", labelsize=SMALL)
        lowest = panel + _LINE >= len(found.learners)
        axes.tick_params(axis="x", labelbottom=lowest)
        grid(axes)
    for axes in panels:  # those that no learner needs
        axes.set_axis_off()
    first = figure.axes[0]
    for training, name in TRAINED.items():
        entry(first, name, _COLOURS[training], _MARKERS[training], "-")
    first.plot([], [], color=GREY, ls="--", lw=1.2, label="the teacher")
    first.plot([], [], color=GREY, ls=":", lw=1.2, label="random behaviours")
    figure.supylabel("food delivered (%)", fontsize=9)
    legend(figure, first, "procedural test arenas; bars: 95 % intervals over replications")
    return figure


def wrong_picture(found: Analysis) -> "Figure":
    """The imitator's wrong decisions by state, and with changes to its distance."""
    figure = new_figure(WIDTH, 3.9)
    left, right = figure.subplots(1, 2)
    states = [state.name for state in State if any(row.state == state.name for row in found.wrong)]
    by_state = {
        state.replace("_", " ").lower(): [
            mean(found.wrong_rows(training, state=state), WRONG, found.rng) for training in TRAINED
        ]
        for state in states
    }
    by_change = {
        change_title(change): [mean(found.wrong_rows(t, change), WRONG, found.rng) for t in TRAINED]
        for change in CHANGES
    }
    levels(left, by_state, "wrong decisions (%)", list(TRAINED.values()), (OURS, THESIS))
    levels(right, by_change, "wrong decisions (%)", colours=(OURS, THESIS))
    left.set_xlim(*padded(0, 100))
    left.set_title("by state", fontsize=9)
    right.set_title("with a change to the distance", fontsize=9)
    legend(figure, left, "the thesis's imitator along its own recalls, all arenas; bars: 95 % intervals")
    return figure


def path_picture(found: Analysis) -> "Figure":
    """The imitator with straight distances, and with distances along the path."""
    trainings = {**TRAINED, WHOLE: "varied arenas, all vectors"}
    figure = new_figure(WIDTH, 4.2)
    panels = figure.subplots(1, len(trainings), sharey=True)
    for axes, (training, name) in zip(panels, trainings.items(), strict=True):
        _straight_and_path(axes, found, training)
        axes.set_title(name, fontsize=9)
        axes.set_xlim(*padded(0, 100))
    entry(panels[0], "straight distances", OURS, "o")
    entry(panels[0], "distances along the path", THESIS, "s")
    legend(figure, panels[0], "the thesis's imitator; bars: 95 % intervals over replications")
    return figure


def _straight_and_path(axes: "Axes", found: Analysis, training: str) -> None:
    """Food delivered in each arena of the family and at each difficulty."""
    places = [{"group": NAMED, "arena": name} for name in found.named]
    places += [{"group": name} for name in found.difficulties]
    shares = {
        arena_title(list(place.values())[-1]): [
            found.delivered(IMITATOR, training, **place),
            found.delivered(IMITATOR, training, PATH.distances, **place),
        ]
        for place in places
    }
    levels(axes, shares, "food delivered (%)", colours=(OURS, THESIS))


def change_title(change: str) -> str:
    """A change to the distance, for tables and figures."""
    if change in StateVector._fields:
        return f"without {change.replace('_', ' ')}"
    return change
