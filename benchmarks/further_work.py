"""The further work that the thesis names: one small experiment a question, with claims, intervals and a picture.

    python benchmarks/further_work.py --help

The experiments are in `benchmarks/further_experiments/`. Page, picture, tables and rows of each go to a folder of its
name.
"""

import sys

from further_experiments import memory, perception, teachers, training
from further_experiments.common import TABLES, Analysis, EpisodeRow, ExperimentSize, RecallEpisode

from khepera_forage.study import Count, collect, finish, parse

EXPERIMENTS = {
    experiment.name: experiment
    for experiment in (
        training.PUSH_AND_AVOID,
        memory.ATTRIBUTE_WEIGHTS,
        training.SPATIAL_VARIETY,
        perception.STATE_VECTOR,
        perception.ACTION_LEVEL,
        training.DIFFERENT_ROBOTS,
        teachers.CHAINS_OF_LEARNERS,
        teachers.HUMAN_TEACHER,
        memory.ALTERNATIVES,
        teachers.SEVERAL_LEARNERS,
    )
}
"""In the order of the pages. To add an experiment, add it to a file of the folder, and a line here."""
QUICK = ExperimentSize(files=2, recalls=1, generations=2, patience=2, steps=250, rounds=200)


def main() -> int:
    """Run the experiments."""
    replications = Count(
        "replications", 20, 1, "repetitions of each experiment, new training files included", adds_units=True
    )
    given = parse("further_work", __doc__, replications, parts=EXPERIMENTS)
    size = QUICK if given.quick else ExperimentSize()
    results = given.out
    for name in given.parts:
        experiment, given.name, given.out = EXPERIMENTS[name], name, results / name
        rows = collect(given, experiment.jobs(given.seed, given.replications, size), TABLES)
        print(f"# {experiment.title}: {experiment.question}\n")
        finish(given, experiment.page(Analysis(rows.of(EpisodeRow), rows.of(RecallEpisode), given.seed)))
    return 0


if __name__ == "__main__":
    sys.exit(main())
