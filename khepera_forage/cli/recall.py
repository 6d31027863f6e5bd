"""`khepera-forage recall`: a trained learner, or the teacher, forages alone (4.6, 5.4)."""

import argparse
import warnings
from contextlib import closing

import numpy as np

from khepera_forage.cli.arguments import (
    add_allow_other_decisions_argument,
    add_arena_argument,
    add_decision_argument,
    add_episodes_argument,
    add_food_type_argument,
    add_lab_argument,
    add_out_argument,
    add_seed_argument,
    is_real,
    refuse_ignored,
)
from khepera_forage.cli.environments import print_late_rounds, recall_env
from khepera_forage.envs.behaviours_env import BehavioursEnv
from khepera_forage.experience import Experience, ExperienceWarning
from khepera_forage.option_values import given_path, progress
from khepera_forage.policies import Policy, Teacher
from khepera_forage.rollouts import recall as recall_rollouts
from khepera_forage.rollouts.row_files import RowWriter
from khepera_forage.rollouts.rows import IMITATOR, TEACHER, RecallRow


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command's arguments."""
    add_policy_arguments(parser)
    add_episodes_argument(parser, 10, "recall episodes")
    add_out_argument(parser, "results/recall.csv", "file for the rows")


def add_policy_arguments(parser: argparse.ArgumentParser) -> None:
    """Add what determines a recall: policy, arena, food type, seed, laboratory and decisions."""
    parser.add_argument(
        "--experience",
        type=given_path,
        nargs="+",
        metavar="FILE",
        help="experience files of the imitator (without any, the teacher forages)",
    )
    add_arena_argument(parser)
    add_food_type_argument(parser)
    add_seed_argument(parser, "the same seed gives the same episodes")
    parser.add_argument(
        "--recover",
        action="store_true",
        help="also read experience files of interrupted training episodes, as far as they go",
    )
    add_lab_argument(parser)
    add_decision_argument(parser)
    add_allow_other_decisions_argument(parser)


def check_policy_arguments(arguments: argparse.Namespace) -> None:
    """Refuse what has no effect on the policy or in a laboratory.

    Raises:
        ValueError: An option that was given is ignored.
    """
    if is_real(arguments.lab):
        refuse_ignored(arguments, ["--arena"], "without --lab; the file names the arena")
    if not arguments.experience:
        refuse_ignored(arguments, ["--allow-other-decisions", "--recover"], "with --experience")


def policy_of(arguments: argparse.Namespace, env: BehavioursEnv) -> tuple[Policy, str, int]:
    """The policy that forages, its name in rows, and its number of experience vectors.

    Raises:
        ExperienceError: An experience file is not valid, or of other decisions than the environment.
        OSError: An experience file cannot be read.
    """
    if not arguments.experience:
        return Teacher.of(env), TEACHER, 0
    from khepera_forage.policies import NearestNeighbourImitator

    with warnings.catch_warnings(record=True) as recovered:
        warnings.simplefilter("always", ExperienceWarning)
        experience = Experience.load(
            *arguments.experience,
            decisions=env.decisions,
            allow_other_decisions=arguments.allow_other_decisions,
            recover=arguments.recover,
        )
    for warning in recovered:
        if issubclass(warning.category, ExperienceWarning):
            print(warning.message)
    vectors, behaviours = experience.arrays()
    imitator = NearestNeighbourImitator(env.diagonal, arithmetic=env.decisions.distance_arithmetic)
    return imitator.fit(vectors, behaviours), IMITATOR, len(behaviours)


def run(arguments: argparse.Namespace) -> int:
    """Forage, and print a line for each episode and the means.

    Raises:
        ValueError: A number or a decision is not allowed, or an experience file cannot be used.
        OSError: The laboratory of `--lab` cannot be used.
    """
    check_policy_arguments(arguments)
    with closing(recall_env(arguments)) as env:
        rows = _recall(env, arguments)
        print_late_rounds(env)
    if not rows:
        raise ConnectionError("a robot or the camera was lost in every recall; there is no result")
    print(
        f"mean score {np.mean([row.score for row in rows]):.1f} %, food "
        f"{sum(row.delivered for row in rows)} / {sum(row.foods for row in rows)}; rows in {arguments.out}"
    )
    return 0


def _recall(env: BehavioursEnv, arguments: argparse.Namespace) -> list[RecallRow]:
    """One row for each episode; an episode in which a real robot or the camera was lost is reported without a row."""
    policy, learner, size = policy_of(arguments, env)
    seeds = np.random.SeedSequence(arguments.seed).generate_state(arguments.episodes).tolist()
    rows = []
    # An operator of real robots answers questions on the screen that a progress bar would use.
    hidden = arguments.lab is not None
    print(" recall    steps  correct  penalty    score     food")
    with RowWriter(arguments.out, RecallRow) as writer:
        for number, seed in enumerate(progress(seeds, hidden, unit="recall")):
            try:
                row = recall_rollouts.recall(
                    env, policy, seed, learner=learner, number=number, experience_size=size
                )
            except recall_rollouts.RecallInterruptedError as error:
                print(f"{number + 1:7d} interrupted {error}")
                continue
            writer.write(row)
            rows.append(row)
            print(
                f"{number + 1:7d} {row.steps:8d} {row.correct:8d} {row.penalty:7d} % {row.score:6.1f} % "
                f"{row.delivered:4d} / {row.foods}"
            )
    return rows
