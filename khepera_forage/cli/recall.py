"""`khepera-forage recall`: a trained learner, or the teacher, forages alone (4.6, 5.4)."""

import argparse
import warnings
from contextlib import closing
from typing import TYPE_CHECKING

import numpy as np

from khepera_forage.cli.arguments import (
    add_allow_other_decisions_argument,
    add_arena_argument,
    add_decision_argument,
    add_episodes_argument,
    add_food_type_argument,
    add_lab_argument,
    add_noise_argument,
    add_out_argument,
    add_seed_argument,
    experience_files,
    is_real,
    refuse_ignored,
)
from khepera_forage.cli.environments import print_late_rounds, recall_env
from khepera_forage.envs.behaviours_env import BehavioursEnv
from khepera_forage.experience import Experience, ExperienceWarning
from khepera_forage.option_values import given_path, progress, whole_number
from khepera_forage.policies import Policy, Teacher
from khepera_forage.rollouts import recall as recall_rollouts
from khepera_forage.rollouts.row_files import RowWriter
from khepera_forage.rollouts.rows import IMITATOR, TEACHER, RecallRow

if TYPE_CHECKING:
    from khepera_forage.policies.learners import FromVectors


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
        help="experience files of the learner, or a folder of them (without any, the teacher forages)",
    )
    parser.add_argument(
        "--learner",
        metavar="NAME|PLACE",
        help="what learns from the experience: an imitator that `khepera-forage compare --list` lists, or "
        "package.module:name of what makes a classifier (imitator)",
    )
    add_arena_argument(parser)
    parser.add_argument(
        "--foods", type=whole_number(1), metavar="N", help="food objects (those of the arena)"
    )
    add_food_type_argument(parser)
    add_noise_argument(parser)
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
        refuse_ignored(arguments, ["--arena", "--foods"], "without --lab; the file names the arena")
    if arguments.lab is not None:
        refuse_ignored(arguments, ["--noise"], "without --lab")
    if not arguments.experience:
        ignored = ["--learner", "--allow-other-decisions", "--recover"]
        refuse_ignored(arguments, ignored, "with --experience")


def policy_of(arguments: argparse.Namespace, env: BehavioursEnv) -> tuple[Policy, str, int]:
    """The policy that forages, its name in rows, and its number of experience vectors.

    Raises:
        ExperienceError: An experience file is not valid, or of other decisions than the environment.
        OSError: An experience file cannot be read.
    """
    if not arguments.experience:
        return Teacher.of(env), TEACHER, 0
    from khepera_forage.policies import NearestNeighbourImitator
    from khepera_forage.policies.learner_registry import own_errors

    name = arguments.learner or IMITATOR
    learner = _learner(name)
    with warnings.catch_warnings(record=True) as recovered:
        warnings.simplefilter("always", ExperienceWarning)
        experience = Experience.load(
            *experience_files(arguments.experience),
            decisions=env.decisions,
            allow_other_decisions=arguments.allow_other_decisions,
            recover=arguments.recover,
        )
    for warning in recovered:
        if issubclass(warning.category, ExperienceWarning):
            print(warning.message)
    vectors, behaviours = experience.arrays()
    if name == IMITATOR:
        imitator = NearestNeighbourImitator(env.diagonal, arithmetic=env.decisions.distance_arithmetic)
        return imitator.fit(vectors, behaviours), name, len(behaviours)
    with own_errors(f"--learner {name}"):
        policy = learner.learn(vectors, behaviours, env.diagonal, arguments.seed)
    return policy, name, len(behaviours)


def _learner(name: str) -> "FromVectors":
    """The learner of `--learner`.

    Raises:
        ValueError: There is none, or it does not learn from experience vectors.
    """
    from khepera_forage.policies.learner_registry import installed_learners, learner_at
    from khepera_forage.policies.learners import LEARNERS, FromVectors

    known = {**LEARNERS, **installed_learners().learners}
    usable = {key: value for key, value in known.items() if isinstance(value, FromVectors)}
    if name in usable:
        return usable[name]
    if ":" not in name:
        raise ValueError(f"--learner is {name!r}; allowed: {', '.join(usable)}, or package.module:name")
    try:
        _, learner = learner_at(name)
    except ValueError as error:
        raise ValueError(f"--{error}") from None
    if not isinstance(learner, FromVectors):
        raise ValueError(
            f"--learner is {name!r}, which learns from {learner.needs.value}; allowed: from vectors"
        )
    return learner


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
                    env,
                    policy,
                    seed,
                    learner=learner,
                    noise=arguments.noise or "laboratory",
                    number=number,
                    experience_size=size,
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
