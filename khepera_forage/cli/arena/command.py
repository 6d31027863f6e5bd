"""`khepera-forage arena`: its subcommands."""

import argparse

from khepera_forage.cli.arena import list_names, show, write
from khepera_forage.cli.subcommands import Subcommand, add_subcommands

SUBCOMMANDS = (
    Subcommand("list", "list the named arenas", list_names.add_arguments, list_names.run),
    Subcommand("show", "draw an arena with its shortest paths", show.add_arguments, show.run),
    Subcommand("write", "write an arena to a file, to change it", write.add_arguments, write.run),
)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the subcommands."""
    add_subcommands(parser, "task", SUBCOMMANDS)
