"""`khepera-forage recall`: a trained learner, or the teacher, forages alone (4.6, 5.4)."""

import argparse
import sys
from contextlib import closing
from pathlib import Path

import numpy as np
from tqdm import tqdm

from khepera_forage.cli.laboratory import add_lab_argument, recall_env, report
from khepera_forage.envs.behaviours_env import BehavioursEnv
from khepera_forage.experience import Experience
from khepera_forage.policies import NearestNeighbourImitator, Policy, Teacher
from khepera_forage.rollouts import recall as recalling
from khepera_forage.rollouts.row_files import RowWriter
from khepera_forage.rollouts.rows import IMITATOR, TEACHER, RecallRow


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The command's arguments."""
    add_policy_arguments(parser)
    parser.add_argument("--episodes", type=int, default=10, help="recall episodes (10)")
    parser.add_argument(
        "--out", type=Path, default=Path("results/recall.csv"), help="rows (results/recall.csv)"
    )


def add_policy_arguments(parser: argparse.ArgumentParser) -> None:
    """Who forages, where, and with which seed."""
    parser.add_argument(
        "--experience",
        type=Path,
        nargs="+",
        metavar="FILE",
        help="experience files; without any, the teacher",
    )
    parser.add_argument("--arena", choices=("corridor", "rectangle"), default="corridor", help="(corridor)")
    parser.add_argument("--food-type", default="PICKABLE", help="PICKABLE, PUSHABLE or POISONOUS (PICKABLE)")
    parser.add_argument("--seed", type=int, default=0, help="the same seed gives the same episodes (0)")
    add_lab_argument(parser)


def forager_of(arguments: argparse.Namespace, env: BehavioursEnv) -> tuple[Policy, str, int]:
    """The policy asked for, its name, and the size of its experience."""
    if not arguments.experience:
        return Teacher(env.home_radius), TEACHER, 0
    vectors, behaviours = Experience.load(*arguments.experience).arrays()
    return NearestNeighbourImitator(diagonal=env.diagonal).fit(vectors, behaviours), IMITATOR, len(behaviours)


def run(arguments: argparse.Namespace) -> int:
    """Forage, and print a line an episode and the means.

    Raises:
        ValueError: A number out of range, or an experience file that cannot be used.
        OSError: With `--lab`, what is in the way of the laboratory.
    """
    if arguments.episodes < 1:
        raise ValueError(f"--episodes is {arguments.episodes}; allowed: at least 1")
    with closing(recall_env(arguments)) as env:
        rows = _recalled(env, arguments)
        report(env)
    if not rows:
        raise ConnectionError("every recall was cut short")
    print(
        f"mean score {np.mean([row.score for row in rows]):.1f} %, food "
        f"{sum(row.delivered for row in rows)} / {sum(row.foods for row in rows)}; rows in {arguments.out}"
    )
    return 0


def _recalled(env: BehavioursEnv, arguments: argparse.Namespace) -> list[RecallRow]:
    """One row an episode; an episode in which a real robot was lost is told of and gives none."""
    policy, learner, size = forager_of(arguments, env)
    seeds = np.random.SeedSequence(arguments.seed).generate_state(arguments.episodes).tolist()
    rows = []
    quiet = arguments.lab is not None or not sys.stderr.isatty()  # an operator is asked on the same screen
    print(" recall    steps  correct  penalty    score     food")
    with RowWriter(arguments.out, RecallRow) as writer:
        for number, seed in enumerate(tqdm(seeds, unit="recall", disable=quiet)):
            try:
                row = recalling.recall(
                    env, policy, seed, learner=learner, number=number, experience_size=size
                )
            except recalling.RecallCutShort as lost:
                print(f"{number + 1:7d} cut short {lost}")
                continue
            writer.write(row)
            rows.append(row)
            print(
                f"{number + 1:7d} {row.steps:8d} {row.correct:8d} {row.penalty:7d} % {row.score:6.1f} % "
                f"{row.delivered:4d} / {row.foods}"
            )
    return rows
