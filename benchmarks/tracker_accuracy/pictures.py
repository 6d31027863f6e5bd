"""The pictures of the page: errors and losses of all cameras, and a frame with the tracker's regions."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from khepera_forage.estimates import Estimate, pick
from khepera_forage.figures import (
    COLOURS,
    GREY,
    OURS,
    SMALL,
    THESIS,
    WIDTH,
    grid,
    mark,
    new_figure,
)
from khepera_forage.vision.overlay import FOOD, MARKER
from tracker_accuracy.measures import errors, losses
from tracker_accuracy.observations import CAMERAS, KINDS, MODEL, THRESHOLD, TRACKER, TRAINING, Observation

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_LOOKS = {TRACKER: (OURS, "o"), MODEL: (THESIS, "s"), THRESHOLD: (GREY, "D")}
"""Colour and marker of each camera."""
_NAMES = {
    TRACKER: "tracker, rendered frames",
    MODEL: "simulated camera",
    THRESHOLD: "threshold, rendered frames",
}
_LINES = dict(zip(KINDS, (":", "-", "--"), strict=True))
_GOALS = {"centre": (1.0, "pixels"), "heading": (3.0, "degrees")}
"""The largest errors that are wanted (docs/tracker.md)."""
_GOAL_COLOUR = COLOURS[2]
_RARE = 0.01
"""Share of the found regions that may be worse."""


def errors_figure(observations: Sequence[Observation]) -> "Figure":
    """Errors of all cameras in trainings as curves, and loss rates with and without a cable."""
    figure = new_figure(WIDTH, 6.6)
    panels = figure.subplot_mosaic([["centre", "heading"], ["losses", "losses"]], height_ratios=(1.1, 1.0))
    trainings = pick(observations, source=TRAINING)
    for camera in CAMERAS:
        for kind in KINDS:
            error = errors(pick(trainings, camera=camera, kind=kind))
            _tail(panels["centre"], error.distances, camera, kind)
            _tail(panels["heading"], np.abs(error.turns), camera, kind)
    for name, (limit, unit) in _GOALS.items():
        _error_axes(panels[name], f"error of the {name} above ({unit})", limit)
    panels["centre"].set_ylabel("share of found regions")
    _losses(panels["losses"], trainings)
    for axes in panels.values():
        grid(axes, "both")
        axes.tick_params(labelsize=SMALL)
    figure.suptitle("Errors and losses of the cameras in simulated trainings")
    _key(figure)
    return figure


def frame_figure(frame: NDArray[np.uint8], drawn: NDArray[np.uint8]) -> "Figure":
    """A part of a frame beside the same part with the tracker's regions.

    Args:
        frame: Grey levels.
        drawn: The same part from `draw_scene`.
    """
    from matplotlib.lines import Line2D

    figure = new_figure(WIDTH, 4.1)
    left, right = figure.subplots(1, 2)
    # Without smoothing: the frame has no finer detail than its pixels.
    left.imshow(frame, cmap="gray", vmin=0, vmax=255, interpolation="nearest")
    right.imshow(drawn)
    titles = "Rendered frame, 5 mm a pixel", "The tracker's regions"
    for axes, title in zip((left, right), titles, strict=True):
        axes.set_title(title, fontsize=10)
        axes.set_axis_off()
    names = {
        "robot's marker: number of the region, holes; arrow: heading": MARKER,
        "food: number of the region": FOOD,
    }
    handles = [
        Line2D([], [], color=(red / 255, green / 255, blue / 255), lw=2, label=name)
        for name, (red, green, blue) in names.items()
    ]
    figure.legend(handles=handles, loc="outside lower center", ncols=2, frameon=False, fontsize=SMALL)
    return figure


def _tail(axes: "Axes", values: NDArray[np.float64], camera: str, kind: str) -> None:
    """The share of regions with a larger error, against the error."""
    if len(values):
        share = 1 - np.arange(len(values)) / len(values)
        axes.step(np.sort(values), share, color=_LOOKS[camera][0], ls=_LINES[kind], lw=1.4)


def _error_axes(axes: "Axes", label: str, goal: float) -> None:
    axes.set_yscale("log")
    axes.set_ylim(1e-4, 1.2)
    axes.axvline(goal, color=_GOAL_COLOUR, lw=1)
    axes.axhline(_RARE, color=_GOAL_COLOUR, lw=1)
    axes.set_xlabel(label)
    axes.set_xlim(0, 2.5 * goal)


def _losses(axes: "Axes", trainings: Sequence[Observation]) -> None:
    """Losses in 1000 rounds: a line for each kind of region, with and without a cable over it."""
    names, highest = [], 1.0
    for place, (kind, cable) in enumerate((kind, cable) for kind in KINDS for cable in (False, True)):
        names.append(f"{kind}, under a cable" if cable else kind)
        for shift, camera in zip((0.24, 0.0, -0.24), CAMERAS, strict=True):
            rate = losses(pick(trainings, camera=camera, kind=kind), cable).rate
            estimate = Estimate(*(1000 * value for value in rate))
            colour, marker = _LOOKS[camera]
            mark(axes, estimate.value, place + shift, estimate, colour, level=True, marker=marker)
            highest = max([highest, *(value for value in estimate if np.isfinite(value))])
    axes.set_yticks(range(len(names)), names)
    axes.set_xscale("symlog", linthresh=1)
    axes.set_xlim(-0.15, 1.5 * highest)  # marks at 0 and at the highest rate are shown whole
    axes.set_xticks([tick for tick in (0, 1, 10, 100, 1000) if tick <= 1.5 * highest])
    axes.xaxis.set_major_formatter(lambda rate, _: f"{rate:g}")
    axes.set_xlabel("losses in 1000 rounds, with 95 % interval")


def _key(figure: "Figure") -> None:
    from matplotlib.lines import Line2D

    handles = [
        Line2D([], [], color=colour, marker=marker, ms=7, mec="white", label=_NAMES[camera])
        for camera, (colour, marker) in _LOOKS.items()
    ]
    handles += [Line2D([], [], color="black", ls=line, lw=1.4, label=kind) for kind, line in _LINES.items()]
    limits = " and ".join(
        f"{limit:g} {unit.rstrip('s')}{'s' * (limit > 1)}" for limit, unit in _GOALS.values()
    )
    goal = f"goals: {limits}, {100 * _RARE:g} % of regions"
    handles.append(Line2D([], [], color=_GOAL_COLOUR, lw=1, label=goal))
    figure.legend(handles=handles, loc="outside lower center", ncols=3, frameon=False, fontsize=SMALL)
