"""`khepera-forage compare`: all learners side by side, and yours among them."""

import argparse

from khepera_forage.cli.arguments import refuse_ignored
from khepera_forage.extras import require
from khepera_forage.sim.arenas.difficulty import DIFFICULTIES
from khepera_forage.sim.arenas.named import ARENAS
from khepera_forage.study import Count, add_study_arguments, completed

NAME = "learners"
"""Of the folder of results and of the page."""
COUNTS = (
    Count("seeds", 10, 2, "repetitions of everything, each with training files of its own", adds_units=True),
    Count("recalls", 10, 1, "recalls in each arena after each amount of learning"),
    Count("steps", 1_000_000, 1_000, "most environment steps of reinforcement learning"),
)
PROTOCOL_TRACKS = ("offline", "teaching", "wheels", "vocabulary")
WORKERS = ("loky", "ray", "dask")
DESCRIPTION = """How well each learner forages, and how much experience that took.

Imitators, learners that query the teacher, and reinforcement learning, each tested after growing amounts of learning.
A learner of your own joins them with --learner package.module:name, or for good as an entry point of its package (see
khepera_forage.policies.register_learner). The comparison of all learners takes hours; that of one imitator takes
minutes, and --against published shows the published results beside it. --quick is a smoke test. A run that was killed
continues."""
EPILOG = """example: khepera-forage compare --learner my_module:make_forest --against published"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command's arguments."""
    parser.description = DESCRIPTION
    parser.epilog = EPILOG
    parser.formatter_class = argparse.RawDescriptionHelpFormatter
    add_study_arguments(parser, NAME, *COUNTS)
    parser.add_argument("--list", action="store_true", help="list the learners that are known here, and end")
    text = "one learner of --list; may be given several times (all)"
    parser.add_argument("--only", action="append", metavar="NAME", help=text)
    text = (
        "a learner of your own, package.module:name of what makes a classifier; beside those of --only (teacher and "
        "imitator)"
    )
    parser.add_argument("--learner", action="append", metavar="PLACE", help=text)
    text = "a results.json to show beside this run's results, or 'published' for those of the package"
    parser.add_argument("--against", metavar="FILE", help=text)
    text = (
        "where learners are tested: named arenas, or procedural arenas of a difficulty (corridor rectangle)"
    )
    parser.add_argument("--arenas", nargs="+", metavar="NAME", choices=(*ARENAS, *DIFFICULTIES), help=text)
    parser.add_argument("--tune", action="store_true", help="compare settings of each learner instead")
    text = "the protocol forage-bench-1 (docs/protocol.md): fixed tracks, amounts, places and seeds"
    parser.add_argument("--protocol", action="store_true", help=text)
    text = "one track of the protocol; may be given several times (all)"
    parser.add_argument("--track", action="append", choices=PROTOCOL_TRACKS, help=text)
    text = "where the work is done: loky is this machine (loky)"
    parser.add_argument("--backend", choices=WORKERS, default="loky", help=text)
    parser.add_argument(
        "--address", help="of a Ray or Dask cluster (by default a temporary one on this machine)"
    )
    parser.set_defaults(program="khepera-forage compare")


def run(arguments: argparse.Namespace) -> int:
    """Compare, write page, tables, picture and `results.json`, and print the tables.

    Raises:
        ValueError: A learner or a file that cannot be used, or options that do not go together.
        ImportError: matplotlib is not installed.
    """
    from khepera_forage.comparison.compare import compare, known_learners, tune, unavailable

    if arguments.list:
        print(known_learners())
        return 0
    require("khepera-forage compare", "plots")
    if reason := unavailable(arguments.backend, arguments.address):
        raise ValueError(reason)
    if arguments.protocol:
        refuse_ignored(
            arguments, ["--against", "--arenas", "--tune", "--recalls", "--steps"], "without --protocol"
        )
        require("khepera-forage compare --protocol", "fast")
    else:
        refuse_ignored(arguments, ["--track"], "with --protocol")
    arguments.seeds_given = arguments.seeds is not None
    given = completed(arguments, *COUNTS)
    if given.tune:
        refuse_ignored(given, ["--learner", "--against", "--arenas"], "without --tune")
        return tune(given)
    return compare(given)
