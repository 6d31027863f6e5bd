"""`khepera-forage infer`: which readings of the thesis do its own tables support?"""

import argparse

from khepera_forage.cli.arguments import refuse_ignored
from khepera_forage.extras import require
from khepera_forage.option_values import given_path
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

Writes a page with all tables and two pictures. Ten thousand sets take some hours; a run that was killed continues.

--tables infers from the tables of another experiment in seconds, with simulated sets that the package contains, and
writes its page to a folder of the results' folder. Such an experiment, a pseudo-thesis under known decisions:

    khepera-forage reproduce --replications 1 --decision next_to_food=20 --out pseudo
    khepera-forage infer --tables pseudo/recalls.csv"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command's arguments."""
    parser.description = DESCRIPTION
    parser.formatter_class = argparse.RawDescriptionHelpFormatter
    add_study_arguments(parser, NAME, *COUNTS)
    parser.add_argument(
        "--tables",
        type=given_path,
        metavar="FILE",
        help="infer from these tables of the corridor, with the simulated sets of the package: recalls.csv of "
        "'khepera-forage reproduce', a file like the package's thesis/appendix_a.csv, or 'thesis' for the thesis's own",
    )
    parser.set_defaults(program="khepera-forage infer")


def run(arguments: argparse.Namespace) -> int:
    """Infer, write the page and print its tables.

    Raises:
        ValueError: Tables of another form, or an option without effect.
        ImportError: numba or matplotlib is not installed.
    """
    require("khepera-forage infer", "fast", "plots")
    from khepera_forage.thesis.inference.page import page, tables_page
    from khepera_forage.thesis.inference.simulate import KEPT, Sets, draw
    from khepera_forage.thesis.inference.summary import (
        fitted_columns,
        tables_statistics,
        thesis_statistics,
    )

    if arguments.tables:
        options = ["--sets", "--experiments", "--quick", "--fresh"]
        refuse_ignored(arguments, options, "without --tables, which uses simulated sets of the package")
        own = str(arguments.tables) == "thesis"
        given = completed(arguments, *COUNTS)
        observed = thesis_statistics()[fitted_columns()] if own else tables_statistics(arguments.tables)
        given.out, given.name = given.out / arguments.tables.stem, "tables"
        return finish(given, tables_page(given, Sets.load(), observed, f"the tables of {arguments.tables}"))
    given = completed(arguments, *COUNTS)
    drawn = draw(given, given.sets, given.experiments)
    drawn.sets.save(given.out / KEPT)
    return finish(given, page(given, drawn))
