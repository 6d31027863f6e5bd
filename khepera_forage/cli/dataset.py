"""`khepera-forage dataset`: training episodes as a Minari dataset with a data card."""

import argparse
import os
import re
import shutil
from collections.abc import Mapping, Sequence, Set
from contextlib import closing
from typing import Any

import numpy as np

from khepera_forage.cli import options
from khepera_forage.cli.options import command, flag, option
from khepera_forage.envs.arena_settings import settings_of
from khepera_forage.envs.paired_arenas_v1 import raw_env
from khepera_forage.envs.wheels_env import WheelsEnv
from khepera_forage.experience import Experience
from khepera_forage.experience.data_card import CARD, Origin, data_card
from khepera_forage.experience.experience import experience_files
from khepera_forage.extras import require
from khepera_forage.files import replacing
from khepera_forage.option_values import given_path, progress, whole_number
from khepera_forage.rollouts.raw_episodes import LearnerRecorder, RawEpisode, teacher_alone
from khepera_forage.rollouts.training import train
from khepera_forage.sim.arena import Arena
from khepera_forage.task.states import FoodType

FOLDER_VARIABLE = "MINARI_DATASETS_PATH"
EPISODES = 10
SIMULATED = """Teacher and learner were simulated in copies of the arena {arena}, with pymunk and the noise of the
thesis's laboratory. The teacher of section 4.4 foraged for {food}, and the learner listened."""
ALONE = """The teacher of section 4.4 was simulated alone in the arena {arena}, with pymunk and the noise of the
thesis's laboratory. It foraged for {food}, from random places."""


def _dataset_name(text: str) -> str:
    """A name of Minari."""
    if not re.fullmatch(r"([\w-]+/)*[\w-]+-v\d+", text):
        raise argparse.ArgumentTypeError(f"{text!r}; allowed: NAME-vNUMBER, or FOLDER/NAME-vNUMBER")
    return text


@command(
    option(
        "--name", "Minari's name of the dataset (khepera_forage/ARENA-v1, or ARENA-wheels-v1)", _dataset_name
    ),
    option("--episodes", f"complete training episodes ({EPISODES})", whole_number(1)),
    option(
        "--experience",
        "files of 'khepera-forage train' or of real robots, one episode each, or a folder of them, instead of "
        "new episodes",
        given_path,
        "FILE",
        nargs="+",
    ),
    flag("--wheels", "raw data and motors of every round, in place of state vectors and behaviours"),
    flag("--alone", "the teacher forages alone, from random places, in place of training episodes"),
    flag("--protocol", "the datasets of the protocol forage-bench-1: those that its learners learn from"),
    options.seed("the same seed gives the same episodes"),
    options.out("datasets", f"folder of Minari datasets, which Minari finds as {FOLDER_VARIABLE}"),
    option("--author", "for the data card (unknown)", default="unknown"),
    option("--licence", "of the data, for the data card (CC0-1.0)", default="CC0-1.0"),
    options.ARENA,
    options.FOOD_TYPE,
    options.DECISION,
    options.ALLOW_OTHER_DECISIONS,
)
def dataset_command(arguments: argparse.Namespace) -> None:
    """Write training episodes as a Minari dataset with a data card."""
    require("khepera-forage dataset", "minari")
    if arguments.protocol:
        _write_protocol(arguments)
        return
    arena = options.arena_of(arguments)
    recorded: dict[str, Any] = {}
    if arguments.experience:
        ignored = ["--episodes", "--food-type", "--wheels", "--alone"]
        options.refuse_ignored(arguments, ignored, "without --experience")
        files = experience_files(arguments.experience)
        parts = [Experience.load(path) for path in files]
        name = _new_name(arguments, _default_name(arguments, {part.arena for part in parts}))
        procedure = f"The experience was read from {', '.join(path.name for path in files)}."
    else:
        arena_name = arena if isinstance(arena, str) else arena.name
        name = _new_name(arguments, _default_name(arguments, {arena_name}))
        text = ALONE if arguments.alone else SIMULATED
        procedure = text.format(arena=arena_name, food=food_in_training(arguments, arena))
        parts, raw = zip(*_recorded(arguments, arena), strict=True)
        if arguments.wheels:
            recorded["episodes"] = raw
        else:
            recorded["rewards"] = [episode.rewards_of_vectors for episode in raw]
            recorded["truncated"] = [episode.truncated for episode in raw]
    known = None if arguments.experience and not arguments.arena else arena
    _write(arguments, name, parts, procedure, recorded, arguments.alone, known)


def _write_protocol(arguments: argparse.Namespace) -> None:
    """Write the datasets of the protocol."""
    own = ["--name", "--experience", "--wheels", "--alone", "--arena", "--food-type"]
    allowed = "without --protocol, whose datasets have names and arenas of their own"
    options.refuse_ignored(arguments, own, allowed)
    options.refuse_ignored(arguments, ["--decision"], "without --protocol")
    from khepera_forage.comparison.protocol import datasets

    for name, made in datasets(arguments.seed, arguments.episodes).items():
        _new_name(arguments, name)
        about, parts, recorded = made()
        procedure = f"Data of the protocol {name.split('/')[0]}: {about}"
        _write(arguments, name, parts, procedure, recorded, "alone" in name)


def _write(
    arguments: argparse.Namespace,
    name: str,
    parts: Sequence[Experience],
    procedure: str,
    recorded: Mapping[str, Any],
    alone: bool,
    arena: str | Arena | None = None,
) -> None:
    """Write a dataset and its card, and say where they are; `recorded` are further arguments of `to_minari`."""
    folder = arguments.out.resolve()
    # Minari has no other way to choose a folder.
    os.environ[FOLDER_VARIABLE] = str(folder)
    from khepera_forage.experience.minari import to_minari

    given = arguments.command_line, procedure, arguments.licence, arguments.author
    steps = [len(episode.actions) for episode in recorded.get("episodes", ())]
    seed = None if arguments.experience else arguments.seed
    origin = Origin(*given, seed, "episodes" in recorded, steps, alone)
    about = {"author": arguments.author, "description": procedure, **recorded}
    folder /= name
    try:
        to_minari(parts, name, arena=arena, allow_other_decisions=arguments.allow_other_decisions, **about)
        with replacing(folder / CARD) as path:
            path.write_text(data_card(name, parts, origin), encoding="utf-8")
    except BaseException:
        shutil.rmtree(folder, ignore_errors=True)  # Minari leaves an incomplete dataset.
        raise
    print(f"{name}: {len(parts)} episodes, {sum(steps or map(len, parts)):,} steps, in {arguments.out}")
    print(f"data card: {arguments.out / name / CARD}")
    print(f"to load it: {FOLDER_VARIABLE}={arguments.out} and minari.load_dataset({name!r})")


def _default_name(arguments: argparse.Namespace, arenas: Set[str]) -> str:
    """Minari's name of a dataset without `--name`, which says the arena."""
    arena = re.sub(r"[^\w-]", "_", min(arenas)) if len(arenas) == 1 else "procedural"
    kind = "-alone" * arguments.alone + "-wheels" * arguments.wheels
    return f"khepera_forage/{arena}{kind}-v1"


def _new_name(arguments: argparse.Namespace, default: str) -> str:
    """The name of the dataset, which must be new."""
    name: str = arguments.name or default
    if (arguments.out / name).exists():
        raise ValueError(f"--name is {name!r}; allowed: a name that is not in {arguments.out} yet")
    return name


def food_in_training(arguments: argparse.Namespace, arena: str | Arena) -> str:
    """The food in training and its types, for the data card."""
    odds = {} if arguments.food_type else settings_of(arena).get("food_types", {})
    shares = ", ".join(f"{100 * share:g} % {name}" for name, share in odds.items())
    return f"food ({shares})" if shares else f"{arguments.food_type or FoodType.PICKABLE.name} food"


def _recorded(arguments: argparse.Namespace, arena: str | Arena) -> list[tuple[Experience, RawEpisode]]:
    seeds = np.random.SeedSequence(arguments.seed).spawn(arguments.episodes or EPISODES)
    decisions = options.decisions_of(arguments)
    if arguments.alone:
        settings = settings_of(arena) | {"decisions": decisions}
        if arguments.food_type:
            settings["food_types"] = arguments.food_type
        with closing(WheelsEnv(**settings)) as alone:
            numbers = [int(each.generate_state(1)[0]) for each in seeds]
            return [teacher_alone(alone, number) for number in progress(numbers, unit="episode")]
    with closing(raw_env(arena, food_types=arguments.food_type, decisions=decisions)) as env:
        recorder, found = LearnerRecorder(env), []
        for each in progress(seeds, unit="episode"):
            experience, _ = train(env, each, teacher=recorder, callback=recorder)
            found.append((experience, recorder.episode()))
        return found
