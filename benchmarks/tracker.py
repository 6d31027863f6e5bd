"""The tracker on rendered frames, compared with the simulated camera.

    python benchmarks/tracker.py --help

Speed on one core; curves of what is found as cables, blur, exposure, contrast and noise become worse, up to failure;
trainings in simulation that all cameras observe: jitter, reversals, losses, swapped labels; and drives through glare,
shadows, hands and other troubles at three resolutions.
"""

import argparse
import math
import sys
import time
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import cv2
import numpy as np
from laboratory.limits import SWEEPS, Conditions, SweepPoint, frames, limit_points, limits_picture, limits_table
from laboratory.observations import (
    ATTEMPT,
    KINDS,
    MODEL,
    THRESHOLD,
    TRACKER,
    Observation,
    errors,
    losses,
    observe,
    swapped_labels,
    threshold_regions,
)
from laboratory.troubles import SETUPS, Trouble, troubled_drive, troubles_table
from numpy.typing import NDArray

from khepera_forage.estimates import UNKNOWN, Estimate, Table, Value, extremes, pick, table_of, wilson
from khepera_forage.figures import COLOURS, GREY, OURS, SMALL, THESIS, WIDTH, grid, legend, levels, new_figure
from khepera_forage.noise import Noise
from khepera_forage.rollouts.rendered_training import RenderedTraining
from khepera_forage.sim.sensing import OverheadCamera
from khepera_forage.study import Count, Job, Page, Picture, collect, finish, in_processes, parse
from khepera_forage.vision.overlay import FOOD, MARKER, draw_scene
from khepera_forage.vision.scene import MM_PER_PIXEL
from khepera_forage.vision.tracker import Tracker

if TYPE_CHECKING:
    from matplotlib.figure import Figure

PARTS = SPEED, LIMITS, TRAININGS, TROUBLES = ("speed", "limits", "trainings", "troubles")
COUNTS = (
    Count("trainings", 60, 1, "trainings to observe", adds_units=True),
    Count("rounds", 500, 100, "rounds of each"),
    Count("frames", 20, 1, "frames of each point of a curve, with 20 markers each"),
    Count("troubled", 1000, 5, "frames with and without trouble at each resolution"),
)
SPEED_FRAMES, SPEED_REPEATS = (200, 10), (5, 2)
"""Frames and repeats of the speed, and with --quick."""
_ANCHOR = 400.0
"""Cables hang from a point within this many mm, along each axis, of the middle of both arenas. In the middle itself
they would hang between the arenas and cross nothing."""
CROSSED, RENDERER = "tracker, each marker under a cable", "renderer"


@dataclass(frozen=True, slots=True)
class Rate:
    """One repeat of the speed of one part: frames a second, by the processor time of one thread."""

    part: str
    rate: float


def speeds(seed: int, count: int, repeats: int) -> list[Rate]:
    """The speed of all parts on frames of a training, and on frames with two markers under cables."""

    def first_look(number: int) -> None:
        tracker.reset()  # every frame shows other places
        tracker.update(crossed[number])

    cv2.setNumThreads(1)
    training, tracker = RenderedTraining(seed), Tracker()
    images = [training.newest()[0] for _ in range(count)]
    crossed = [frame for _, frame in frames(Conditions(8.0), count, np.random.default_rng(seed), tiles=2)]
    works: dict[str, Callable[[int], object]] = {
        TRACKER: lambda number: tracker.update(images[number]),
        CROSSED: first_look,
        RENDERER: lambda _: training.renderer.frame(),
    }
    rows = []
    for _ in range(repeats):
        tracker.reset()
        for part, work in works.items():
            began = time.process_time()
            for number in range(count):
                work(number)
            rows.append(Rate(part, count / (time.process_time() - began)))
    training.close()
    return rows


def observed_training(number: int, seed: int, rounds: int) -> list[Observation]:
    """Two robots forage, one following the other, for some rounds, in as many attempts as that takes."""
    cv2.setNumThreads(1)
    rng = np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(number,)))
    training = RenderedTraining(int(rng.integers(2**31)))
    middle = training.anchor
    training.close()
    x, y = rng.uniform(-_ANCHOR, _ANCHOR, 2).tolist()
    anchor = (middle[0] + x, middle[1] + y)
    training = RenderedTraining(int(rng.integers(2**31)), anchor=anchor)
    tracker = Tracker()
    # The world's own camera has its cables between the arenas; this model has the anchor of the rendered ones.
    model = OverheadCamera(training.world.truth, Noise.laboratory(), anchor)
    rows: list[Observation] = []
    attempts = 0
    for frame in range(rounds):
        picture, _ = training.newest()
        if training.attempts != attempts:
            attempts = training.attempts
            tracker.reset()
            model.reset(rng)
        else:
            model.expose()
        truth, rendered = training.world.truth(), training.renderer.cables
        straight = [np.array((anchor, marker[:2])) / MM_PER_PIXEL for marker in truth.markers]
        for camera, regions, cables in (
            (TRACKER, tracker.update(picture).regions, rendered),
            (THRESHOLD, threshold_regions(picture), rendered),
            (MODEL, model.look().regions, straight),
        ):
            rows += observe((camera, number, frame + ATTEMPT * attempts), truth, regions, cables)
    training.close()
    return rows


def speed_table(rows: Sequence[Rate], repeats: int) -> Table:
    """Frames a second."""
    lines: list[dict[str, Value]] = [
        {"part": part, "frames/s": extremes([row.rate for row in pick(rows, part=part)])}
        for part in (TRACKER, CROSSED, RENDERER)
    ]
    note = f"One thread, by its processor time; the goal is 300. Median [lowest, highest] of {repeats} repeats."
    return table_of("speed", "Speed", note, lines, {"frames/s": 0})


def model_table(rows: Sequence[Observation]) -> Table:
    """The simulated camera beside the tracker, in the quantities of `Noise`."""
    note = (
        "Trainings in simulation, observed by all cameras with the same anchor of the cables, one frame a round. The "
        "first column is the model's parameter, the second the same quantity measured on the model. The threshold "
        "reads contours and holes without any repair. Jitter: standard deviation of the error along an axis, of things "
        "that nothing hides; that of headings includes the rounding to whole degrees (0.29), which the model applies "
        "after its jitter. Loss rate: a round; things hidden by a marker do not count. Shares and rates with Wilson's "
        "95 % interval, loss_rounds with 5th and 95th percentile."
    )
    noise = Noise.laboratory()
    names = ("model, measured", "tracker on rendered frames", "threshold on rendered frames")
    by = {name: pick(rows, camera=camera) for name, camera in zip(names, (MODEL, TRACKER, THRESHOLD), strict=True)}
    lines: list[dict[str, Value]] = []

    def add(
        name: str, told: float | str, value: Callable[[list[Observation]], Estimate | float], kind: str = ""
    ) -> None:
        lines.append({"quantity": f"{name}, {kind}" if kind else name, "Noise.laboratory()": told})
        for column, own in by.items():
            each = value(pick(own, kind=kind) if kind else own)
            lines[-1][column] = each if isinstance(each, Estimate) else Estimate(each)

    for kind in KINDS:
        add("position_jitter (px)", noise.position_jitter, lambda own: _spread(errors(own).offsets), kind)
    for kind in KINDS[1:]:
        add("heading_jitter (deg)", noise.heading_jitter, lambda own: _spread(errors(own).turns), kind)
    add("reversal_rate", noise.reversal_rate, _reversals)
    rates = (noise.loss_rate_food, noise.loss_rate_one_hole, noise.loss_rate_two_holes)
    for kind, rate in zip(KINDS, rates, strict=True):
        add("loss rate", rate, lambda own: losses(own, cable=False).rate, kind)
    for kind in KINDS:
        add("loss rate under a cable", "", lambda own: losses(own, cable=True).rate, kind)
    add("loss_rounds", noise.loss_rounds, _loss_rounds)
    add("labels that changed things", "", _swaps)
    add("regions of nothing, a round", "", lambda own: len(pick(own, kind="")) / max(1, _rounds(own)))
    add("rounds", "", _rounds)
    digits = dict.fromkeys(("Noise.laboratory()", *names), 4)
    return table_of("model", "The simulated camera and the tracker", note, lines, digits)


def _spread(values: NDArray[np.float64]) -> float:
    return float(values.std()) if values.size else math.nan


def _reversals(rows: list[Observation]) -> Estimate:
    error = errors(rows)
    return wilson(error.reversals, error.reversals + len(error.turns))


def _loss_rounds(rows: list[Observation]) -> Estimate:
    lengths = [n for cable in (False, True) for n in losses(rows, cable).lengths]
    if not lengths:
        return UNKNOWN
    return Estimate(float(np.mean(lengths)), *np.percentile(lengths, (5, 95)).tolist())


def _swaps(rows: list[Observation]) -> float:
    return math.nan if rows[0].camera == THRESHOLD else swapped_labels(rows)


def _rounds(rows: Iterable[Observation]) -> float:
    return len({(row.training, row.frame) for row in rows})


_LOOKS = {TRACKER: "tracker, rendered frames", MODEL: "simulated camera", THRESHOLD: "threshold, rendered frames"}
_COLOURS = (OURS, THESIS, GREY)
"""Of the cameras."""
_LINES = dict(zip(KINDS, (":", "-", "--"), strict=True))
_RARE = 0.01
"""Share of the found regions that may be worse than the goals."""


def errors_figure(rows: Sequence[Observation]) -> "Figure":
    """Errors of all cameras in trainings as curves, and loss rates with and without a cable."""
    figure = new_figure(WIDTH, 6.6)
    panels = figure.subplot_mosaic([["centre", "heading"], ["losses", "losses"]], height_ratios=(1.1, 1.0))
    below, rates = panels["losses"], dict[str, list[Estimate]]()
    for kind in KINDS:
        for camera, colour in zip(_LOOKS, _COLOURS, strict=True):
            error = errors(pick(rows, camera=camera, kind=kind))
            for name, values in (("centre", error.distances), ("heading", np.abs(error.turns))):
                share = 1 - np.arange(len(values)) / max(1, len(values))
                panels[name].step(np.sort(values), share, color=colour, ls=_LINES[kind], lw=1.4)
        for cable, name in ((False, kind), (True, f"{kind}, under a cable")):
            rates[name] = [losses(pick(rows, camera=c, kind=kind), cable).rate.times(1000) for c in _LOOKS]
    for name, goal, unit in (("centre", 1.0, "pixels"), ("heading", 3.0, "degrees")):
        panels[name].set(yscale="log", ylim=(1e-4, 1.2), xlim=(0, 2.5 * goal))
        panels[name].set_xlabel(f"error of the {name} above ({unit})")
        panels[name].axvline(goal, color=COLOURS[2], lw=1)
        panels[name].axhline(_RARE, color=COLOURS[2], lw=1)
    panels["centre"].set_ylabel("share of found regions")
    levels(below, rates, "losses in 1000 rounds, with 95 % interval", tuple(_LOOKS.values()), _COLOURS)
    highest = max([1.0, *(value for line in rates.values() for rate in line for value in rate if np.isfinite(value))])
    below.set_xscale("symlog", linthresh=1)
    below.set_xlim(-0.15, 1.5 * highest)  # marks at 0 and at the highest rate are shown whole
    below.set_xticks([tick for tick in (0, 1, 10, 100, 1000) if tick <= 1.5 * highest])
    below.xaxis.set_major_formatter(lambda rate, _: f"{rate:g}")
    for axes in panels.values():
        grid(axes, "both")
        axes.tick_params(labelsize=SMALL)
    figure.suptitle("Errors and losses of the cameras in simulated trainings")
    for kind, line in _LINES.items():
        below.plot([], [], color="black", ls=line, lw=1.4, label=kind)
    goals = f"goals: 1 pixel and 3 degrees, {100 * _RARE:g} % of regions"
    below.plot([], [], color=COLOURS[2], lw=1, label=goals)
    legend(figure, below, columns=3)
    return figure


def frame_figure(seed: int) -> "Figure":
    """Part of a frame of a training: as rendered, and with the tracker's regions drawn on it."""
    # Beside the corridors, so that a cable passes over the other robot's marker (3.7).
    training, tracker = RenderedTraining(seed, anchor=(1690.0, 1640.0)), Tracker()
    for _ in range(25):  # the robots are on their way to the food
        frame, _ = training.newest()
        scene = tracker.update(frame)
    training.close()
    rows, columns, enlargement = slice(165, 305), slice(240, 400), 4
    drawn = draw_scene(frame.repeat(enlargement, axis=0).repeat(enlargement, axis=1), scene)
    shown = (slice(enlargement * side.start, enlargement * side.stop) for side in (rows, columns))
    figure = new_figure(WIDTH, 4.1)
    left, right = figure.subplots(1, 2)
    # Without smoothing: the frame has no finer detail than its pixels.
    left.imshow(frame[rows, columns], cmap="gray", vmin=0, vmax=255, interpolation="nearest")
    right.imshow(drawn[tuple(shown)])
    titles = "Rendered frame, 5 mm a pixel", "The tracker's regions"
    for axes, title in zip((left, right), titles, strict=True):
        axes.set_title(title, fontsize=10)
        axes.set_axis_off()
    names = {
        "robot's marker: number of the region, and of the marker; arrow: heading": MARKER,
        "food: number of the region": FOOD,
    }
    for name, (red, green, blue) in names.items():
        right.plot([], [], color=(red / 255, green / 255, blue / 255), lw=2, label=name)
    legend(figure, right, columns=2)
    return figure


def _add_arguments(parser: argparse.ArgumentParser) -> None:
    text = "one part; may be given several times (all)"
    parser.add_argument("--only", action="append", choices=PARTS, help=text)


def main() -> int:
    """Run the benchmark."""
    given = parse("tracker", __doc__, *COUNTS, add=_add_arguments)
    seed, quick = given.seed, given.quick
    repeats = SPEED_REPEATS[quick]
    tables = {Observation: "observations", Rate: "speeds", SweepPoint: "limits", Trouble: "troubles"}
    units = {
        SPEED: [Job(SPEED, speeds, (seed, SPEED_FRAMES[quick], repeats))],
        LIMITS: [
            Job(f"limit {name}, {curve}", limit_points, (name, curve, seed, given.frames, quick))
            for name, sweep in SWEEPS.items()
            for curve in sweep.curves
        ],
        TRAININGS: [
            Job(f"training {number}", observed_training, (number, seed, given.rounds))
            for number in range(given.trainings)
        ],
        TROUBLES: [
            Job(f"troubles {width} x {height}, {kind}", troubled_drive, (width, height, kind, given.troubled, seed))
            for width, height, kind in SETUPS
        ],
    }
    chosen = [part for part in PARTS if part in (given.only or PARTS)]
    parts: list[Table | Picture] = []
    if SPEED in chosen:  # first, while nothing else runs
        parts.append(speed_table(collect(given, units[SPEED], tables, in_processes(1)).of(Rate), repeats))
        given.fresh = False
    rows = collect(given, [unit for part in chosen if part != SPEED for unit in units[part]], tables)
    observations, points = rows.of(Observation), rows.of(SweepPoint)
    if points:
        caption = "found markers and food up to failure"
        parts += [limits_table(points), Picture("limits", caption, limits_picture(points))]
    if observations:
        parts += [
            Picture("frame", "a frame with the tracker's regions", frame_figure(seed)),
            model_table(observations),
            Picture("tracker", "errors and losses", errors_figure(observations)),
        ]
    if TROUBLES in chosen:
        parts.append(troubles_table(rows.of(Trouble)))
    return finish(given, Page("The tracker", parts))


if __name__ == "__main__":
    sys.exit(main())
