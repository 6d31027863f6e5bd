"""Arguments that several commands share, and checks of their values."""

import argparse
from collections.abc import Sequence
from pathlib import Path

from khepera_forage.noise import SOURCES, Noise, checked_noise
from khepera_forage.option_values import given_path, whole_number
from khepera_forage.sim.arena import Arena
from khepera_forage.sim.arena_file import read_arena
from khepera_forage.sim.arenas.named import ARENAS
from khepera_forage.sim.arenas.thesis import CORRIDOR
from khepera_forage.task.decisions import VERSIONS, Decisions, decisions_from_words
from khepera_forage.task.states import FoodType

VIRTUAL_LAB = "virtual"
"""Value of `--lab` for the virtual laboratory; `virtual:e-puck2` and `virtual:toio` for one of other robots."""
ARENA_FILES = ".toml"
"""Ending of the names of arena files."""
MOST_EPISODES = 100_000


def add_seed_argument(
    parser: argparse.ArgumentParser, help_text: str = "the same seed gives the same results"
) -> None:
    """Add `--seed`, 0 by default."""
    parser.add_argument("--seed", type=whole_number(0), default=0, help=f"{help_text} (0)")


def add_out_argument(parser: argparse.ArgumentParser, default: str, help_text: str) -> None:
    """Add `--out`: the file or folder to write."""
    parser.add_argument("--out", type=given_path, default=Path(default), help=f"{help_text} ({default})")


def add_episodes_argument(parser: argparse.ArgumentParser, default: int, help_text: str) -> None:
    """Add `--episodes`: how many."""
    parser.add_argument(
        "--episodes", type=whole_number(1, MOST_EPISODES), default=default, help=f"{help_text} ({default})"
    )


def experience_files(paths: Sequence[Path]) -> list[Path]:
    """Experience files, and in place of a folder its g1.csv, g2.csv, ... in the order of their numbers.

    Raises:
        ValueError: A folder has none.
    """
    files: list[Path] = []
    for path in paths:
        own = [file for file in path.glob("g*.csv") if file.stem[1:].isdecimal()] if path.is_dir() else [path]
        if not own:
            raise ValueError(f"{path} has no g1.csv; allowed: experience files, or a folder of them")
        files += sorted(own, key=lambda file: int(file.stem[1:])) if path.is_dir() else own
    return files


def noise_of(text: str | None) -> Noise | None:
    """The noise of `--noise`; None without it.

    Raises:
        ValueError: An unknown source.
    """
    if text in (None, "laboratory", "none"):
        return None if text is None else checked_noise(text)
    try:
        return Noise.only(*(source.strip() for source in text.split(",")))
    except ValueError as error:
        raise ValueError(f"--noise: {error}, laboratory or none") from None


def add_arena_argument(parser: argparse.ArgumentParser) -> None:
    """Add `--arena`: a name or a file. None stands for the corridor, so that a choice can be told."""
    parser.add_argument(
        "--arena",
        metavar="NAME|FILE",
        help=f"{', '.join(ARENAS)}, or a file as `khepera-forage arena write` writes it ({CORRIDOR})",
    )


def arena_of(arguments: argparse.Namespace) -> str | Arena:
    """The arena that `--arena` names: one of `ARENAS`, or the content of a file.

    Raises:
        ValueError: Another name, or a file with a mistake.
        OSError: The file cannot be read.
    """
    arena = arguments.arena or CORRIDOR
    if arena in ARENAS:
        return str(arena)
    if not arena.endswith(ARENA_FILES):
        raise ValueError(f"arena is {arena!r}; allowed: {', '.join(ARENAS)}, or a file *{ARENA_FILES}")
    return read_arena(arena)


def add_noise_argument(parser: argparse.ArgumentParser) -> None:
    """Add `--noise`. None stands for the laboratory's, so that a choice can be told."""
    parser.add_argument(
        "--noise",
        metavar="SOURCES",
        help=f"laboratory, none, or some of {', '.join(SOURCES)}, separated by commas (laboratory)",
    )


def add_food_type_argument(parser: argparse.ArgumentParser) -> None:
    """Add `--food-type`: the type of all food objects. None stands for the types that the arena has."""
    *others, last = (food_type.name for food_type in FoodType if food_type != FoodType.UNKNOWN)
    parser.add_argument(
        "--food-type",
        help=f"of all food: {', '.join(others)} or {last} ({FoodType.PICKABLE.name}; in mixed_foods all of them)",
    )


def add_num_learners_argument(parser: argparse.ArgumentParser, help_text: str) -> None:
    """Add `--num-learners`. None stands for 1, so that a choice can be told."""
    parser.add_argument("--num-learners", type=whole_number(1), help=help_text)


def add_lab_argument(parser: argparse.ArgumentParser) -> None:
    """Add `--lab`: the laboratory to use instead of a simulation."""
    parser.add_argument(
        "--lab",
        metavar="FILE",
        help=f"use the real robots and the camera that this lab.toml describes; '{VIRTUAL_LAB}' uses simulated "
        f"robots behind the real drivers, '{VIRTUAL_LAB}:e-puck2' and '{VIRTUAL_LAB}:toio' other ones",
    )


def add_decision_argument(parser: argparse.ArgumentParser) -> None:
    """Add `--decision`: a decision other than the default."""
    parser.add_argument(
        "--decision",
        action="append",
        default=[],
        metavar="NAME=VALUE",
        help="decide otherwise what the thesis leaves open, such as next_to_food=22; may be repeated "
        f"('khepera-forage decisions' lists all names). The first one may be a version, {' or '.join(VERSIONS)}, "
        "which the others then change",
    )


def add_allow_other_decisions_argument(parser: argparse.ArgumentParser) -> None:
    """Add `--allow-other-decisions`."""
    parser.add_argument(
        "--allow-other-decisions",
        action="store_true",
        help="accept experience files that were recorded under other decisions",
    )


def decisions_of(arguments: argparse.Namespace) -> Decisions:
    """The decisions that `--decision` describes; the defaults without it.

    Raises:
        ValueError: An unknown version or decision, or a value that is not allowed.
    """
    return decisions_from_words(arguments.decision)


def refuse_ignored(arguments: argparse.Namespace, options: Sequence[str], where: str) -> None:
    """Refuse options that the user has given but that would have no effect.

    Args:
        arguments: With None or False for every option that was not given.
        options: Such as `--arena`.
        where: What the options have an effect in.

    Raises:
        ValueError: One of them was given.
    """
    for option in options:
        value = getattr(arguments, option.removeprefix("--").replace("-", "_"))
        if value is not None and value is not False:  # 0 is a value that was given
            raise ValueError(f"{option} has no effect here; allowed: {where}")


def is_real(lab: str | None) -> bool:
    """Whether `--lab` names the file of a real laboratory."""
    return lab is not None and lab.partition(":")[0] != VIRTUAL_LAB
