"""The arguments that every benchmark takes, and what `--help` says about them."""

import argparse
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import NamedTuple

from khepera_forage.cli.values import OneLineParser, given_path, processes, whole_number


class Count(NamedTuple):
    """An argument that says how much work is done.

    Attributes:
        name: Of the argument, without dashes.
        default: Without `--quick`.
        quick: With `--quick`.
        what: What is counted, for `--help`.
        adds_units: Whether a larger count adds units of work and leaves the others as they were. The rows of other
            counts cannot be continued with a different value.
        least: The smallest count allowed, for example 2 if an interval is computed from them.
    """

    name: str
    default: int
    quick: int
    what: str
    adds_units: bool = False
    least: int = 1


class Arguments(argparse.Namespace):
    """Arguments as given, with the counts' defaults filled in.

    Attributes:
        script: Name of the script, without `.py`.
        seed: Of the whole run.
        out: Folder for the results.
        quick: Whether the work is done in small.
        jobs: Processes, as joblib counts them.
        fresh: Whether rows of earlier runs in the folder are deleted.
        counts: Every count by its name.
        settings: Everything that the rows of a unit depend on, as text.
    """

    script: str
    seed: int
    out: Path
    quick: bool
    jobs: int
    fresh: bool
    counts: dict[str, int]
    settings: dict[str, str]

    def command(self, *options: str) -> str:
        """The command that repeats this run, for the page.

        Args:
            *options: Of this script alone; they stand first.
        """
        counts = (f"--{name} {value}" for name, value in self.counts.items())
        quick = ["--quick"] if self.quick else []
        return " ".join(
            [f"python benchmarks/{self.script}.py", *options, *counts, f"--seed {self.seed}", *quick]
        )


def parse(
    script: str,
    description: str | None,
    *counts: Count,
    jobs: int | None = -1,
    add: Callable[[argparse.ArgumentParser], None] = lambda _: None,
    given: Sequence[str] | None = None,
) -> Arguments:
    """Read the command line.

    Args:
        script: Name of the script; results go to `results/<script>` by default.
        description: The script's docstring.
        *counts: How much work is done.
        jobs: Processes by default, -1 for one a core. None for a benchmark that measures time: it runs in one process,
            has no `--jobs`, and never continues an earlier run.
        add: Adds the arguments of this script alone.
        given: The arguments; by default those of this process.
    """
    parser = OneLineParser(
        prog=f"{script}.py", description=description, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    out = f"results/{script}"
    parser.add_argument(
        "--seed", type=whole_number(0), default=0, help="the same seed gives the same work (0)"
    )
    parser.add_argument("--out", type=given_path, default=Path(out), help=f"folder for the results ({out})")
    parser.add_argument("--quick", action="store_true", help="the same work in small, in under a minute")
    parser.set_defaults(script=script, jobs=1, fresh=True)
    if jobs is not None:
        parser.add_argument(
            "--jobs", type=processes, default=jobs, help=f"processes; -1 is one a core ({jobs})"
        )
        parser.add_argument(
            "--fresh", action="store_true", default=False, help="delete rows of earlier runs in the folder"
        )
    for count in counts:
        text = f"{count.what} ({count.default}; with --quick {count.quick})"
        parser.add_argument(
            f"--{count.name}", type=whole_number(count.least), default=None, metavar="N", help=text
        )
    add(parser)
    arguments = parser.parse_args(given, namespace=Arguments())
    arguments.counts = {}
    arguments.settings = {"seed": str(arguments.seed), "quick": "yes" if arguments.quick else "no"}
    for count in counts:
        value = getattr(arguments, count.name)
        if value is None:
            value = count.quick if arguments.quick else count.default
        setattr(arguments, count.name, value)
        arguments.counts[count.name] = value
        if not count.adds_units:
            arguments.settings[count.name] = str(value)
    return arguments
