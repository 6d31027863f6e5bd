"""`khepera-forage arena list`: the named arenas and their environments."""

import argparse

from khepera_forage.envs.arena_settings import environment_name, settings_of
from khepera_forage.envs.arguments import checked_arena
from khepera_forage.sim.arenas.difficulty import DIFFICULTIES
from khepera_forage.sim.arenas.named import ARENAS
from khepera_forage.task.decisions import DEFAULT_DECISIONS


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command's arguments: none."""


def run(arguments: argparse.Namespace) -> int:
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
