"""The tracker on rendered frames, compared with the simulated camera.

    python benchmarks/tracker.py --help

Curves of what is found as cables, blur, exposure, contrast and noise become worse, up to failure; trainings in
simulation that both cameras observe: jitter, reversals, losses, swapped labels; and drives through glare, shadows,
hands and other troubles at three resolutions, with their speed.
"""

import argparse
import math
import sys
from collections.abc import Callable, Iterable, Sequence
from typing import TYPE_CHECKING

import cv2
import numpy as np
from laboratory.limits import SWEEPS, SweepPoint, limit_points, limits_picture, limits_table
from laboratory.observations import (
    ATTEMPT,
    KINDS,
    MODEL,
    TRACKER,
    Observation,
    loss_rate,
    observe,
    offsets,
    reversals,
    swapped_labels,
    turns,
)
from laboratory.troubles import SETUPS, Trouble, troubled_drive, troubles_table
from numpy.typing import NDArray

from khepera_forage.estimates import Estimate, Table, Value, pick, table_of, wilson
from khepera_forage.figures import COLOURS, OURS, SMALL, THESIS, WIDTH, grid, legend, new_figure, panels
from khepera_forage.noise import Noise
from khepera_forage.rollouts.rendered_training import RenderedTraining
from khepera_forage.sim.sensing import OverheadCamera
from khepera_forage.study import Count, Job, Page, Picture, collect, finish, parse
from khepera_forage.vision.overlay import draw_scene
from khepera_forage.vision.tracker import Tracker

if TYPE_CHECKING:
    from matplotlib.figure import Figure

PARTS = LIMITS, TRAININGS, TROUBLES = ("limits", "trainings", "troubles")
COUNTS = (
    Count("trainings", 60, 1, "trainings to observe", adds_units=True),
    Count("rounds", 500, 100, "rounds of each"),
    Count("frames", 20, 1, "frames of each point of a curve, with 20 markers each"),
    Count("troubled", 1000, 5, "frames with and without trouble at each resolution"),
)
_ANCHOR = 400.0
"""Cables hang from a point within this many mm, along each axis, of the middle of both arenas. In the middle itself
they would hang between the arenas and cross nothing."""
CAMERAS = {MODEL: "model, measured", TRACKER: "tracker on rendered frames"}


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
        for camera, scene in ((TRACKER, tracker.update(picture)), (MODEL, model.look())):
            rows += observe((camera, number, frame + ATTEMPT * attempts), training.world.truth(), scene.regions)
    training.close()
    return rows


def model_table(rows: Sequence[Observation]) -> Table:
    """The simulated camera beside the tracker, in the quantities of `Noise`."""
    note = (
        "Trainings in simulation, observed by both cameras with the same anchor of the cables, one frame a round. The "
        "first column is the model's parameter, the second the same quantity measured on the model, under cables too. "
        "Jitter: standard deviation of the error along an axis, of things that nothing hides; that of headings "
        "includes the rounding to whole degrees (0.29), which the model applies after its jitter. Loss rate: a round; "
        "things hidden by a marker do not count. Rates with Wilson's 95 % interval."
    )
    noise = Noise.laboratory()
    by_camera = {name: pick(rows, camera=camera) for camera, name in CAMERAS.items()}
    lines: list[dict[str, Value]] = []

    def add(
        name: str, told: float | str, measure: Callable[[list[Observation]], Estimate | float], kind: str = ""
    ) -> None:
        line: dict[str, Value] = {"quantity": f"{name}, {kind}" if kind else name, "Noise.laboratory()": told}
        for column, own in by_camera.items():
            value = measure(pick(own, kind=kind) if kind else own)
            line[column] = value if isinstance(value, Estimate) else Estimate(value)
        lines.append(line)

    for kind in KINDS:
        add("position_jitter (px)", noise.position_jitter, lambda own: _deviation(offsets(own)), kind)
    for kind in KINDS[1:]:
        add("heading_jitter (deg)", noise.heading_jitter, lambda own: _deviation(turns(own)), kind)
    add("reversal_rate", noise.reversal_rate, lambda own: wilson(reversals(own), reversals(own) + len(turns(own))))
    rates = (noise.loss_rate_food, noise.loss_rate_one_hole, noise.loss_rate_two_holes)
    for kind, rate in zip(KINDS, rates, strict=True):
        add("loss rate", rate, loss_rate, kind)
    add("labels that changed things", "", swapped_labels)
    add("regions of nothing, a round", "", lambda own: len(pick(own, kind="")) / max(1, _rounds(own)))
    add("rounds", "", _rounds)
    digits = dict.fromkeys(("Noise.laboratory()", *by_camera), 4)
    return table_of("model", "The simulated camera and the tracker", note, lines, digits)


def _deviation(values: NDArray[np.float64]) -> float:
    return float(values.std()) if values.size else math.nan


def _rounds(rows: Iterable[Observation]) -> float:
    return len({(row.training, row.frame) for row in rows})


def errors_picture(rows: Sequence[Observation]) -> "Figure":
    """Errors of both cameras in trainings as curves."""
    figure, axes = panels(2, "Errors of the cameras in simulated trainings")
    for camera, colour in ((TRACKER, OURS), (MODEL, THESIS)):
        for kind, line in zip(KINDS, (":", "-", "--"), strict=True):
            own = pick(rows, camera=camera, kind=kind)
            for panel, errors in zip(axes, (np.hypot(*offsets(own).T), np.abs(turns(own))), strict=True):
                share = 1 - np.arange(len(errors)) / max(1, len(errors))
                panel.step(np.sort(errors), share, color=colour, ls=line, lw=1.4, label=f"{CAMERAS[camera]}, {kind}")
    for panel, what, goal in zip(axes, ("centre (pixels)", "heading (degrees)"), (1.0, 3.0), strict=True):
        panel.set(yscale="log", ylim=(1e-4, 1.2), xlim=(0, 2.5 * goal), xlabel=f"error of the {what} above")
        panel.axvline(goal, color=COLOURS[2], lw=1, label="goal")
        grid(panel, "both")
    axes[0].set_ylabel("share of found regions")
    legend(figure, axes[0], columns=3)
    return figure


def frame_picture(seed: int) -> "Figure":
    """Part of a frame of a training: as rendered, and with the tracker's regions drawn on it."""
    # Beside the corridors, so that a cable passes over the other robot's marker (3.7).
    training, tracker = RenderedTraining(seed, anchor=(1690.0, 1640.0)), Tracker()
    for _ in range(25):  # the robots are on their way to the food
        frame, _ = training.newest()
        scene = tracker.update(frame)
    training.close()
    rows, columns, enlargement = (165, 305), (240, 400), 4
    large = frame.repeat(enlargement, axis=0).repeat(enlargement, axis=1)
    figure = new_figure(WIDTH, 3.8)
    titles = "Rendered frame, 5 mm a pixel", "The tracker's regions"
    for axes, title, image in zip(figure.subplots(1, 2), titles, (large, draw_scene(large, scene)), strict=True):
        top, bottom, left, right = (enlargement * place for place in (*rows, *columns))
        # Without smoothing: the frame has no finer detail than its pixels.
        axes.imshow(image[top:bottom, left:right], cmap="gray", vmin=0, vmax=255, interpolation="nearest")
        axes.set_title(title, fontsize=10)
        axes.set_axis_off()
    note = "red: a robot's marker, its region's and its own number, and heading; green: food, its region's number"
    figure.supxlabel(note, fontsize=SMALL)
    return figure


def _add_arguments(parser: argparse.ArgumentParser) -> None:
    text = "one part; may be given several times (all)"
    parser.add_argument("--only", action="append", choices=PARTS, help=text)


def main() -> int:
    """Run the benchmark."""
    given = parse("tracker", __doc__, *COUNTS, add=_add_arguments)
    seed = given.seed
    units = {
        LIMITS: [
            Job(f"limit {name}, {curve}", limit_points, (name, curve, seed, given.frames, given.quick))
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
    tables = {Observation: "observations", SweepPoint: "limits", Trouble: "troubles"}
    rows = collect(given, [unit for part in chosen for unit in units[part]], tables)
    parts: list[Table | Picture] = []
    if LIMITS in chosen:
        points = rows.of(SweepPoint)
        caption = "found markers and food up to failure"
        parts += [limits_table(points), Picture("limits", caption, limits_picture(points))]
    if TRAININGS in chosen:
        observations = rows.of(Observation)
        parts += [
            Picture("frame", "a frame with the tracker's regions", frame_picture(seed)),
            model_table(observations),
            Picture("tracker", "errors of the cameras", errors_picture(observations)),
        ]
    if TROUBLES in chosen:
        parts.append(troubles_table(rows.of(Trouble)))
    return finish(given, Page("The tracker", parts))


if __name__ == "__main__":
    sys.exit(main())
