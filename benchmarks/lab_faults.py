"""Faults of robots, cables, camera and disk in the middle of whole trainings in the virtual laboratory.

    python benchmarks/lab_faults.py --help

A `lab.toml` with three robots and a camera; real drivers, fleet, video source, tracker and files. In every series of
trainings each kind of fault happens once, in a random round. For each fault: whether the robots stopped, what the user
read, what is on disk, and whether the training went on.
"""

import sys

from laboratory_faults import page
from laboratory_faults.campaign import series
from laboratory_faults.injector import PAUSE, QUICK_PAUSE
from laboratory_faults.kinds import KINDS
from laboratory_faults.rows import FaultRow, TrainingResult

from khepera_forage.estimates import Table
from khepera_forage.study import Count, Page, Picture, collect, finish, parse

COUNT = Count("series", 34, 1, f"series of trainings, each with {len(KINDS)} faults", adds_units=True)
QUICK = 3
"""Every third kind of fault, with --quick."""
TABLES = {FaultRow: "faults", TrainingResult: "trainings"}


def main() -> int:
    """Run the benchmark."""
    # Drivers wait for lost robots most of the time.
    given = parse("lab_faults", __doc__, COUNT, jobs=-1)
    kinds, pause = (KINDS[::QUICK], QUICK_PAUSE) if given.quick else (KINDS, PAUSE)
    rows = collect(given, series(given.series, given.seed, kinds, pause), TABLES)
    faults, trainings = rows.of(FaultRow), rows.of(TrainingResult)
    parts: list[Table | Picture] = [
        page.robot_table(faults),
        page.experience_table(faults),
        page.training_table(trainings),
        page.notice_table(faults),
        Picture(
            "lab_faults", "seconds until a fault is noticed, and wheels without control", page.picture(faults)
        ),
    ]
    return finish(given, Page("Faults in the laboratory", parts))


if __name__ == "__main__":
    sys.exit(main())
