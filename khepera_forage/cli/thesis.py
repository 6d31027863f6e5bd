"""`khepera-forage reproduce`, `infer` and `decisions`: the thesis's experiments, and what it leaves open."""

import argparse

from khepera_forage.cli.options import DECISION, command, decisions_of, flag, option, out, refuse_ignored, seed
from khepera_forage.envs.backends import BACKENDS, COMPILED, PYMUNK
from khepera_forage.extras import require
from khepera_forage.option_values import given_path, processes, whole_number
from khepera_forage.study import SMOKE_TEST, Count, add_study_arguments, completed, finish
from khepera_forage.task.decisions import decision_table
from khepera_forage.thesis.reproduce import QUICK_REPLICATIONS, REPLICATIONS, SUMMARY, reproduce

COUNTS = (
    Count("sets", 10_000, 3, "admissible sets", adds_units=True, least=3),
    Count("experiments", 5, 2, "replications of the thesis's design under each set"),
)
INFER = """Approximate Bayesian computation by random forests:

1. Sets of decisions are drawn from a prior with a source for every range. A
   set is admissible if the teacher can do under it what the thesis says of it.
   Under each admissible set, the thesis's whole design is replicated.
2. A random forest learns from these sets what statistics of the corridor's
   tables say about each decision. It is first validated on sets that it has
   not seen, and then given tables A.1 to A.4. Tables A.5 to A.7 are the test
   set.

Writes a page with all tables and two pictures. Ten thousand sets take two
hours on two cores; a run that was killed continues.

--tables infers from the tables of another experiment in a minute, with
simulated sets that the package contains, and writes its page to a folder of
the results' folder. Such an experiment, a pseudo-thesis under known decisions:

    khepera-forage reproduce --replications 1 --out pseudo \\
        --decision next_to_food=20
    khepera-forage infer --tables pseudo/recalls.csv"""


_BACKEND = f"{COMPILED}: thousands of worlds at once, needs numba; {PYMUNK}: one world at a time ({COMPILED})"
_NUMBERS = f"{REPLICATIONS[COMPILED]} with {COMPILED}, {REPLICATIONS[PYMUNK]} with {PYMUNK}"
_ALONE = """only the chosen decisions; without this option, the thesis's cells are also repeated under those of version
0.1, in a fifth of the replications"""


@command(
    option("--backend", _BACKEND, choices=BACKENDS, default=COMPILED),
    option("--replications", f"repetitions of the whole design ({_NUMBERS})", whole_number(1, 100_000)),
    seed(),
    out("results/thesis", "folder for the report, its tables, figures and rows"),
    option("--jobs", f"processes with {PYMUNK}; -1 uses all cores (-1)", processes),
    flag("--quick", "a small version of all experiments, under a minute"),
    flag("--fresh", "do not continue a run that was killed in the folder"),
    DECISION,
    flag("--no-comparison", _ALONE),
)
def reproduce_command(arguments: argparse.Namespace) -> None:
    """Run the thesis's experiments and compare the results with its tables."""
    backend = arguments.backend
    replications = QUICK_REPLICATIONS if arguments.quick else REPLICATIONS[backend]
    if backend == COMPILED:
        refuse_ignored(arguments, ["--jobs"], f"with --backend {PYMUNK}; {COMPILED} worlds always use all cores")
    page = reproduce(
        arguments.seed,
        arguments.replications or replications,
        arguments.out,
        n_jobs=-1 if arguments.jobs is None else arguments.jobs,
        quick=arguments.quick,
        backend=backend,
        decisions=decisions_of(arguments),
        comparison=not arguments.no_comparison,
        fresh=arguments.fresh,
    )
    if arguments.quick:
        print(SMOKE_TEST)
    print((arguments.out / SUMMARY).read_text(encoding="utf-8"))
    print(f"Page ({page.name}), tables, figures and rows are in {arguments.out}")


_TABLES = """infer from these tables of the corridor, with the simulated sets of the package: recalls.csv of
'khepera-forage reproduce', a file like the package's thesis/appendix_a.csv, or 'thesis' for the thesis's own"""


@command(
    lambda parser: add_study_arguments(parser, "decisions", *COUNTS),
    option("--tables", _TABLES, given_path, "FILE"),
    description=INFER,
)
def infer_command(arguments: argparse.Namespace) -> int:
    """Infer from the thesis's own tables what it leaves open."""
    require("khepera-forage infer", "fast", "plots")
    from khepera_forage.thesis.inference.page import page, tables_page
    from khepera_forage.thesis.inference.simulate import KEPT, Sets, draw
    from khepera_forage.thesis.inference.summary import fitted_columns, tables_statistics, thesis_statistics

    tables = arguments.tables
    if tables:
        options = ["--sets", "--experiments", "--quick", "--fresh"]
        refuse_ignored(arguments, options, "without --tables, which uses simulated sets of the package")
    given = completed(arguments, *COUNTS)
    if tables:
        own = str(tables) == "thesis"
        observed = thesis_statistics()[fitted_columns()] if own else tables_statistics(tables)
        given.out, given.name = given.out / tables.stem, "tables"
        return finish(given, tables_page(given, Sets.load(), observed, f"the tables of {tables}"))
    drawn = draw(given, given.sets, given.experiments)
    drawn.sets.save(given.out / KEPT)
    return finish(given, page(given, drawn))


@command(
    description="List the decisions: what the thesis leaves open, with our default and the reason for it. "
    "Other commands take them as --decision NAME=VALUE, or all of a version as --decision VERSION."
)
def decisions_command(arguments: argparse.Namespace) -> None:
    """List what the thesis leaves open, with our decisions and their reasons."""
    table = {("decision", "default", "thesis", "allowed"): ""}
    table |= {(row.name, row.default, row.section, row.allowed): f"\n    {row.meaning}" for row in decision_table()}
    widths = [max(map(len, column)) for column in zip(*table, strict=True)]
    for line, meaning in table.items():
        print("  ".join(map(str.ljust, line, widths)).rstrip() + meaning)
