"""`khepera-forage compare`: all learners side by side, and yours among them."""

import argparse
from pathlib import Path

from khepera_forage.cli.options import command, flag, option, refuse_ignored
from khepera_forage.comparison import PROTOCOL, TRACKS
from khepera_forage.extras import require
from khepera_forage.sim.arenas.difficulty import DIFFICULTIES
from khepera_forage.sim.arenas.named import ARENAS
from khepera_forage.study import Count, add_study_arguments, completed

COUNTS = (
    Count("seeds", 10, 2, "repetitions of everything, each with training files of its own", adds_units=True),
    Count("recalls", 10, 1, "recalls in each arena after each amount of learning"),
    Count("steps", 1_000_000, 1_000, "most environment steps of reinforcement learning"),
)
DESCRIPTION = """How well each learner forages, and how much experience that took.

Imitators, learners that query the teacher, and reinforcement learning, each
tested after growing amounts of learning. A learner of your own joins them with
--learner package.module:name, or for good as an entry point of its package
(see khepera_forage.policies.register_learner). The comparison of all learners
takes half an hour on two cores; that of one imitator takes a minute, and
--against published shows the published results beside it. --quick is a smoke
test. A run that was killed continues."""


_LEARNER = """a learner of your own, package.module:name of what makes a classifier; beside those of --only (teacher and
imitator)"""
_AGAINST = "a results.json to show beside this run's results, or 'published' for those of the package"
_ARENAS = """where learners are tested: named arenas, or procedural arenas of a difficulty; in others than the thesis's
only after all of the learning (corridor rectangle)"""
_BACKEND = "where the work is done: loky is this machine (loky)"


def _add_study(parser: argparse.ArgumentParser) -> None:
    add_study_arguments(parser, "learners", *COUNTS)
    parser.set_defaults(out=None)


@command(
    _add_study,
    flag("--list", "list the learners that are known here, and end"),
    option("--only", "one learner of --list; may be given several times (all)", metavar="NAME", action="append"),
    option("--learner", _LEARNER, metavar="PLACE", action="append"),
    option("--against", _AGAINST, metavar="FILE"),
    option("--arenas", _ARENAS, None, "NAME", nargs="+", choices=(*ARENAS, *DIFFICULTIES)),
    flag("--tune", "compare settings of each learner instead"),
    flag("--protocol", "the protocol forage-bench-1 (docs/protocol.md): in results/forage-bench-1"),
    option("--track", "one track of the protocol; may be given several times (all)", action="append", choices=TRACKS),
    option("--backend", _BACKEND, choices=("loky", "dask"), default="loky"),
    option("--address", "of a Dask cluster (by default a temporary one on this machine)"),
    description=DESCRIPTION,
    epilog="example:\n    khepera-forage compare --learner my_module:make_forest --against published",
)
def compare_command(arguments: argparse.Namespace) -> int:
    """Compare all learners, and yours with them."""
    from khepera_forage.comparison.compare import compare, known_learners, tune, unavailable

    if arguments.list:
        print(known_learners())
        return 0
    require("khepera-forage compare", "plots")
    if reason := unavailable(arguments.backend, arguments.address):
        raise ValueError(reason)
    if arguments.protocol:
        refuse_ignored(arguments, ["--against", "--arenas", "--tune", "--recalls", "--steps"], "without --protocol")
        require("khepera-forage compare --protocol", "fast")
    else:
        refuse_ignored(arguments, ["--track"], "with --protocol")
    arguments.seeds_given = arguments.seeds is not None
    arguments.out = arguments.out or Path("results", PROTOCOL if arguments.protocol else "learners")
    given = completed(arguments, *COUNTS)
    if given.tune:
        refuse_ignored(given, ["--learner", "--against", "--arenas"], "without --tune")
        return tune(given)
    return compare(given)
