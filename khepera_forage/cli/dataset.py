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
from khepera_forage.extras import require
from khepera_forage.files import replacing
from khepera_forage.option_values import given_path, progress, whole_number
from khepera_forage.rollouts.raw_episodes import LearnerRecorder, RawEpisode, teacher_alone
from khepera_forage.rollouts.training import train
from khepera_forage.sim.arena import Arena
from khepera_forage.task.decisions import Decisions
from khepera_forage.task.states import FoodType

FOLDER_VARIABLE = "MINARI_DATASETS_PATH"
EPISODES = 10
SIMULATED = """Teacher and learner were simulated in copies of the arena {arena}, with pymunk and the noise of the
thesis's laboratory. The teacher of section 4.4 foraged for {food}, and the learner listened."""
ALONE = """The teacher of section 4.4 was simulated alone in the arena {arena}, with pymunk and the noise of the
thesis's laboratory. It foraged for {food}, from random places."""
READ = "The experience was read from {files}."


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
def dataset_command(arguments: argparse.Namespace) -> int:
    """Write training episodes as a Minari dataset with a data card."""
    require("khepera-forage dataset", "minari")
    if arguments.protocol:
        return _protocol(arguments)
    decisions, arena = options.decisions_of(arguments), options.arena_of(arguments)
    recorded: dict[str, Any] = {}
    if arguments.experience:
        options.refuse_ignored(
            arguments, ["--episodes", "--food-type", "--wheels", "--alone"], "without --experience"
        )
        files = options.experience_files(arguments.experience)
        parts = [Experience.load(path) for path in files]
        name = _free_name(arguments, {part.arena for part in parts})
        source, procedure = None, READ.format(files=", ".join(path.name for path in files))
    else:
        name = _free_name(arguments, {_name_of(arena)})
        source = arguments.seed
        text = ALONE if arguments.alone else SIMULATED
        procedure = text.format(arena=_name_of(arena), food=food_in_training(arguments, arena))
        parts, raw = zip(*_recorded(arguments, arena, decisions), strict=True)
        if arguments.wheels:
            recorded["episodes"] = raw
        else:
            recorded["rewards"] = [episode.rewards_of_vectors for episode in raw]
            recorded["truncated"] = [episode.truncated for episode in raw]
    origin = Origin(
        _command(arguments, name), procedure, arguments.licence, arguments.author, source, arguments.wheels
    )._replace(alone=arguments.alone)
    known = arena if arguments.arena or source is not None else None
    _write(arguments, name, parts, origin, known, recorded)
    return 0


def _write(
    arguments: argparse.Namespace,
    name: str,
    parts: Sequence[Experience],
    origin: Origin,
    arena: str | Arena | None,
    recorded: Mapping[str, Any],
) -> None:
    """Write a dataset and its card, and say where they are; `recorded` are further arguments of `to_minari`."""
    folder = arguments.out.resolve()
    # Minari has no other way to choose a folder.
    os.environ[FOLDER_VARIABLE] = str(folder)
    from khepera_forage.experience.minari import to_minari

    steps = [len(episode.actions) for episode in recorded.get("episodes", ())]
    folder /= name
    try:
        to_minari(
            parts,
            name,
            arena=arena,
            allow_other_decisions=arguments.allow_other_decisions,
            author=arguments.author,
            description=origin.procedure,
            **recorded,
        )
        with replacing(folder / CARD) as path:
            path.write_text(data_card(name, parts, origin._replace(steps=steps)), encoding="utf-8")
    except BaseException:
        shutil.rmtree(folder, ignore_errors=True)  # Minari leaves an incomplete dataset.
        raise
    print(f"{name}: {len(parts)} episodes, {sum(steps or map(len, parts)):,} steps, in {arguments.out}")
    print(f"data card: {arguments.out / name / CARD}")
    print(f"to load it: {FOLDER_VARIABLE}={arguments.out} and minari.load_dataset({name!r})")


def _protocol(arguments: argparse.Namespace) -> int:
    """Write the datasets of the protocol."""
    options.refuse_ignored(
        arguments,
        ["--name", "--experience", "--wheels", "--alone", "--arena", "--food-type"],
        "without --protocol, whose datasets have names and arenas of their own",
    )
    options.refuse_ignored(arguments, ["--decision"], "without --protocol")
    from khepera_forage.comparison.protocol import datasets

    command = f"khepera-forage dataset --protocol --seed {arguments.seed}"
    if arguments.episodes:
        command += f" --episodes {arguments.episodes}"
    for name, made in datasets(arguments.seed, arguments.episodes).items():
        _free_name(argparse.Namespace(name=name, out=arguments.out), set())
        about, parts, recorded = made()
        wheels = "episodes" in recorded
        procedure = f"Data of the protocol {name.split('/')[0]}: {about}"
        origin = Origin(command, procedure, arguments.licence, arguments.author, arguments.seed, wheels)
        origin = origin._replace(alone="alone" in name)
        _write(arguments, name, parts, origin, None, recorded)
    return 0


def _free_name(arguments: argparse.Namespace, arenas: Set[str]) -> str:
    """Minari's name of the dataset, which must be new: that of `--name`, or one that says the arenas."""
    name: str = arguments.name
    if not name:
        arena = re.sub(r"[^\w-]", "_", min(arenas)) if len(arenas) == 1 else "procedural"
        kind = "-alone" * arguments.alone + "-wheels" * arguments.wheels
        name = f"khepera_forage/{arena}{kind}-v1"
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


def _recorded(
    arguments: argparse.Namespace, arena: str | Arena, decisions: Decisions
) -> list[tuple[Experience, RawEpisode]]:
    seeds = np.random.SeedSequence(arguments.seed).spawn(arguments.episodes or EPISODES)
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
    words += (
        ["--wheels"] * arguments.wheels
        + ["--alone"] * arguments.alone
        + [f"--decision {word}" for word in arguments.decision]
    )
    return " ".join(words)
