"""The further work that the thesis names: one small experiment a question, with claims, intervals and a picture.

    python benchmarks/further_work.py --help

Each experiment is a file in `benchmarks/further_experiments/`. Its page, picture, tables and rows go to a folder of its
name.
"""

import argparse
import sys

import numpy as np
from further_experiments import (
    action_level,
    alternatives,
    attribute_weights,
    chains_of_learners,
    different_robots,
    human_teacher,
    push_and_avoid,
    several_learners,
    spatial_variety,
    state_vector,
)
from further_experiments.analysis import Analysis
from further_experiments.experiment import Size
from further_experiments.rows import TABLES, RecallEpisode, TrainingEpisode

from khepera_forage.study import Count, collect, parse, write

EXPERIMENTS = {
    module.EXPERIMENT.name: module.EXPERIMENT
    for module in (
        push_and_avoid,
        attribute_weights,
        spatial_variety,
        state_vector,
        action_level,
        different_robots,
        chains_of_learners,
        human_teacher,
        alternatives,
        several_learners,
    )
}
"""In the order of the pages. To add an experiment, add a file and a line here."""
QUICK = Size(files=2, recalls=1, generations=2, attempts=25, patience=2, steps=250, rounds=250)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The arguments of this script alone."""
    text = "one experiment; may be given several times (all)"
    parser.add_argument("--only", action="append", choices=list(EXPERIMENTS), help=text)


def main() -> int:
    """Run the experiments."""
    replications = Count(
        "replications",
        20,
        1,
        "repetitions of each experiment, new training files included",
        adds_units=True,
    )
    given = parse("further_work", __doc__, replications, add=add_arguments)
    size = QUICK if given.quick else Size()
    results = given.out
    for name in given.only or EXPERIMENTS:
        experiment = EXPERIMENTS[name]
        given.out = results / name
        rows = collect(given, experiment.trials(given.seed, given.replications, size), TABLES)
        rng = np.random.default_rng(given.seed)
        report = experiment.report(Analysis(rows.of(TrainingEpisode), rows.of(RecallEpisode), rng))
        written = experiment.page(report)
        write(given.out, name, written)
        print(f"# {experiment.title}: {experiment.question}\n")
        print("\n".join(table.markdown() for table in written.tables))
    print(f"Pages, pictures, tables and rows are in {results}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
