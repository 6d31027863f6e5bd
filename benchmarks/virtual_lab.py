"""The virtual laboratory: the effects of real bytes and frames, the time of a round, and disturbed lines.

    python benchmarks/virtual_lab.py --help

Training and recall with real drivers on pseudo-terminals and the real tracker on rendered frames, compared with pymunk
alone; the time of a round, part by part; and every fault of a line at several rates. For each fault, the stored
experience is compared with what the learner was shown, and that with the truth.
"""

import os
import sys

from lab_comparison import comparison, page, pictures
from lab_comparison.episodes import Exclusion, LabRecall, LabTraining, Size, replications
from lab_comparison.fault_sums import fault_sums
from lab_comparison.faults import DisturbedAttempt, conditions
from lab_comparison.rounds import LOCK_STEP, PACED, TimedRound, Timing

from khepera_forage.estimates import Table
from khepera_forage.study import Count, Page, Picture, Unit, collect, finish, in_processes, parse

COUNTS = (
    Count("replications", 16, 1, "trainings and recalls, in each world", adds_units=True),
    Count("rounds", 1000, 25, "rounds with each fault at each rate"),
)
QUICK = Size(files=1, recalls=1, rounds=250, steps=400)
"""Of a replication with --quick."""
TIMED_ROUNDS = {LOCK_STEP: (1000, 60), PACED: (300, 30)}
"""Rounds whose time is measured, and their number with --quick."""
TABLES = {
    LabRecall: "recalls",
    LabTraining: "trainings",
    Exclusion: "exclusions",
    TimedRound: "rounds",
    DisturbedAttempt: "attempts",
}


def main() -> int:
    """Run the benchmark."""
    # Drivers wait most of the time: one process more than there are cores.
    given = parse("virtual_lab", __doc__, *COUNTS, jobs=1 + (os.cpu_count() or 1))
    timings = [Timing(pace, counts[given.quick], given.seed) for pace, counts in TIMED_ROUNDS.items()]
    timed = collect(given, timings, TABLES, in_processes(1)).of(TimedRound)
    units: list[Unit] = [
        *conditions(given.rounds, given.seed),
        *replications(given.replications, QUICK if given.quick else Size(), given.seed),
    ]
    given.fresh = False
    rows = collect(given, units, TABLES)
    exclusions = rows.of(Exclusion)
    compared = comparison.recalls(rows.of(LabRecall), exclusions)
    faults = fault_sums(rows.of(DisturbedAttempt))
    parts: list[Table | Picture] = [
        page.training_table(comparison.trainings(rows.of(LabTraining))),
        page.recall_table(compared, exclusions),
        Picture("recalls", "recalls in both worlds", pictures.recall_picture(compared)),
        page.round_table(timed),
        Picture("rounds", "the parts of a round", pictures.round_picture(timed)),
        page.fault_table(faults),
        page.experience_table(faults),
        Picture("faults", "effects of faults", pictures.fault_picture(faults)),
    ]
    return finish(given, Page("The virtual laboratory", parts))


if __name__ == "__main__":
    sys.exit(main())
