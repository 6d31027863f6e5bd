"""`khepera-forage teach`: a person is the teacher, with keys in a window (4.5)."""

import argparse
import math
import shlex
from contextlib import closing
from pathlib import Path

import numpy as np

from khepera_forage.cli.teaching.keys import LETTERS, BegunAgain, Ended
from khepera_forage.cli.teaching.person import Person
from khepera_forage.envs.training import TrainingEnv
from khepera_forage.experience import Experience
from khepera_forage.rollouts import training


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The command's arguments."""
    keys = ", ".join(
        f"{letter} or {int(b)} {b.name.replace('_', ' ').lower()}" for b, letter in LETTERS.items()
    )
    parser.description = (
        "You are the teacher: shout the behaviours with keys, and the learner records, does the same, and stays beside "
        f"the teacher. Enter begins. Keys: {keys}. A tap is one round, a held key goes on, and without a key nothing "
        "moves. Space: the same again; Backspace: forget this attempt and begin again; Escape: end, and keep the "
        "episodes that are complete. While the learner is separated the robots wait for it by themselves."
    )
    parser.add_argument("--arena", choices=("corridor", "rectangle"), default="corridor", help="(corridor)")
    parser.add_argument("--food-type", default="PICKABLE", help="PICKABLE, PUSHABLE or POISONOUS (PICKABLE)")
    parser.add_argument("--episodes", type=int, default=1, help="complete training episodes, a file each (1)")
    parser.add_argument("--out", type=Path, default=Path("taught"), help="folder for g1.csv, ... (taught)")
    parser.add_argument("--seed", type=int, default=0, help="the same seed gives the same episodes (0)")
    parser.add_argument(
        "--pace",
        type=float,
        default=5.0,
        help="rounds a second while a key is held (5: half the speed of real robots)",
    )
    parser.add_argument(
        "--hints",
        action="store_true",
        help="show the state of table 4.1 too: the hand-coded teacher's answer",
    )


def run(arguments: argparse.Namespace) -> int:
    """Teach, and say what was taught.

    Raises:
        ValueError: A number out of range.
        OSError: An experience file is there already, or there is no display.
        ImportError: pygame is missing.
    """
    if arguments.episodes < 1:
        raise ValueError(f"--episodes is {arguments.episodes}; allowed: at least 1")
    if not 0 < arguments.pace < math.inf:
        raise ValueError(f"--pace is {arguments.pace}; allowed: a positive number of rounds a second")
    paths = [arguments.out / f"g{number}.csv" for number in range(1, arguments.episodes + 1)]
    for path in paths:
        if path.exists():
            raise FileExistsError(f"{path} exists; choose another --out, or remove it first")
    from khepera_forage.cli.teaching.window import TeachingWindow

    env = TrainingEnv(arena=arguments.arena, food_types=arguments.food_type)
    with closing(env), closing(TeachingWindow()) as window:
        arguments.out.mkdir(parents=True, exist_ok=True)
        person = Person(env, window, arguments.episodes, arguments.pace, arguments.hints)
        _teach(env, person, paths, arguments)
    return 0


def _teach(env: TrainingEnv, person: Person, paths: list[Path], arguments: argparse.Namespace) -> None:
    """A complete episode a file, until all are taught or the person ends it; and what to do with them."""
    taught: list[Path] = []
    vectors = decisions = agreed = 0
    seeds = np.random.SeedSequence(arguments.seed).spawn(len(paths))
    for number, (path, seed) in enumerate(zip(paths, seeds, strict=True), 1):
        person.episode = number
        try:
            experience = _episode(env, person, path, seed)
        except (Ended, KeyboardInterrupt):
            path.unlink(missing_ok=True)  # of an attempt that is not complete
            break
        taught.append(path)
        vectors += len(experience)
        decisions += person.decisions
        agreed += person.agreed
        said = f"{len(experience)} experience vectors, {_agreement(person.agreed, person.decisions)}"
        print(f"{path}: {said}", flush=True)
        person.news = f"Episode {number} is complete: {said}."
    if not taught:
        print("nothing is complete, so nothing is kept")
        return
    print(f"{len(taught)} episode(s), {vectors} experience vectors, {_agreement(agreed, decisions)}")
    command = ["khepera-forage", "recall", "--arena", arguments.arena, "--experience", *map(str, taught)]
    print(f"next: {shlex.join(command)}", flush=True)
    if len(taught) == len(paths):
        person.take_leave()


def _episode(env: TrainingEnv, person: Person, path: Path, seed: np.random.SeedSequence) -> Experience:
    """One complete episode, however often the person begins again."""
    while True:
        try:
            return training.train(env, seed, path=path, watch=person.watch, teacher=person)[0]
        except BegunAgain:
            path.unlink(missing_ok=True)
            (seed,) = seed.spawn(1)


def _agreement(agreed: int, decisions: int) -> str:
    return f"{100 * agreed / max(decisions, 1):.0f} % of the decisions as the hand-coded teacher's"
