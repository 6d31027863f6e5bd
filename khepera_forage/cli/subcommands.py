"""Subcommands of an argparse parser: each has a name, a line of help, arguments and a function that runs it."""

import argparse
from collections.abc import Callable, Iterable
from typing import NamedTuple


class Subcommand(NamedTuple):
    """One subcommand, or a group of further subcommands.

    Attributes:
        name: What the user types.
        help: What it does, in one line without a capital letter or a full stop.
        add_arguments: Adds its arguments, or its own subcommands, to a parser.
        run: Takes the parsed arguments and returns the exit status; None for a group of subcommands.
    """

    name: str
    help: str
    add_arguments: Callable[[argparse.ArgumentParser], None]
    run: Callable[[argparse.Namespace], int] | None = None


def add_subcommands(parser: argparse.ArgumentParser, dest: str, subcommands: Iterable[Subcommand]) -> None:
    """Add subcommands, one of which the user must choose.

    After parsing, `arguments.run` is the function of the innermost subcommand.

    Args:
        parser: Of the command.
        dest: Attribute of the parsed arguments that holds the chosen name; also its name in usage texts.
        subcommands: In the order of the help text.
    """
    subparsers = parser.add_subparsers(dest=dest, required=True, metavar=dest)
    for name, help_text, add_arguments, run in subcommands:
        description = f"{help_text[:1].upper()}{help_text[1:]}."
        subparser = subparsers.add_parser(name, help=help_text, description=description)
        add_arguments(subparser)
        if run is not None:
            subparser.set_defaults(run=run)
