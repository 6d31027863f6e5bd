"""The arena that a command is about: a name, a file, or a procedural level."""

import argparse

from khepera_forage.cli.arguments import ARENA_FILES, refuse_ignored
from khepera_forage.envs.arena_settings import settings_of
from khepera_forage.envs.arguments import set_up_of
from khepera_forage.option_values import whole_number
from khepera_forage.sim.arena import Arena
from khepera_forage.sim.arena_file import ArenaPlan, read_plan
from khepera_forage.sim.arenas.difficulty import DIFFICULTIES, checked_difficulty
from khepera_forage.sim.arenas.named import ARENAS, named_arena
from khepera_forage.sim.arenas.procedural import LEVELS, procedural_arena
from khepera_forage.task.decisions import DEFAULT_DECISIONS

PROCEDURAL = "procedural"


def add_choice_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the positional argument `arena`, and what determines a procedural one."""
    parser.add_argument(
        "arena", metavar="NAME|FILE", help=f"{', '.join(ARENAS)}, {PROCEDURAL}, or a file *{ARENA_FILES}"
    )
    parser.add_argument("--difficulty", choices=tuple(DIFFICULTIES), help=f"of a {PROCEDURAL} arena (medium)")
    parser.add_argument(
        "--level",
        type=whole_number(0),
        help=f"number of a {PROCEDURAL} arena (0); below {LEVELS:,} for training, from there on for the test",
    )


def chosen_plan(arguments: argparse.Namespace) -> ArenaPlan:
    """The arena, which in a file may be one that is not allowed.

    Raises:
        ValueError: Another name, an option without effect, or a file with a mistake.
        OSError: The file cannot be read.
    """
    name = arguments.arena
    if name == PROCEDURAL:
        return ArenaPlan.of(procedural_arena(arguments.level or 0, arguments.difficulty or "medium"))
    refuse_ignored(arguments, ["--difficulty", "--level"], f"with the arena {PROCEDURAL}")
    if name in ARENAS:
        return ArenaPlan.of(named_arena(name, set_up_of(DEFAULT_DECISIONS)))
    if name.endswith(ARENA_FILES):
        return read_plan(name)
    raise ValueError(
        f"arena is {name!r}; allowed: {', '.join(ARENAS)}, {PROCEDURAL}, or a file *{ARENA_FILES}"
    )


def chosen_limit(arguments: argparse.Namespace, arena: Arena) -> int:
    """Steps of an episode in the environments of the arena."""
    if arguments.arena == PROCEDURAL:
        return checked_difficulty(arguments.difficulty or "medium").limit
    limit: int = settings_of(arguments.arena if arguments.arena in ARENAS else arena)["limit"]
    return limit
