"""The further work that the thesis names: one small experiment a question, with claims, intervals and a picture.

    python benchmarks/further_work.py --help

The experiments are in `benchmarks/further_experiments/`. Page, picture, tables and rows of each go to a folder of its
name.
"""

import argparse
import sys
from shutil import get_terminal_size

from further_experiments.common import TABLES, Analysis, EpisodeRow, ExperimentSize, RecallEpisode
from further_experiments.memory import ALTERNATIVES, ATTRIBUTE_WEIGHTS
from further_experiments.perception import ACTION_LEVEL, STATE_VECTOR
from further_experiments.teachers import CHAINS_OF_LEARNERS, HUMAN_TEACHER, SEVERAL_LEARNERS
from further_experiments.training import DIFFERENT_ROBOTS, PUSH_AND_AVOID, SPATIAL_VARIETY

from khepera_forage.study import Count, collect, parse, write

EXPERIMENTS = {
    experiment.name: experiment
    for experiment in (
        PUSH_AND_AVOID,
        ATTRIBUTE_WEIGHTS,
        SPATIAL_VARIETY,
        STATE_VECTOR,
        ACTION_LEVEL,
        DIFFERENT_ROBOTS,
        CHAINS_OF_LEARNERS,
        HUMAN_TEACHER,
        ALTERNATIVES,
        SEVERAL_LEARNERS,
    )
}
"""In the order of the pages. To add an experiment, add it to a file of the folder, and a line here."""
QUICK = ExperimentSize(files=2, recalls=1, generations=2, patience=2, steps=250, rounds=200)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The arguments of this script alone."""
    text = "one experiment; may be given several times (all)"
    parser.add_argument("--only", action="append", choices=list(EXPERIMENTS), help=text)


def main() -> int:
    """Run the experiments."""
    replications = Count(
        "replications", 20, 1, "repetitions of each experiment, new training files included", adds_units=True
    )
    given = parse("further_work", __doc__, replications, add=add_arguments)
    size = QUICK if given.quick else ExperimentSize()
    results = given.out
    for name in given.only or EXPERIMENTS:
        experiment = EXPERIMENTS[name]
        given.out = results / name
        rows = collect(given, experiment.jobs(given.seed, given.replications, size), TABLES)
        written = experiment.page(Analysis(rows.of(EpisodeRow), rows.of(RecallEpisode), given.seed))
        write(given.out, name, written)
        print(f"# {experiment.title}: {experiment.question}\n")
        print("\n".join(table.text(get_terminal_size().columns) for table in written.tables))
    print(f"Pages, pictures, tables and rows are in {results}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
