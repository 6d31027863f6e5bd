"""`khepera-forage arena write`: write an arena to a file."""

import argparse
from pathlib import Path

from khepera_forage.cli.arena.choice import add_choice_arguments, chosen_plan
from khepera_forage.cli.arguments import ARENA_FILES
from khepera_forage.option_values import given_path
from khepera_forage.sim.arena_file import write_arena


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command's arguments."""
    add_choice_arguments(parser)
    parser.add_argument(
        "file", type=given_path, metavar="FILE", help=f"name of the new file, which ends in {ARENA_FILES}"
    )


def run(arguments: argparse.Namespace) -> int:
    """Write the file.

    Raises:
        ValueError: The arena is not allowed, or the file has another ending.
        OSError: The file cannot be written, or exists.
    """
    path: Path = arguments.file
    arena = chosen_plan(arguments).arena()
    if path.suffix != ARENA_FILES:
        raise ValueError(f"file is {str(path)!r}; allowed: a name that ends in {ARENA_FILES}")
    if path.exists():
        raise FileExistsError(f"{path} exists; choose another name, or remove it first")
    write_arena(arena, path)
    print(f"{path}: {arena.name}; `khepera-forage arena show {path}` draws it")
    return 0
