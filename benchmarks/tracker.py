"""The tracker on rendered frames, compared with the simulated camera.

    python benchmarks/tracker.py --help

Speed on one core; curves of what is found as cables, blur, exposure, contrast and noise become worse, up to failure;
errors of calibrations by number of points and lens; errors of centre and heading over random scenes, in several
appearances; and trainings in simulation that all cameras observe: rates and lengths of losses, jitter, reversals,
swapped labels. A frame with the tracker's regions drawn on it is saved, too.
"""

import sys
from typing import TYPE_CHECKING

from tracker_accuracy import hole_layouts, lenses, page, pictures
from tracker_accuracy.hole_layouts import LAYOUTS, HoleCount, Layout
from tracker_accuracy.lenses import Lenses, Trial
from tracker_accuracy.limits import SWEEPS, Limit, Point
from tracker_accuracy.limits_page import limits_picture, limits_table
from tracker_accuracy.observations import Observation, Phantoms
from tracker_accuracy.scenes import APPEARANCES, Scenes
from tracker_accuracy.speed import Rate, Speed
from tracker_accuracy.trainings import ObservedTraining

from khepera_forage.estimates import Table
from khepera_forage.rollouts.rendered_training import RenderedTraining
from khepera_forage.study import Count, Page, Picture, Unit, collect, finish, in_processes, parse
from khepera_forage.vision.overlay import draw_scene
from khepera_forage.vision.tracker import Tracker

if TYPE_CHECKING:
    from matplotlib.figure import Figure

COUNTS = (
    Count("scenes", 1000, 30, "random scenes of each appearance"),
    Count("trainings", 60, 2, "trainings to observe", adds_units=True),
    Count("rounds", 500, 150, "rounds of each"),
    Count("frames", 20, 1, "frames of each point of a curve, with 20 markers each"),
    Count("trials", 20, 1, "calibrations of each lens and layout of points"),
)
TABLES = {
    Observation: "observations",
    Phantoms: "phantoms",
    HoleCount: "hole_layouts",
    Rate: "speeds",
    Point: "limits",
    Trial: "calibrations",
}
FRAMES, REPEATS, IMAGES = 200, 5, 20
QUICK_FRAMES, QUICK_REPEATS, QUICK_IMAGES = 20, 2, 1
"""Frames and repeats of the speed; images of each layout of holes."""
_SHOWN = 25
"""Round of a training that the picture shows: the robots are on their way to the food."""
_ANCHOR = (1690.0, 1640.0)
"""mm: beside the corridors, so that a cable passes over the other robot's marker (3.7)."""
_CROP, _ENLARGEMENT = (slice(165, 305), slice(240, 400)), 4


def frame_picture(seed: int) -> "Figure":
    """Part of a frame of a training: as rendered, and with the tracker's regions drawn on it."""
    training, tracker = RenderedTraining(seed, anchor=_ANCHOR), Tracker()
    for _ in range(_SHOWN):
        frame, _ = training.newest()
        scene = tracker.update(frame)
    training.close()
    part = tuple(slice(_ENLARGEMENT * side.start, _ENLARGEMENT * side.stop) for side in _CROP)
    return pictures.frame_figure(frame[_CROP], draw_scene(frame, scene, enlargement=_ENLARGEMENT)[part])


def main() -> int:
    """Run the benchmark."""
    given = parse("tracker", __doc__, *COUNTS)
    seed = given.seed
    frames, repeats, images = (
        (QUICK_FRAMES, QUICK_REPEATS, QUICK_IMAGES) if given.quick else (FRAMES, REPEATS, IMAGES)
    )
    # Speed first, while nothing else runs.
    speeds = collect(given, [Speed(seed, frames, repeats)], TABLES, in_processes(1))
    units: list[Unit] = [
        *(Scenes(appearance, seed, given.scenes) for appearance in APPEARANCES),
        *(ObservedTraining(number, seed, given.rounds) for number in range(given.trainings)),
        *(Layout(name, seed, images) for name in LAYOUTS),
        *(
            Limit(n, curve, seed, given.frames, given.quick)
            for n, sweep in SWEEPS.items()
            for curve in sweep.curves
        ),
        *(Lenses(layout, seed, given.trials, given.quick) for layout in lenses.LAYOUTS),
    ]
    given.fresh = False
    rows = collect(given, units, TABLES)
    found = page.Observed(rows.of(Observation), rows.of(Phantoms), speeds.of(Rate))
    parts: list[Table | Picture] = [
        page.speed_table(found, frames),
        limits_table(rows.of(Point)),
        Picture(
            "limits", "found markers and food up to failure", limits_picture(rows.of(Point), rows.of(Trial))
        ),
        lenses.table(rows.of(Trial)),
        page.accuracy_table(found),
        page.model_table(found),
        hole_layouts.table(rows.of(HoleCount)),
        Picture("tracker", "errors and losses", pictures.errors_figure(found.observations)),
        Picture("frame", "a frame with the tracker's regions", frame_picture(seed)),
    ]
    return finish(given, Page("The tracker", parts))


if __name__ == "__main__":
    sys.exit(main())
