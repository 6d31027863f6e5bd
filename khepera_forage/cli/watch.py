"""`khepera-forage watch`: a training or a recall in a window as it happens, or as a film."""

import argparse
from collections.abc import Callable
from contextlib import closing
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from khepera_forage.cli.laboratory import recall_env, training_env
from khepera_forage.cli.recall import add_policy_arguments, forager_of
from khepera_forage.envs.rendering import save_gif
from khepera_forage.rollouts import recall as recalling
from khepera_forage.rollouts import training


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The command's arguments."""
    parser.add_argument("phase", choices=("training", "recall"), help="what to show")
    add_policy_arguments(parser)
    parser.add_argument("--num-learners", type=int, default=1, help="in training (1)")
    parser.add_argument("--out", type=Path, help="save a film (GIF) here instead of opening a window")
    parser.add_argument("--every", type=int, default=2, help="a film takes every so many rounds (2)")


def run(arguments: argparse.Namespace) -> int:
    """Show it.

    Raises:
        ValueError: A number out of range, or an experience file that cannot be used.
    """
    if arguments.every < 1:
        raise ValueError(f"--every is {arguments.every}; allowed: at least 1")
    if arguments.out is not None and arguments.out.suffix.lower() != ".gif":
        raise ValueError(f"--out is {str(arguments.out)!r}; allowed: a name that ends in .gif")
    mode = "human" if arguments.out is None else "rgb_array"
    frames: list[NDArray[np.uint8]] = []
    if arguments.phase == "training":
        with closing(training_env(arguments, render_mode=mode)) as pair:
            result = training.attempt(
                pair, arguments.seed, lambda v, b: None, watch=_camera(pair, frames, arguments)
            )
        print(
            f"{'complete' if result.complete else result.lost or result.reason} after {result.rounds} rounds"
        )
    else:
        with closing(recall_env(arguments, render_mode=mode)) as env:
            policy, learner, size = forager_of(arguments, env)
            row = recalling.recall(
                env,
                policy,
                arguments.seed,
                learner=learner,
                experience_size=size,
                watch=_camera(env, frames, arguments),
            )
        print(f"score {row.score:.1f} % in {row.steps} steps, food {row.delivered} / {row.foods}")
    if arguments.out is not None:
        save_gif(frames, arguments.out, fps=10 / arguments.every)
        print(f"{arguments.out}: {len(frames)} frames")
    return 0


def _camera(env: Any, frames: list[NDArray[np.uint8]], arguments: argparse.Namespace) -> Callable[[], object]:
    """Takes a frame every so many rounds; in a window the environment shows itself."""
    rounds = 0

    def shoot() -> None:
        nonlocal rounds
        if arguments.out is not None and rounds % arguments.every == 0:
            frames.append(env.render())
        rounds += 1

    return shoot
