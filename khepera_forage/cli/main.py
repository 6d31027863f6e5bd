"""The `khepera-forage` command."""

import argparse
import io
import os
import re
import shlex
import sys
from collections.abc import Sequence
from importlib import import_module

from khepera_forage import __version__
from khepera_forage.option_values import OneLineParser

COMMANDS = {
    "reproduce": ("thesis", "run the thesis's experiments and compare the results with its tables"),
    "train": ("train", "train a learner in the paired corridors and save its experience"),
    "teach": ("teach", "be the teacher yourself, with keys in a window"),
    "recall": ("recall", "let a trained learner, or the teacher, forage alone"),
    "arena": ("arena", "list, draw and write arenas"),
    "plot": ("plot", "draw recalls, trainings or comparisons from their files"),
    "compare": ("compare", "compare all learners, and yours with them"),
    "watch": ("recall", "show a training or recall episode in a window, or save it as a film"),
    "decisions": ("thesis", "list what the thesis leaves open, with our decisions and their reasons"),
    "dataset": ("dataset", "write training episodes as a Minari dataset with a data card"),
    "infer": ("thesis", "infer from the thesis's own tables what it leaves open"),
    "lab": ("lab", "set up a laboratory with real robots, and check it"),
    "robot": ("robot", "test a real robot, or start a virtual one"),
    "camera": ("camera", "calibrate the overhead camera, show its picture, or print the markers"),
}
"""The module of each command and its help. Only the module of the chosen one is imported, because all take a second."""
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
    except KeyboardInterrupt:
        print("stopped", file=sys.stderr)
        return 130


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
    argv = (sys.argv[1:] if argv is None else argv) or ["--help"]
    # Of words that begin with "-", argparse takes only single numbers for values, and those with a space.
    argv = [f" {word}" if re.match(r"-[\d.]+,", word) else word for word in argv]
    try:
        arguments = _parser(argv).parse_args(argv)
    except SystemExit as stop:
        if not stop.code:  # --help or --version
            raise
        return 2
    arguments.command_line = shlex.join(["khepera-forage", *argv])
    try:
        status: int | None = arguments.run(arguments)
    except Exception as error:
        from khepera_forage.rollouts.training import IncompleteTrainingError

        if not isinstance(error, ValueError | OSError | ImportError | IncompleteTrainingError):
            raise
        if isinstance(error, BrokenPipeError):
            print(flush=True)  # raises it again if it is the output that nobody reads, and not a robot's port
        print(f"khepera-forage {arguments.command}: {error}", file=sys.stderr)
        return 2
    return status or 0


def _parser(argv: Sequence[str]) -> argparse.ArgumentParser:
    """A parser with all commands, and with the arguments of the one that is chosen."""
    parser = OneLineParser(prog="khepera-forage", description="Learning to forage by imitation.")
    parser.add_argument("--version", action="version", version=f"khepera-forage {__version__}")
    commands = parser.add_subparsers(dest="command", required=True, metavar="command")
    chosen = next((word for word in argv if not word.startswith("-")), None)
    for name, (module, line) in COMMANDS.items():
        added = commands.add_parser(name, help=line)
        if name == chosen:
            own = getattr(import_module(f"khepera_forage.cli.{module}"), f"{name}_command")
            own.add_to(added)
    return parser


if __name__ == "__main__":
    sys.exit(main())
