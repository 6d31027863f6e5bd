"""`khepera-forage teach`: arguments, episodes and experience files."""

import argparse
import shlex
from contextlib import closing
from pathlib import Path

import numpy as np

from khepera_forage.cli.arguments import (
    add_arena_argument,
    add_decision_argument,
    add_episodes_argument,
    add_food_type_argument,
    add_out_argument,
    add_seed_argument,
    arena_of,
    decisions_of,
)
from khepera_forage.cli.teach.human_teacher import HumanTeacher
from khepera_forage.cli.teach.keys import LETTERS, QuitRequest, RestartRequest
from khepera_forage.cli.train import PlannedFile, planned_files, require_new
from khepera_forage.envs.paired_arenas_v1 import raw_env
from khepera_forage.envs.training import TrainingEnv
from khepera_forage.experience import Experience
from khepera_forage.extras import require
from khepera_forage.option_values import real_number
from khepera_forage.rollouts import training
from khepera_forage.sim.arenas.thesis import CORRIDOR


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command's arguments and its description."""
    keys = ", ".join(
        f"{letter} or {int(b)} {b.name.replace('_', ' ').lower()}" for b, letter in LETTERS.items()
    )
    parser.description = (
        "You are the teacher: choose behaviours with keys. The learner records each one, executes it too, and follows "
        f"the teacher. Enter begins an attempt. Keys: {keys}. A tap is one round, a held key repeats the behaviour, "
        "and without a key nothing moves. Space: repeat the last behaviour; Backspace: discard this attempt and begin "
        "again; Escape: end, and keep the complete episodes. While the learner is separated the robots bring it back "
        "by themselves."
    )
    add_arena_argument(parser)
    add_food_type_argument(parser)
    add_episodes_argument(parser, 1, "complete training episodes, one file each")
    add_out_argument(parser, "taught", "folder for g1.csv, g2.csv, ...")
    add_seed_argument(parser, "the same seed gives the same episodes")
    parser.add_argument(
        "--pace",
        type=real_number(0.0, 1000.0, "rounds a second"),
        default=5.0,
        help="rounds a second while a key is held (5: half the speed of real robots)",
    )
    parser.add_argument(
        "--hints",
        action="store_true",
        help="also show the state of table 4.1, which determines what the hand-coded teacher would do",
    )
    add_decision_argument(parser)


def run(arguments: argparse.Namespace) -> int:
    """Open the window, record the episodes, and print what was recorded.

    Raises:
        ValueError: A number or a decision is not allowed.
        OSError: An experience file is there already, or there is no display.
        ImportError: pygame is not installed.
    """
    decisions, arena = decisions_of(arguments), arena_of(arguments)
    files = planned_files(arguments.out, arguments.episodes, arguments.seed)
    require_new(files, "choose another --out, or remove it first")
    require("teaching", "render")
    from khepera_forage.cli.teach.window import TeachingWindow

    env = raw_env(arena, food_types=arguments.food_type, decisions=decisions)
    with closing(env), closing(TeachingWindow()) as window:
        arguments.out.mkdir(parents=True, exist_ok=True)
        teacher = HumanTeacher(env, window, arguments.episodes, arguments.pace, arguments.hints)
        _teach(env, teacher, files, arguments)
    return 0


def _teach(
    env: TrainingEnv, teacher: HumanTeacher, files: list[PlannedFile], arguments: argparse.Namespace
) -> None:
    """Record one complete episode for each file, until the person quits; print a summary and the next command."""
    recorded: list[Path] = []
    vectors = choices = agreed = 0
    for number, path, seed in files:
        teacher.episode = number
        try:
            experience = _record_episode(env, teacher, path, seed)
        except (QuitRequest, KeyboardInterrupt):
            path.unlink(missing_ok=True)  # the file of an incomplete attempt
            break
        recorded.append(path)
        vectors += len(experience)
        choices += teacher.choices
        agreed += teacher.agreed
        summary = f"{len(experience)} experience vectors, {_agreement(teacher.agreed, teacher.choices)}"
        print(f"{path}: {summary}", flush=True)
        teacher.news = f"Episode {number} is complete: {summary}."
    if not recorded:
        print("no episode is complete, so no file is kept")
        return
    print(f"{len(recorded)} episode(s), {vectors} experience vectors, {_agreement(agreed, choices)}")
    command = [
        "khepera-forage",
        "recall",
        "--arena",
        arguments.arena or CORRIDOR,
        "--experience",
        *map(str, recorded),
    ]
    for assignment in arguments.decision:
        command += ["--decision", assignment]
    print(f"next: {shlex.join(command)}", flush=True)
    if len(recorded) == len(files):
        teacher.show_end()


def _record_episode(
    env: TrainingEnv, teacher: HumanTeacher, path: Path, seed: np.random.SeedSequence
) -> Experience:
    """One complete episode; after each restart by the person it begins again with another seed."""
    while True:
        try:
            return training.train(env, seed, path=path, callback=teacher.after_round, teacher=teacher)[0]
        except RestartRequest:
            path.unlink(missing_ok=True)
            (seed,) = seed.spawn(1)


def _agreement(agreed: int, choices: int) -> str:
    return f"{100 * agreed / max(choices, 1):.0f} % of the behaviours as the hand-coded teacher's"
