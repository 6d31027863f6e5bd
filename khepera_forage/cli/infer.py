"""`khepera-forage infer`: which readings of the thesis do its own tables support?"""

import argparse

from khepera_forage.extras import require
from khepera_forage.study import Count, add_study_arguments, completed, finish

NAME = "decisions"
"""Of the folder of results."""
COUNTS = (
    Count("sets", 10_000, 3, "admissible sets", adds_units=True, least=3),
    Count("experiments", 20, 2, "replications of the thesis's design under each set"),
)
DESCRIPTION = """Approximate Bayesian computation by random forests:

1. Sets of decisions are drawn from a prior with a source for every range. A set is admissible if the teacher can do
   under it what the thesis says of it. Under each admissible set, the thesis's whole design is replicated.
2. A random forest learns from these sets what statistics of the corridor's tables say about each decision. It is first
   validated on sets that it has not seen, and then given tables A.1 to A.4. Tables A.5 to A.7 are the test set.

Writes a page with all tables and two pictures. Ten thousand sets take some hours; a run that was killed continues."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command's arguments."""
    parser.description = DESCRIPTION
    parser.formatter_class = argparse.RawDescriptionHelpFormatter
    add_study_arguments(parser, NAME, *COUNTS)
    parser.set_defaults(program="khepera-forage infer")


def run(arguments: argparse.Namespace) -> int:
    """Infer, write the page and print its tables.

    Raises:
        ImportError: numba, SALib or matplotlib is not installed.
    """
    require("khepera-forage infer", "fast", "inference", "plots")
    from khepera_forage.thesis.inference.page import page
    from khepera_forage.thesis.inference.simulate import draw

    given = completed(arguments, *COUNTS)
    return finish(given, page(given, draw(given, given.sets, given.experiments)))
