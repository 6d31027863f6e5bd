"""`khepera-forage train`: experience files g1.csv, g2.csv, ... as in the thesis (5.3)."""

import argparse
import sys
from contextlib import closing
from pathlib import Path

import numpy as np
from tqdm import tqdm

from khepera_forage.cli.laboratory import add_lab_argument, report, training_env
from khepera_forage.envs.training import PATIENCE, TrainingEnv
from khepera_forage.rollouts import training
from khepera_forage.rollouts.row_files import RowWriter
from khepera_forage.rollouts.rows import TrainingRow


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The command's arguments."""
    parser.add_argument(
        "--episodes", type=int, default=10, help="complete training episodes, a file each (10)"
    )
    parser.add_argument("--seed", type=int, default=0, help="the same seed gives the same files (0)")
    parser.add_argument(
        "--out", type=Path, default=Path("experience"), help="folder for g1.csv, ... (experience)"
    )
    parser.add_argument("--food-type", default="PICKABLE", help="PICKABLE, PUSHABLE or POISONOUS (PICKABLE)")
    parser.add_argument(
        "--num-learners",
        type=int,
        default=1,
        help="in as many corridors; the first records (1; with --lab FILE as many as it has)",
    )
    parser.add_argument(
        "--patience", type=int, default=PATIENCE, help=f"rounds of separation borne ({PATIENCE})"
    )
    parser.add_argument(
        "--resume", action="store_true", help="pause and resume: put a lost learner beside the teacher"
    )
    add_lab_argument(parser)


def run(arguments: argparse.Namespace) -> int:
    """Train, and say what it took.

    Raises:
        ValueError: A number that is out of range.
        HopelessTraining: None of many attempts at an episode was complete.
        OSError: An experience file is there already; with `--lab`, what is in the way of the laboratory.
    """
    if arguments.episodes < 1:
        raise ValueError(f"--episodes is {arguments.episodes}; allowed: at least 1")
    arguments.out.mkdir(parents=True, exist_ok=True)
    paths = [arguments.out / f"g{number}.csv" for number in range(1, arguments.episodes + 1)]
    for path in paths:
        if path.exists():
            raise FileExistsError(f"{path} exists; choose another --out, or remove it first")
    with closing(training_env(arguments, patience=arguments.patience)) as env:
        with RowWriter(arguments.out / "attempts.csv", TrainingRow) as attempts:
            _train(env, paths, arguments, attempts)
        report(env)
    return 0


def _train(
    env: TrainingEnv, paths: list[Path], arguments: argparse.Namespace, attempts: RowWriter[TrainingRow]
) -> None:
    """A complete episode a file, and a row an attempt."""
    quiet = arguments.lab is not None or not sys.stderr.isatty()  # an operator is asked on the same screen
    seeds = np.random.SeedSequence(arguments.seed).spawn(len(paths))
    for number, (path, seed) in enumerate(
        tqdm(list(zip(paths, seeds, strict=True)), unit="episode", disable=quiet), 1
    ):
        experience, rows = training.train(env, seed, file=number, path=path, resume=arguments.resume)
        attempts.write(*rows)
        print(
            f"{path}: {len(experience)} experience vectors, {len(rows)} attempt(s), {rows[-1].rounds} rounds"
        )
