"""`khepera-forage recall`: a trained learner, or the teacher, forages alone (4.6, 5.4)."""

import argparse
import sys
from pathlib import Path

import numpy as np
from tqdm import tqdm

from khepera_forage.envs.behaviours_env import BehavioursEnv
from khepera_forage.experience import Experience
from khepera_forage.experiments import recalling
from khepera_forage.experiments.row_files import RowWriter
from khepera_forage.experiments.rows import IMITATOR, TEACHER, RecallRow
from khepera_forage.policies import NearestNeighbourImitator, Policy, Teacher


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
    """
    if arguments.episodes < 1:
        raise ValueError(f"--episodes is {arguments.episodes}; allowed: at least 1")
    env = recalling.recall_env(arguments.arena, food_types=arguments.food_type)
    policy, learner, size = forager_of(arguments, env)
    seeds = np.random.SeedSequence(arguments.seed).generate_state(arguments.episodes).tolist()
    rows = []
    print(" recall    steps  correct  penalty    score     food")
    with RowWriter(arguments.out, RecallRow) as writer:
        for number, seed in enumerate(tqdm(seeds, unit="recall", disable=not sys.stderr.isatty())):
            row = recalling.recall(env, policy, seed, learner=learner, number=number, experience_size=size)
            writer.write(row)
            rows.append(row)
            print(
                f"{number + 1:7d} {row.steps:8d} {row.correct:8d} {row.penalty:7d} % {row.score:6.1f} % "
                f"{row.delivered:4d} / {row.foods}"
            )
    print(
        f"mean score {np.mean([row.score for row in rows]):.1f} %, food "
        f"{sum(row.delivered for row in rows)} / {sum(row.foods for row in rows)}; rows in {arguments.out}"
    )
    env.close()
    return 0
