"""The tracker on rendered frames, and the simulated camera beside it.

    python benchmarks/tracker.py --help

Speed on one core; errors of centre and heading over random scenes, under several looks of the picture; and trainings in
simulation that all cameras watch: rates and lengths of losses, jitter, reversals, slips of identity. A frame with
the tracker's regions drawn on it is saved too.
"""

import argparse
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TypeVar

import cv2
import numpy as np
from _tracker import markers
from _tracker.drives import Drive
from _tracker.looks import CONDITIONS, LABORATORY, Scenes
from _tracker.page import Looks, accuracy_table, model_table, picture, speed_table
from _tracker.sights import BARE, MODEL, TRACKER, Sight
from _tracker.speed import frames_a_second
from arguments import add_count, count_of, parser_for
from joblib import Parallel, delayed
from numpy.typing import NDArray
from tqdm import tqdm

from khepera_forage.rollouts.rendered_training import RenderedTraining
from khepera_forage.rollouts.row_files import write_rows
from khepera_forage.thesis.figures import save
from khepera_forage.thesis.tables import Table
from khepera_forage.vision.overlay import draw_scene
from khepera_forage.vision.tracker import Tracker

SCENES, QUICK_SCENES = 1000, 30
DRIVES, QUICK_DRIVES = 60, 2
ROUNDS, QUICK_ROUNDS = 500, 150
FRAMES, REPEATS = 200, 5
PICTURES = 20
"""Of each layout of holes, with 25 markers each."""
STEM = "tracker"
_SHOWN = 25
"""Round of a training that the picture shows: the robots are on their way to the food."""
_ANCHOR = (1690.0, 1640.0)
"""mm: beside the corridors, so that a cable passes over the other robot's marker (3.7)."""
_CROP, _LARGER = (slice(165, 305), slice(240, 400)), 5
_Result = TypeVar("_Result")


def at_work(work: Sequence[Callable[[], _Result]], jobs: int, what: str) -> list[_Result]:
    """Do the work; results come in its order, whatever the number of processes."""
    running = Parallel(n_jobs=jobs, return_as="generator")(delayed(piece)() for piece in work)
    return list(tqdm(running, total=len(work), desc=what, disable=not sys.stderr.isatty()))


def shown(seed: int) -> NDArray[np.uint8]:
    """Part of a frame of a training, enlarged: as the camera gives it, and with the tracker's regions drawn on it."""
    training, tracker = RenderedTraining(seed, anchor=_ANCHOR), Tracker()
    for _ in range(_SHOWN):
        frame, _ = training.newest()
        scene = tracker.update(frame)
    training.close()
    both = [np.repeat(frame[:, :, None], 3, axis=2)[_CROP], draw_scene(frame, scene)[_CROP]]
    larger = [cv2.resize(half, None, fx=_LARGER, fy=_LARGER, interpolation=cv2.INTER_CUBIC) for half in both]
    return np.concatenate(larger).astype(np.uint8)


def write(folder: Path, tables: Sequence[Table], looks: Looks, drives: Sequence[Sight], seed: int) -> str:
    """Write tables, rows and pictures.

    Returns:
        The page with the tables.
    """
    folder.mkdir(parents=True, exist_ok=True)
    text = "\n".join(table.markdown() for table in tables)
    (folder / f"{STEM}.md").write_text(
        f"{text}\n![errors and losses]({STEM}.png)\n\n![a frame with the tracker's regions](frame.png)\n",
        encoding="utf-8",
    )
    for table in tables:
        (folder / f"{table.stem}.csv").write_text(table.csv(), encoding="utf-8")
    write_rows(folder / "drives.csv", Sight, drives)
    for name, (sights, _) in looks.items():
        stem = name.replace(" ", "_").replace(",", "").replace(".", "_")
        write_rows(folder / f"scenes_{stem}.csv", Sight, sights)
    save(picture(looks, LABORATORY, drives), folder / f"{STEM}.png")
    good, data = cv2.imencode(".png", cv2.cvtColor(shown(seed), cv2.COLOR_RGB2BGR))
    if not good:
        raise OSError("OpenCV cannot write a PNG")
    (folder / "frame.png").write_bytes(data.tobytes())
    return text


def run(arguments: argparse.Namespace) -> int:
    """Do what the arguments ask for."""
    quick = arguments.quick
    scenes = count_of(arguments.scenes, SCENES, quick, QUICK_SCENES)
    drives = count_of(arguments.drives, DRIVES, quick, QUICK_DRIVES)
    rounds = count_of(arguments.rounds, ROUNDS, quick, QUICK_ROUNDS)
    speeds = frames_a_second(arguments.seed, 40 if quick else FRAMES, 2 if quick else REPEATS)
    results = at_work(
        [Scenes(i, arguments.seed, scenes).run for i in range(len(CONDITIONS))], arguments.jobs, "looks"
    )
    looks = {name: (rows, phantoms) for name, rows, phantoms in results}
    driven = at_work([Drive(i, arguments.seed, rounds).run for i in range(drives)], arguments.jobs, "drives")
    sights = [row for rows, _ in driven for row in rows]
    phantoms = {camera: sum(count[camera] for _, count in driven) for camera in (TRACKER, MODEL, BARE)}
    pictures = 1 if quick else PICTURES
    layouts = [markers.Places(name, arguments.seed, pictures).run for name in markers.LAYOUTS]
    tables = (
        speed_table(*speeds, 40 if quick else FRAMES),
        accuracy_table(looks),
        model_table(sights, phantoms),
        markers.table(at_work(layouts, arguments.jobs, "markers")),
    )
    print(write(arguments.out, tables, looks, sights, arguments.seed))
    print(f"Tables, pictures and rows are in {arguments.out}")
    return 0


if __name__ == "__main__":
    parser = parser_for(__doc__, "results/tracker")
    add_count(parser, "--scenes", SCENES, QUICK_SCENES, "random scenes of each look")
    add_count(parser, "--drives", DRIVES, QUICK_DRIVES, "trainings to watch")
    add_count(parser, "--rounds", ROUNDS, QUICK_ROUNDS, "rounds of each")
    parser.add_argument("--jobs", type=int, default=-1, help="processes; -1 is one a core (-1)")
    sys.exit(run(parser.parse_args()))
