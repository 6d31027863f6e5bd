"""The tracker on rendered frames: what it finds, and how exactly and how fast.

    python benchmarks/tracker.py --help

Curves of what is found as cables, blur, exposure, contrast and noise become worse, up to failure; trainings in
simulation that it observes: jitter, reversals and losses; and drives through glare, shadows, hands and other troubles
at three resolutions, with its speed.
"""

import math
import sys
from collections.abc import Sequence
from typing import TYPE_CHECKING

import cv2
import numpy as np
from laboratory.limits import CURVES, SWEEPS, WIDTH_SWEEP, SweepPoint, limit_points, limits_picture, limits_table
from laboratory.observations import ATTEMPT, KINDS, Observation, loss_rate, observe, offsets, reversals, turns
from laboratory.troubles import SETUPS, Trouble, troubled_drive, troubles_table
from numpy.typing import NDArray

from khepera_forage.estimates import Estimate, Table, Value, pick, table_of, wilson
from khepera_forage.figures import SMALL, WIDTH, new_figure
from khepera_forage.noise import Noise
from khepera_forage.rollouts.rendered_training import RenderedTraining
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
SIMULATED, OURS = "simulated camera", "tracker on rendered frames"
_ANCHOR = 400.0
"""Cables hang from a point within this many mm, along each axis, of the middle of both arenas. In the middle itself
they would hang between the arenas and cross nothing."""


def observed_training(number: int, seed: int, rounds: int) -> list[Observation]:
    """Two robots forage, one following the other, for some rounds, in as many attempts as that takes."""
    cv2.setNumThreads(1)
    rng = np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(number,)))
    training = RenderedTraining(int(rng.integers(2**31)))
    middle = training.anchor
    training.close()
    x, y = rng.uniform(-_ANCHOR, _ANCHOR, 2).tolist()
    training = RenderedTraining(int(rng.integers(2**31)), anchor=(middle[0] + x, middle[1] + y))
    tracker, rows, attempts = Tracker(), list[Observation](), 0
    for frame in range(rounds):
        picture, _ = training.newest()
        if training.attempts != attempts:
            attempts = training.attempts
            tracker.reset()
        place = number, frame + ATTEMPT * attempts
        rows += observe(place, training.world.truth(), tracker.update(picture).regions)
    training.close()
    return rows


def training_table(rows: Sequence[Observation]) -> Table:
    """The tracker in the quantities of `Noise`, beside those of the simulated camera."""
    note = (
        "Trainings in simulation, one frame a round. Jitter: standard deviation of the error along an axis, of things "
        "that nothing hides; that of headings includes the rounding to whole degrees (0.29). Loss rate: a round; "
        "things hidden by a marker do not count, those under a cable do. Rates with Wilson's 95 % interval."
    )
    noise, by_kind = Noise.laboratory(), {kind: pick(rows, kind=kind) for kind in KINDS}
    rates = (noise.loss_rate_food, noise.loss_rate_one_hole, noise.loss_rate_two_holes)
    rounds, reversed_ = len({(row.training, row.frame) for row in rows}), reversals(rows)
    measured: list[tuple[str, float | str, Estimate | float]] = [
        *((f"position_jitter (px), {kind}", noise.position_jitter, _jitter(offsets(by_kind[kind]))) for kind in KINDS),
        *((f"heading_jitter (deg), {kind}", noise.heading_jitter, _jitter(turns(by_kind[kind]))) for kind in KINDS[1:]),
        ("reversal_rate", noise.reversal_rate, wilson(reversed_, reversed_ + len(turns(rows)))),
        *((f"loss rate, {k}", rate, loss_rate(by_kind[k])) for k, rate in zip(KINDS, rates, strict=True)),
        ("regions of nothing, a round", "", len(pick(rows, kind="")) / rounds),
        ("rounds", "", rounds),
    ]
    lines: list[dict[str, Value]] = [
        {"quantity": name, SIMULATED: told, OURS: value if isinstance(value, Estimate) else Estimate(value)}
        for name, told, value in measured
    ]
    return table_of("trainings", "Trainings", note, lines, {SIMULATED: 4, OURS: 4})


def _jitter(errors: NDArray[np.float64]) -> float:
    return float(errors.std()) if errors.size else math.nan


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
    figure = new_figure(WIDTH, 4.0)
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


def main() -> int:
    """Run the benchmark."""
    given = parse("tracker", __doc__, *COUNTS, parts=PARTS)
    seed = given.seed
    units = {
        LIMITS: [
            Job(f"limit {sweep}, {curve}", limit_points, (sweep, curve, seed, given.frames, given.quick))
            for sweep in SWEEPS
            for curve in CURVES
            if (sweep, curve) != (WIDTH_SWEEP, "no cable")
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
    tables = {Observation: "observations", SweepPoint: "limits", Trouble: "troubles"}
    rows = collect(given, [unit for part in given.parts for unit in units[part]], tables)
    parts: list[Table | Picture] = []
    if LIMITS in given.parts:
        points = rows.of(SweepPoint)
        caption = "found markers and food up to failure"
        parts += [limits_table(points), Picture("limits", caption, limits_picture(points))]
    if TRAININGS in given.parts:
        observations = rows.of(Observation)
        parts += [
            Picture("frame", "a frame with the tracker's regions", frame_picture(seed)),
            training_table(observations),
        ]
    if TROUBLES in given.parts:
        parts.append(troubles_table(rows.of(Trouble)))
    return finish(given, Page("The tracker", parts))


if __name__ == "__main__":
    sys.exit(main())
