"""`khepera-forage arena show`: draw an arena, and say what is wrong with it."""

import argparse
import sys

from khepera_forage.cli.arena.choice import add_choice_arguments, chosen_limit, chosen_plan
from khepera_forage.cli.arena.findings import Findings, find
from khepera_forage.cli.arguments import add_out_argument
from khepera_forage.extras import require
from khepera_forage.sim.arena import Arena
from khepera_forage.sim.ways import path_length

_REFUSED = 1
"""Exit status for an arena that environments do not accept."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command's arguments."""
    add_choice_arguments(parser)
    add_out_argument(parser, "arena.png", "picture, whose name ends in .png")


def run(arguments: argparse.Namespace) -> int:
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
    from khepera_forage.cli.arena.picture import draw

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
