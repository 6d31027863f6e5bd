"""`khepera-forage lab`: set up a laboratory, and say what is wrong with it."""

import argparse

from khepera_forage.cli.lab import check, new
from khepera_forage.cli.subcommands import Subcommand, add_subcommands

SUBCOMMANDS = (
    Subcommand("new", "find robots and camera, check each, and write lab.toml", new.add_arguments, new.run),
    Subcommand("check", "check a laboratory in order: file, robots, camera", check.add_arguments, check.run),
)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the subcommands."""
    add_subcommands(parser, "task", SUBCOMMANDS)
