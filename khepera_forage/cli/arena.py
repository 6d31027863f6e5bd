"""`khepera-forage arena`: list the named arenas, draw an arena and what is wrong with it, and write one to a file."""

import argparse
import sys
from collections.abc import Iterable
from contextlib import suppress
from pathlib import Path
from typing import NamedTuple

from khepera_forage.cli.arguments import ARENA_FILES, add_out_argument, refuse_ignored
from khepera_forage.cli.subcommands import Subcommand, add_subcommands
from khepera_forage.envs.arena_settings import environment_name, settings_of
from khepera_forage.envs.arguments import checked_arena, set_up_of
from khepera_forage.extras import require
from khepera_forage.option_values import given_path, whole_number
from khepera_forage.sim.arena import Arena, Point
from khepera_forage.sim.arena_file import ArenaPlan, read_plan, write_arena
from khepera_forage.sim.arenas.difficulty import DIFFICULTIES, checked_difficulty
from khepera_forage.sim.arenas.named import ARENAS, named_arena
from khepera_forage.sim.arenas.procedural import LEVELS, procedural_arena
from khepera_forage.sim.layout_checks import check_seen
from khepera_forage.sim.ways import check_ways, path_length, shortest_path, too_narrow
from khepera_forage.task.decisions import DEFAULT_DECISIONS

PROCEDURAL = "procedural"
Paths = tuple[tuple[Point, ...], ...]
_REFUSED = 1
"""Exit status for an arena that environments do not accept."""


class Findings(NamedTuple):
    """What environments find in an arena.

    Attributes:
        refusal: Why they do not accept it; empty if they do.
        to_food: Shortest paths from the start to each food object that can be reached.
        to_home: Shortest paths from each food object to the home, likewise.
        narrow: Parts of the floor in which a robot cannot turn.
    """

    refusal: str
    to_food: Paths = ()
    to_home: Paths = ()
    narrow: Paths = ()


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the subcommands."""
    add_subcommands(parser, "task", SUBCOMMANDS)


def list_arenas(arguments: argparse.Namespace) -> int:
    """Print a line for each arena, and one for each difficulty of procedural arenas."""
    print("arena        environment     size in mm    walls  food   limit")
    for name in ARENAS:
        arena, settings = checked_arena(name, DEFAULT_DECISIONS), settings_of(name)
        left, bottom, right, top = arena.bounds
        print(
            f"{name:12} {environment_name(name) + '-v1':15} {right - left:4g} x {top - bottom:4g}   "
            f"{len(arena.segments):6d} {settings['foods']:5d} {settings['limit']:7d}"
        )
    print("\nProcedural-v1   size in mm                walls  food   limit")
    for name, difficulty in DIFFICULTIES.items():
        (short, long), (narrow, wide) = difficulty.length, difficulty.width
        size = f"{short} x {narrow} to {long} x {wide}"
        print(
            f"{name:15} {size:24} {f'<={difficulty.most_walls}':>6} {difficulty.foods:5d} {difficulty.limit:7d}"
        )
    return 0


def add_show_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command's arguments."""
    add_choice_arguments(parser)
    add_out_argument(parser, "arena.png", "picture, whose name ends in .png")


def show(arguments: argparse.Namespace) -> int:
    """Draw the arena, and print its size, or why environments do not accept it.

    Returns:
        Exit status: 1 for an arena that environments do not accept.

    Raises:
        ValueError: There is no such arena, the file cannot be drawn, or the picture has another ending.
        OSError: A file cannot be read or written.
        ImportError: matplotlib is not installed.
    """
    require("khepera-forage arena show", "plots")
    if arguments.out.suffix.lower() != ".png":
        raise ValueError(f"--out is {str(arguments.out)!r}; allowed: a name that ends in .png")
    plan = chosen_plan(arguments)
    findings = find(plan)
    from khepera_forage.cli.arena_picture import draw

    draw(plan, findings, arguments.out)
    print(f"{arguments.out}: {plan.name}")
    if findings.refusal:
        print(f"khepera-forage arena show: {findings.refusal}", file=sys.stderr)
        return _REFUSED
    print(_summary(plan.arena(), arguments, findings))
    return 0


def _summary(arena: Arena, arguments: argparse.Namespace, findings: Findings) -> str:
    left, bottom, right, top = arena.bounds
    length = max(map(path_length, findings.to_food + findings.to_home))
    return (
        f"{right - left:g} x {top - bottom:g} mm, {len(arena.segments)} walls, food objects: {len(arena.foods)}, "
        f"longest way {length:.0f} mm, step limit {chosen_limit(arguments, arena)}"
    )


def add_write_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command's arguments."""
    add_choice_arguments(parser)
    parser.add_argument(
        "file", type=given_path, metavar="FILE", help=f"name of the new file, which ends in {ARENA_FILES}"
    )


def write(arguments: argparse.Namespace) -> int:
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


def find(plan: ArenaPlan) -> Findings:
    """What environments find in an arena."""
    try:
        arena = plan.arena()
        check_seen((arena,))
    except ValueError as error:
        return Findings(str(error))
    refusal = ""
    try:
        check_ways(arena)
    except ValueError as error:
        refusal = str(error)
    start = Point(arena.start.x, arena.start.y)
    to_food = _paths(arena, [(start, food) for food in arena.foods])
    to_home = _paths(arena, [(food, arena.home) for food in arena.foods])
    return Findings(refusal, to_food, to_home, tuple(too_narrow(arena)))


def _paths(arena: Arena, ends: Iterable[tuple[Point, Point]]) -> Paths:
    """The shortest paths between places, as far as there are some."""
    found = []
    for start, goal in ends:
        with suppress(ValueError):
            found.append(shortest_path(arena, start, goal))
    return tuple(found)


SUBCOMMANDS = (
    Subcommand("list", "list the named arenas", lambda _: None, list_arenas),
    Subcommand("show", "draw an arena with its shortest paths", add_show_arguments, show),
    Subcommand("write", "write an arena to a file, to change it", add_write_arguments, write),
)
