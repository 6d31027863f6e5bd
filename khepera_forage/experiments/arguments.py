"""The arguments that every experiment takes, and what `--help` says about them."""

import argparse
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import NamedTuple, NoReturn

from khepera_forage.option_values import OneLineParser, given_path, processes, whole_number


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
        name: Of the experiment; its page and its folder of results have it, too.
        program: What error messages begin with.
        launched: How the program is started, for the page.
        seed: Of the whole run.
        out: Folder for the results.
        quick: Whether the work is done in small.
        jobs: Processes, as joblib counts them.
        fresh: Whether rows of earlier runs in the folder are deleted.
        counts: Every count by its name.
        settings: Everything that the rows of a unit depend on, as text.
    """

    name: str
    program: str
    launched: str
    seed: int
    out: Path
    quick: bool
    jobs: int
    fresh: bool
    counts: dict[str, int]
    settings: dict[str, str]

    def command_line(self, *options: str) -> str:
        """The command that repeats this run, for the page.

        Args:
            *options: Of this experiment alone; they stand first.
        """
        counts = (f"--{name} {value}" for name, value in self.counts.items())
        quick = ["--quick"] if self.quick else []
        return " ".join([self.launched, *options, *counts, f"--seed {self.seed}", *quick])

    def refuse(self, reason: str) -> NoReturn:
        """End the program with one line, and status 2."""
        print(f"{self.program}: {reason}", file=sys.stderr)
        sys.exit(2)


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
        script: Name of a script of `benchmarks/`; results go to `results/<script>` by default.
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
    add_experiment_arguments(parser, script, *counts, jobs=jobs)
    add(parser)
    parser.set_defaults(program=f"{script}.py", launched=f"python benchmarks/{script}.py")
    return completed(parser.parse_args(given), *counts)


def add_experiment_arguments(
    parser: argparse.ArgumentParser, name: str, *counts: Count, jobs: int | None = -1
) -> None:
    """Add `--seed`, `--out`, `--quick`, `--jobs`, `--fresh` and the counts.

    Args:
        parser: Of a script or of a command.
        name: Of the experiment; results go to `results/<name>` by default.
        *counts: How much work is done.
        jobs: As in `parse`.
    """
    out = f"results/{name}"
    parser.add_argument(
        "--seed", type=whole_number(0), default=0, help="the same seed gives the same work (0)"
    )
    parser.add_argument("--out", type=given_path, default=Path(out), help=f"folder for the results ({out})")
    parser.add_argument("--quick", action="store_true", help="the same work in small, in under a minute")
    parser.set_defaults(name=name, jobs=1, fresh=True)
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


def completed(parsed: argparse.Namespace, *counts: Count) -> Arguments:
    """The parsed arguments, with the counts' defaults filled in.

    Args:
        parsed: From a parser with `add_experiment_arguments`, and with `program` and `launched`.
        *counts: Those of the parser.
    """
    arguments = Arguments(**vars(parsed))
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
