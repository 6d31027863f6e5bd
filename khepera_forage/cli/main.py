"""The `khepera-forage` command."""

import io
import os
import sys
from collections.abc import Sequence

from khepera_forage import __version__
from khepera_forage.cli import arena, camera, lab, robot
from khepera_forage.cli.compare import compare_command
from khepera_forage.cli.dataset import dataset_command
from khepera_forage.cli.options import add_commands
from khepera_forage.cli.plot import plot_command
from khepera_forage.cli.recall import recall_command, watch_command
from khepera_forage.cli.teach import teach_command
from khepera_forage.cli.thesis import decisions_command, infer_command, reproduce_command
from khepera_forage.cli.train import train_command
from khepera_forage.option_values import OneLineParser
from khepera_forage.rollouts.training import IncompleteTrainingError

COMMANDS = (
    reproduce_command,
    train_command,
    teach_command,
    recall_command,
    arena.COMMAND,
    plot_command,
    compare_command,
    watch_command,
    decisions_command,
    dataset_command,
    infer_command,
    lab.COMMAND,
    robot.COMMAND,
    camera.COMMAND,
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
    add_commands(parser, "command", COMMANDS)
    try:
        arguments = parser.parse_args(argv)
    except SystemExit as stop:
        if not stop.code:  # --help or --version
            raise
        return 2
    try:
        status: int | None = arguments.run(arguments)
    except (ValueError, OSError, ImportError, IncompleteTrainingError) as error:
        if isinstance(error, BrokenPipeError):
            print(flush=True)  # raises it again if it is the output that nobody reads, and not a robot's port
        print(f"khepera-forage {arguments.command}: {error}", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        print("stopped", file=sys.stderr)
        return 130
    return status or 0


if __name__ == "__main__":
    sys.exit(main())
