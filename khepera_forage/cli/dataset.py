"""`khepera-forage dataset`: training episodes as a Minari dataset with a data card."""

import argparse
import os
import re
import shutil
from collections.abc import Set
from contextlib import closing

import numpy as np

from khepera_forage.cli.arguments import (
    add_allow_other_decisions_argument,
    add_arena_argument,
    add_decision_argument,
    add_food_type_argument,
    add_out_argument,
    add_seed_argument,
    arena_of,
    decisions_of,
    experience_files,
    refuse_ignored,
)
from khepera_forage.envs.arena_settings import settings_of
from khepera_forage.envs.paired_arenas_v1 import raw_env
from khepera_forage.experience import Experience
from khepera_forage.experience.data_card import CARD, Origin, data_card
from khepera_forage.extras import require
from khepera_forage.files import replacing
from khepera_forage.option_values import given_path, progress, whole_number
from khepera_forage.rollouts.training import train
from khepera_forage.sim.arena import Arena
from khepera_forage.task.decisions import Decisions
from khepera_forage.task.states import FoodType

FOLDER_VARIABLE = "MINARI_DATASETS_PATH"
EPISODES = 10
SIMULATED = """Teacher and learner were simulated in copies of the arena {arena}, with pymunk and the noise of the
thesis's laboratory. The teacher of section 4.4 foraged for {food}, and the learner listened."""
READ = "The experience was read from {files}."


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command's arguments."""
    parser.add_argument(
        "--name",
        type=_dataset_name,
        help="Minari's name of the dataset (khepera_forage/ARENA-v0, with the arena of the episodes)",
    )
    parser.add_argument("--episodes", type=whole_number(1), help=f"complete training episodes ({EPISODES})")
    parser.add_argument(
        "--experience",
        nargs="+",
        type=given_path,
        metavar="FILE",
        help="files of 'khepera-forage train' or of real robots, one episode each, or a folder of them, instead of new "
        "episodes",
    )
    add_seed_argument(parser, "the same seed gives the same episodes")
    add_out_argument(
        parser, "datasets", f"folder of Minari datasets, which Minari finds as {FOLDER_VARIABLE}"
    )
    parser.add_argument("--author", default="unknown", help="for the data card (unknown)")
    parser.add_argument("--licence", default="CC0-1.0", help="of the data, for the data card (CC0-1.0)")
    add_arena_argument(parser)
    add_food_type_argument(parser)
    add_decision_argument(parser)
    add_allow_other_decisions_argument(parser)


def run(arguments: argparse.Namespace) -> int:
    """Record or read the episodes, write the dataset and its card, and say where they are.

    Raises:
        ValueError: The name is invalid or taken, or an option has no effect or is not allowed.
        ImportError: Minari is not installed.
        OSError: A file cannot be read or written.
    """
    require("khepera-forage dataset", "minari")
    decisions, arena = decisions_of(arguments), arena_of(arguments)
    if arguments.experience:
        refuse_ignored(arguments, ["--episodes", "--food-type"], "without --experience")
        files = experience_files(arguments.experience)
        parts = [Experience.load(path) for path in files]
        name = _free_name(arguments, {part.arena for part in parts})
        seed, procedure = None, READ.format(files=", ".join(path.name for path in files))
    else:
        name = _free_name(arguments, {_name_of(arena)})
        seed = arguments.seed
        procedure = SIMULATED.format(arena=_name_of(arena), food=food_in_training(arguments, arena))
        parts = _recorded(arguments, arena, decisions)
    out = arguments.out.resolve()
    # Minari has no other way to choose a folder.
    os.environ[FOLDER_VARIABLE] = str(out)
    from khepera_forage.experience.minari import to_minari

    origin = Origin(_command(arguments, name), procedure, arguments.licence, arguments.author, seed)
    folder = out / name
    try:
        to_minari(
            parts,
            name,
            arena=arena if arguments.arena or not arguments.experience else None,
            allow_other_decisions=arguments.allow_other_decisions,
            author=arguments.author,
            description=procedure,
        )
        with replacing(folder / CARD) as path:
            path.write_text(data_card(name, parts, origin), encoding="utf-8")
    except BaseException:
        shutil.rmtree(folder, ignore_errors=True)  # Minari leaves an incomplete dataset.
        raise
    print(f"{name}: {len(parts)} episodes, {sum(map(len, parts)):,} steps, in {arguments.out}")
    print(f"data card: {arguments.out / name / CARD}")
    print(f"to load it: {FOLDER_VARIABLE}={arguments.out} and minari.load_dataset({name!r})")
    return 0


def _dataset_name(text: str) -> str:
    """A name of Minari.

    Raises:
        argparse.ArgumentTypeError: The text is something else.
    """
    if not re.fullmatch(r"([\w-]+/)*[\w-]+-v\d+", text):
        raise argparse.ArgumentTypeError(f"{text!r}; allowed: NAME-vNUMBER, or FOLDER/NAME-vNUMBER")
    return text


def _free_name(arguments: argparse.Namespace, arenas: Set[str]) -> str:
    """Minari's name of the dataset: that of `--name`, or one that says the arena.

    Args:
        arguments: Of the command.
        arenas: Names of the arenas of all episodes.

    Raises:
        ValueError: There is a dataset of this name.
    """
    arena = re.sub(r"[^\w-]", "_", min(arenas)) if len(arenas) == 1 else "procedural"
    name: str = arguments.name or f"khepera_forage/{arena}-v0"
    if (arguments.out / name).exists():
        raise ValueError(f"--name is {name!r}; allowed: a name that is not in {arguments.out} yet")
    return name


def _name_of(arena: str | Arena) -> str:
    return arena if isinstance(arena, str) else arena.name


def food_in_training(arguments: argparse.Namespace, arena: str | Arena) -> str:
    """The food in training and its types, for the data card."""
    odds = {} if arguments.food_type else settings_of(arena).get("food_types", {})
    shares = ", ".join(f"{100 * share:g} % {name}" for name, share in odds.items())
    return f"food ({shares})" if shares else f"{arguments.food_type or FoodType.PICKABLE.name} food"


def _recorded(arguments: argparse.Namespace, arena: str | Arena, decisions: Decisions) -> list[Experience]:
    seeds = np.random.SeedSequence(arguments.seed).spawn(arguments.episodes or EPISODES)
    with closing(raw_env(arena, food_types=arguments.food_type, decisions=decisions)) as env:
        return [train(env, seed)[0] for seed in progress(seeds, unit="episode")]


def _command(arguments: argparse.Namespace, name: str) -> str:
    """The command that makes the same dataset."""
    words = ["khepera-forage dataset", f"--name {name}"]
    if arguments.experience:
        words.append(f"--experience {' '.join(map(str, arguments.experience))}")
    else:
        words += [f"--episodes {arguments.episodes or EPISODES}", f"--seed {arguments.seed}"]
    if arguments.arena:
        words.append(f"--arena {arguments.arena}")
    if arguments.food_type:
        words.append(f"--food-type {arguments.food_type}")
    words += [f"--decision {word}" for word in arguments.decision]
    return " ".join(words)
