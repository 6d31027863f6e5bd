"""The `khepera-forage` command."""

import io
import os
import sys
from collections.abc import Sequence

from khepera_forage import __version__
from khepera_forage.cli import (
    arena,
    camera,
    compare,
    dataset,
    decisions,
    infer,
    lab,
    plot,
    recall,
    reproduce,
    robot,
    train,
    watch,
)
from khepera_forage.cli.subcommands import Subcommand, add_subcommands
from khepera_forage.cli.teach import command as teach
from khepera_forage.option_values import OneLineParser
from khepera_forage.rollouts.training import IncompleteTrainingError

SUBCOMMANDS = (
    Subcommand(
        "reproduce",
        "run the thesis's experiments and compare the results with its tables",
        reproduce.add_arguments,
        reproduce.run,
    ),
    Subcommand(
        "train",
        "train a learner in the paired corridors and save its experience",
        train.add_arguments,
        train.run,
    ),
    Subcommand("teach", "be the teacher yourself, with keys in a window", teach.add_arguments, teach.run),
    Subcommand(
        "recall", "let a trained learner, or the teacher, forage alone", recall.add_arguments, recall.run
    ),
    Subcommand("arena", "list, draw and write arenas", arena.add_arguments),
    Subcommand(
        "plot",
        "draw recalls, trainings or comparisons from their files",
        plot.add_arguments,
        plot.run,
    ),
    Subcommand("compare", "compare all learners, and yours with them", compare.add_arguments, compare.run),
    Subcommand(
        "watch",
        "show a training or recall episode in a window, or save it as a film",
        watch.add_arguments,
        watch.run,
    ),
    Subcommand(
        "decisions",
        "list what the thesis leaves open, with our decisions and their reasons",
        decisions.add_arguments,
        decisions.run,
    ),
    Subcommand(
        "dataset",
        "write training episodes as a Minari dataset with a data card",
        dataset.add_arguments,
        dataset.run,
    ),
    Subcommand(
        "infer",
        "infer from the thesis's own tables what it leaves open",
        infer.add_arguments,
        infer.run,
    ),
    Subcommand("lab", "set up a laboratory with real robots, and check it", lab.add_arguments),
    Subcommand("robot", "test a real robot, or start a virtual one", robot.add_arguments),
    Subcommand(
        "camera",
        "calibrate the overhead camera, show its picture, or print the markers",
        camera.add_arguments,
    ),
)


CLOSED_PIPE = 141
"""Exit status when nobody reads the output any more: that of other programs, 128 + SIGPIPE."""


def main(argv: Sequence[str] | None = None) -> int:
    """Run a subcommand; report a user's mistake in one line.

    Args:
        argv: Arguments; those of the process by default.

    Returns:
        Exit status: that of the subcommand, 2 for bad input, 130 after an interrupt, 141 for a closed pipe.
    """
    _open_streams()
    try:
        try:
            return _run(argv)
        finally:
            sys.stdout.flush()
    except BrokenPipeError:
        # Python writes what is left in its buffer when it ends.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return CLOSED_PIPE


def _open_streams() -> None:
    """Give the process the output streams that pythonw or `2>&-` took away, and let them write any character."""
    for name in ("stdout", "stderr"):
        stream = getattr(sys, name)
        if stream is None:
            # Otherwise the next file that is opened would be the one that libraries write errors to.
            setattr(sys, name, open(os.devnull, "w", encoding="utf-8"))  # noqa: SIM115 (for the whole process)
        elif isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="replace")


def _run(argv: Sequence[str] | None) -> int:
    parser = OneLineParser(prog="khepera-forage", description="Learning to forage by imitation.")
    parser.add_argument("--version", action="version", version=f"khepera-forage {__version__}")
    add_subcommands(parser, "command", SUBCOMMANDS)
    try:
        arguments = parser.parse_args(argv)
    except SystemExit as stop:
        if not stop.code:  # --help or --version
            raise
        return 2
    try:
        status: int = arguments.run(arguments)
    except (ValueError, OSError, ImportError, IncompleteTrainingError) as error:
        if isinstance(error, BrokenPipeError):
            print(flush=True)  # raises it again if it is the output that nobody reads, and not a robot's port
        print(f"khepera-forage {arguments.command}: {error}", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        print("stopped", file=sys.stderr)
        return 130
    return status


if __name__ == "__main__":
    sys.exit(main())
