"""`khepera-forage reproduce`: the thesis's experiments, repeated, and a report on them."""

import argparse

from khepera_forage.cli.arguments import (
    add_decision_argument,
    add_out_argument,
    add_seed_argument,
    decisions_of,
    refuse_ignored,
)
from khepera_forage.envs.backends import BACKENDS, COMPILED, PYMUNK
from khepera_forage.option_values import processes, whole_number
from khepera_forage.thesis.reproduce import QUICK_REPLICATIONS, REPLICATIONS, SUMMARY, reproduce

MOST_REPLICATIONS = 100_000


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command's arguments."""
    parser.add_argument(
        "--backend",
        choices=BACKENDS,
        default=COMPILED,
        help=f"{COMPILED}: thousands of worlds at once, needs numba; {PYMUNK}: one world at a time ({COMPILED})",
    )
    parser.add_argument(
        "--replications",
        type=whole_number(1, MOST_REPLICATIONS),
        help="repetitions of the whole design "
        f"({REPLICATIONS[COMPILED]} with {COMPILED}, {REPLICATIONS[PYMUNK]} with {PYMUNK})",
    )
    add_seed_argument(parser)
    add_out_argument(parser, "results/thesis", "folder for the report, its tables, figures and rows")
    parser.add_argument("--jobs", type=processes, help=f"processes with {PYMUNK}; -1 uses all cores (-1)")
    parser.add_argument(
        "--quick", action="store_true", help="a small version of all experiments, under a minute"
    )
    parser.add_argument(
        "--fresh", action="store_true", help="do not continue a run that was killed in the folder"
    )
    add_decision_argument(parser)
    parser.add_argument(
        "--no-comparison",
        action="store_true",
        help="only the chosen decisions; without this option, the thesis's cells are also repeated under those of "
        "version 0.1, in a fifth of the replications",
    )


def run(arguments: argparse.Namespace) -> int:
    """Run the experiments, and print the report and a summary.

    Raises:
        ValueError: A decision that is not allowed, an option without effect, or a folder with rows of other decisions.
        ImportError: matplotlib is not installed, or numba for the backend `compiled`.
    """
    backend = arguments.backend
    replications = arguments.replications
    if replications is None:
        replications = QUICK_REPLICATIONS if arguments.quick else REPLICATIONS[backend]
    if backend == COMPILED:
        refuse_ignored(
            arguments, ["--jobs"], f"with --backend {PYMUNK}; {COMPILED} worlds always use all cores"
        )
    page = reproduce(
        arguments.seed,
        replications,
        arguments.out,
        n_jobs=-1 if arguments.jobs is None else arguments.jobs,
        quick=arguments.quick,
        backend=backend,
        decisions=decisions_of(arguments),
        comparison=not arguments.no_comparison,
        fresh=arguments.fresh,
    )
    print(page.read_text(encoding="utf-8"))
    print((arguments.out / SUMMARY).read_text(encoding="utf-8"))
    print(f"Tables, figures and rows are in {arguments.out}")
    return 0
