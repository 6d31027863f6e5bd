"""`khepera-forage dataset`: training episodes as a Minari dataset with a data card."""

import argparse
import os
import re
import shutil
import sys
from contextlib import closing

import numpy as np
from tqdm import tqdm

from khepera_forage.cli.arguments import (
    add_allow_other_decisions_argument,
    add_decision_argument,
    add_food_type_argument,
    add_out_argument,
    add_seed_argument,
    decisions_of,
    refuse_ignored,
)
from khepera_forage.envs.training import TrainingEnv
from khepera_forage.experience import Experience
from khepera_forage.experience.data_card import CARD, Origin, data_card
from khepera_forage.extras import require
from khepera_forage.files import replacing
from khepera_forage.option_values import given_path, whole_number
from khepera_forage.rollouts.training import train
from khepera_forage.task.decisions import Decisions
from khepera_forage.task.states import FoodType

FOLDER_VARIABLE = "MINARI_DATASETS_PATH"
EPISODES = 10
SIMULATED = """The paired corridors were simulated with pymunk and the noise of the thesis's laboratory. The teacher of
section 4.4 foraged for {food} food and the learner listened."""
READ = "The experience was read from {files}."


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command's arguments."""
    parser.add_argument(
        "--name",
        type=_dataset_name,
        default="khepera_forage/corridor-v0",
        help="Minari's name of the dataset (khepera_forage/corridor-v0)",
    )
    parser.add_argument("--episodes", type=whole_number(1), help=f"complete training episodes ({EPISODES})")
    parser.add_argument(
        "--experience",
        nargs="+",
        type=given_path,
        metavar="FILE",
        help="files of 'khepera-forage train' or of real robots, one episode each, instead of new episodes",
    )
    add_seed_argument(parser, "the same seed gives the same episodes")
    add_out_argument(
        parser, "datasets", f"folder of Minari datasets, which Minari finds as {FOLDER_VARIABLE}"
    )
    parser.add_argument("--author", default="unknown", help="for the data card (unknown)")
    parser.add_argument("--licence", default="CC0-1.0", help="of the data, for the data card (CC0-1.0)")
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
    decisions = decisions_of(arguments)
    if arguments.experience:
        refuse_ignored(arguments, ["--episodes"], "without --experience")
    out = arguments.out.resolve()
    if (out / arguments.name).exists():
        raise ValueError(f"--name is {arguments.name!r}; allowed: a name that is not in {arguments.out} yet")
    if arguments.experience:
        seed, procedure = None, READ.format(files=", ".join(path.name for path in arguments.experience))
        parts = [Experience.load(path) for path in arguments.experience]
    else:
        seed, procedure = arguments.seed, SIMULATED.format(food=arguments.food_type or FoodType.PICKABLE.name)
        parts = _recorded(arguments, decisions)
    # Minari has no other way to choose a folder.
    os.environ[FOLDER_VARIABLE] = str(out)
    from khepera_forage.experience.minari import to_minari

    origin = Origin(_command(arguments), procedure, arguments.licence, arguments.author, seed)
    folder = out / arguments.name
    try:
        to_minari(
            parts,
            arguments.name,
            allow_other_decisions=arguments.allow_other_decisions,
            author=arguments.author,
            description=procedure,
        )
        with replacing(folder / CARD) as path:
            path.write_text(data_card(arguments.name, parts, origin), encoding="utf-8")
    except BaseException:
        shutil.rmtree(folder, ignore_errors=True)  # Minari leaves an incomplete dataset.
        raise
    print(f"{arguments.name}: {len(parts)} episodes, {sum(map(len, parts)):,} steps, in {arguments.out}")
    print(f"data card: {arguments.out / arguments.name / CARD}")
    print(f"to load it: {FOLDER_VARIABLE}={arguments.out} and minari.load_dataset({arguments.name!r})")
    return 0


def _dataset_name(text: str) -> str:
    """A name of Minari.

    Raises:
        argparse.ArgumentTypeError: The text is something else.
    """
    if not re.fullmatch(r"([\w-]+/)*[\w-]+-v\d+", text):
        raise argparse.ArgumentTypeError(f"{text!r}; allowed: NAME-vNUMBER, or FOLDER/NAME-vNUMBER")
    return text


def _recorded(arguments: argparse.Namespace, decisions: Decisions) -> list[Experience]:
    seeds = np.random.SeedSequence(arguments.seed).spawn(arguments.episodes or EPISODES)
    with closing(TrainingEnv(food_types=arguments.food_type, decisions=decisions)) as env:
        return [train(env, seed)[0] for seed in tqdm(seeds, unit="episode", disable=not sys.stderr.isatty())]


def _command(arguments: argparse.Namespace) -> str:
    """The command that makes the same dataset."""
    words = ["khepera-forage dataset", f"--name {arguments.name}"]
    if arguments.experience:
        words.append(f"--experience {' '.join(map(str, arguments.experience))}")
    else:
        words += [f"--episodes {arguments.episodes or EPISODES}", f"--seed {arguments.seed}"]
    words += [f"--decision {word}" for word in arguments.decision]
    return " ".join(words)
