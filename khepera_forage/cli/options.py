"""Commands as data, the options that several commands share, and what these options choose."""

import argparse
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryFile
from typing import Any, NamedTuple

from khepera_forage.envs.behaviours_env import BehavioursEnv
from khepera_forage.envs.paired_arenas_v1 import raw_env
from khepera_forage.envs.training import TrainingEnv
from khepera_forage.extras import require
from khepera_forage.noise import SOURCES, Noise, checked_noise
from khepera_forage.option_values import given_path, whole_number
from khepera_forage.robots.model import KHEPERA, MODELS
from khepera_forage.rollouts import recall as recall_rollouts
from khepera_forage.sim.arena import Arena
from khepera_forage.sim.arena_file import read_arena
from khepera_forage.sim.arenas.named import ARENAS
from khepera_forage.sim.arenas.thesis import CORRIDOR
from khepera_forage.sim.world import World
from khepera_forage.task.decisions import VERSIONS, Decisions, decisions_from_words

VIRTUAL_LAB = "virtual"
"""Value of `--lab` for the virtual laboratory; `virtual:e-puck2` and `virtual:toio` for one of other robots."""
ARENA_FILES = ".toml"

Run = Callable[[argparse.Namespace], int | None]
"""Takes the parsed arguments and returns the exit status, None for 0."""
Option = Callable[[argparse.ArgumentParser], object]
"""Adds one or more arguments to a parser."""


class Subcommand(NamedTuple):
    """A command: what it does, and its arguments in the order of the help text."""

    run: Run
    options: Sequence[Option]
    description: str
    epilog: str | None

    def add_to(self, parser: argparse.ArgumentParser) -> None:
        """Make a parser that of this command."""
        parser.description, parser.epilog = self.description, self.epilog
        if "\n" in self.description:
            parser.formatter_class = argparse.RawDescriptionHelpFormatter
        for add in self.options:
            add(parser)
        parser.set_defaults(run=self.run, program=parser.prog)


class Group(NamedTuple):
    """Commands about one thing. What the user types is the name of each function, without `_command`."""

    description: str
    commands: Sequence[Subcommand]

    def add_to(self, parser: argparse.ArgumentParser) -> None:
        """Add the commands, of which the user must choose one."""
        parser.description = self.description
        tasks = parser.add_subparsers(dest="task", required=True, metavar="task")
        for each in self.commands:
            line = each.description[:1].lower() + each.description[1:].rstrip(".")
            each.add_to(tasks.add_parser(each.run.__name__.removesuffix("_command"), help=line))


def command(*options: Option, description: str = "", epilog: str | None = None) -> Callable[[Run], Subcommand]:
    """Make a function a command, which its docstring describes by default."""
    return lambda run: Subcommand(run, options, description or run.__doc__ or "", epilog)


def option(name: str, help_text: str, read: Any = None, metavar: Any = None, **about: Any) -> Option:
    """One argument; `read` is its type, and `about` as for `ArgumentParser.add_argument`."""
    return lambda parser: parser.add_argument(name, help=help_text, type=read, metavar=metavar, **about)


def flag(name: str, help_text: str, **about: Any) -> Option:
    """An option without a value."""
    return lambda parser: parser.add_argument(name, help=help_text, action="store_true", **about)


def seed(help_text: str = "the same seed gives the same results") -> Option:
    """`--seed`, 0 by default."""
    return option("--seed", f"{help_text} (0)", whole_number(0), default=0)


def out(default: str, help_text: str) -> Option:
    """`--out`: the file or folder to write."""
    return option("--out", f"{help_text} ({default})", given_path, default=Path(default))


def episodes(default: int, help_text: str) -> Option:
    """`--episodes`: how many."""
    return option("--episodes", f"{help_text} ({default})", whole_number(1, 100_000), default=default)


_ARENA_HELP = f"{', '.join(ARENAS)}, or a file as `khepera-forage arena write` writes it ({CORRIDOR})"
ARENA = option("--arena", _ARENA_HELP, None, "NAME|FILE")
"""None stands for the corridor, so that a choice can be told; likewise for the noise and the food types."""
_NOISE_HELP = f"laboratory, none, or some of {', '.join(SOURCES)}, separated by commas (laboratory)"
NOISE = option("--noise", _NOISE_HELP, None, "SOURCES")
FOOD_TYPE = option("--food-type", "of all food: PICKABLE, PUSHABLE or POISONOUS (PICKABLE; in mixed_foods all of them)")
LAB = option(
    "--lab",
    f"use the real robots and the camera that this lab.toml describes; '{VIRTUAL_LAB}' uses simulated "
    f"robots behind the real drivers, '{VIRTUAL_LAB}:e-puck2' and '{VIRTUAL_LAB}:toio' other ones",
    metavar="FILE",
)
_DECISION_HELP = f"""decide otherwise what the thesis leaves open, such as next_to_food=22; may be repeated
('khepera-forage decisions' lists all names). The first one may be a version, {" or ".join(VERSIONS)}, which the others
then change"""
DECISION = option("--decision", _DECISION_HELP, None, "NAME=VALUE", action="append", default=[])
ALLOW_OTHER_DECISIONS = flag("--allow-other-decisions", "accept experience files recorded under other decisions")


def refuse_ignored(arguments: argparse.Namespace, options: Sequence[str], where: str) -> None:
    """Refuse options that were given (are not None, False or empty) but have an effect only `where`."""
    for name in options:
        value = getattr(arguments, name.removeprefix("--").replace("-", "_"), None)
        if value is not None and value is not False and value != []:  # 0 is a value that was given
            raise ValueError(f"{name} has no effect here; allowed: {where}")


def refuse_ignored_in_laboratory(arguments: argparse.Namespace) -> None:
    """Refuse options that a laboratory's file replaces, and those that have an effect in simulations only."""
    if arguments.lab is None:
        return
    if arguments.lab.partition(":")[0] != VIRTUAL_LAB:
        refuse_ignored(arguments, ["--num-learners"], "without --lab; the file lists the learners")
        refuse_ignored(arguments, ["--arena", "--foods"], "without --lab; the file names the arena")
    refuse_ignored(arguments, ["--noise"], "without --lab")


def check_file(path: Path, endings: Iterable[str]) -> None:
    """Refuse a name of `--out` with another ending, or in a folder that cannot be written; makes the folder."""
    if path.suffix.lower() not in endings:
        raise ValueError(f"--out is {str(path)!r}; allowed: a name that ends in {', '.join(endings)}")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        TemporaryFile(dir=path.parent).close()
    except OSError as error:
        raise OSError(f"--out is {str(path)!r}, where no file can be written: {error.strerror}") from None


def arena_of(arguments: argparse.Namespace) -> str | Arena:
    """The arena that `--arena` names: one of `ARENAS`, or the content of a file."""
    arena: str = CORRIDOR if arguments.arena is None else arguments.arena
    if arena in ARENAS:
        return arena
    if not arena.endswith(ARENA_FILES):
        raise ValueError(f"arena is {arena!r}; allowed: {', '.join(ARENAS)}, or a file *{ARENA_FILES}")
    return read_arena(arena)


def decisions_of(arguments: argparse.Namespace) -> Decisions:
    """The decisions of `--decision`; the defaults without it."""
    return decisions_from_words(arguments.decision)


def noise_of(text: str | None) -> Noise:
    """The noise of `--noise`; the laboratory's without it."""
    if text is None or text in ("laboratory", "none"):
        return checked_noise(text)
    try:
        return Noise.only(*(source.strip() for source in text.split(",")))
    except ValueError as error:
        raise ValueError(f"--noise: {error}, laboratory or none") from None


def training_env(arguments: argparse.Namespace, **kwargs: Any) -> TrainingEnv:
    """Teacher and learners in copies of `--arena`, or with `--lab` in a laboratory, whose devices are printed."""
    decisions, count, arena = decisions_of(arguments), arguments.num_learners or 1, arena_of(arguments)
    kwargs |= {"food_types": arguments.food_type, "decisions": decisions}
    if arguments.lab is None:
        return raw_env(arena, num_learners=count, noise=noise_of(getattr(arguments, "noise", None)), **kwargs)
    with _laboratory(arguments.lab, arena, count + 1, decisions) as (arena, world):
        return raw_env(arena, num_learners=len(world.markers) - 1, noise=Noise.none(), world=world, **kwargs)


def recall_env(arguments: argparse.Namespace, **kwargs: Any) -> BehavioursEnv:
    """A recall environment in `--arena`, or with `--lab` in a laboratory, whose devices are printed."""
    decisions, arena = decisions_of(arguments), arena_of(arguments)
    given = {"food_types": arguments.food_type, "foods": arguments.foods}
    kwargs |= {"decisions": decisions, **{key: value for key, value in given.items() if value is not None}}
    if arguments.lab is None:
        return recall_rollouts.recall_env(arena, noise_of(arguments.noise), **kwargs)
    with _laboratory(arguments.lab, arena, 1, decisions) as (arena, world):
        return recall_rollouts.recall_env(arena, world=world, **kwargs)


@contextmanager
def _laboratory(lab: str, arena: str | Arena, robots: int, decisions: Decisions) -> Iterator[tuple[str | Arena, World]]:
    """The arena and the world of the laboratory of `--lab`, which is closed after an error in the block."""
    world = _opened(lab, arena, robots, decisions)
    own = world.arenas[0]
    try:
        yield own.name if own.name in ARENAS else own, world  # the settings of a named arena apply
    except BaseException:
        world.close()
        raise


def print_late_rounds(env: TrainingEnv | BehavioursEnv) -> None:
    """Print how many rounds of a laboratory took longer than a control step; print nothing for a simulation."""
    clock = getattr(env.world, "clock", None)
    if clock is not None and clock.rounds:
        worst = f", the worst by {1000 * clock.worst_overrun:.0f} ms" if clock.overruns else ""
        print(f"{clock.rounds} rounds, {clock.overruns} over their time{worst}")


def _opened(lab: str, arena: str | Arena, robots: int, decisions: Decisions) -> World:
    """The laboratory of `--lab`, under decisions where its file leaves them open; one robot is that of a recall."""
    require("--lab", "robots", "camera")
    name, _, kind = lab.partition(":")
    if name == VIRTUAL_LAB:
        from khepera_forage.envs.laboratories import virtual_cubes, virtual_laboratory
        from khepera_forage.robots.drivers import FIRMWARES

        kind = kind or KHEPERA.name
        if kind not in MODELS:
            raise ValueError(f"--lab {lab}; allowed: {', '.join(f'{VIRTUAL_LAB}:{model}' for model in MODELS)}")
        if kind not in FIRMWARES:
            cubes = virtual_cubes(arena, robots, decisions)
            print(f"virtual laboratory: cubes {', '.join(cubes.port_urls)}, on a mat")
            return cubes
        virtual = virtual_laboratory(arena, robots, decisions, robot=kind)
        print(f"virtual laboratory: robots at {', '.join(virtual.port_urls)}, a tracker on rendered frames")
        return virtual
    from khepera_forage.envs.laboratories import load_settings
    from khepera_forage.lab.laboratory import Laboratory

    settings = load_settings(lab, decisions)
    if robots == 1:
        settings = settings.for_recall()
    elif len(settings.robots) < 2:
        raise ValueError(f"{lab}: robots has one entry; allowed: a teacher and at least one learner")
    for robot in settings.robots:
        print(f"robot {robot.name} at {robot.port}" + (f", {robot.baud} baud" if robot.baud else ""))
    seen = "a mat" if settings.has_mat else f"camera {settings.camera.source}"
    print(f"{seen}; arena {settings.arena.name}")
    return Laboratory(settings)
