"""`khepera-forage watch`: show a training or recall episode in a window, or save it as a film."""

import argparse
import itertools
from collections.abc import Callable
from contextlib import closing
from typing import Any

import numpy as np
from numpy.typing import NDArray

from khepera_forage.cli.arguments import (
    add_num_learners_argument,
    decisions_of,
    is_real,
    noise_of,
    refuse_ignored,
)
from khepera_forage.cli.environments import recall_env, training_env
from khepera_forage.cli.recall import add_policy_arguments, check_policy_arguments, policy_of
from khepera_forage.envs.rendering.output import FILM_EXTRAS, open_display, save_film
from khepera_forage.envs.training import TrainingEnv
from khepera_forage.extras import require
from khepera_forage.option_values import given_path, progress, whole_number
from khepera_forage.rollouts import recall as recall_rollouts
from khepera_forage.rollouts import training

EVERY = 2
"""Rounds a frame of a film, without `--every`."""
TRIES = 20
"""Attempts at a training among which the first complete one is filmed."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command's arguments."""
    parser.add_argument("phase", choices=("training", "recall"), help="what to show")
    add_policy_arguments(parser)
    add_num_learners_argument(parser, "learners in training (1)")
    parser.add_argument(
        "--out", type=given_path, help="save a film (.gif, .mp4, .avi) here, without a window"
    )
    parser.add_argument(
        "--every",
        type=whole_number(1, 1000),
        metavar="N",
        help=f"the film has one frame every N rounds ({EVERY})",
    )


def run(arguments: argparse.Namespace) -> int:
    """Show or film one episode, and print its result.

    Raises:
        ValueError: A number or a decision is not allowed, or an experience file cannot be used.
        OSError: The laboratory of `--lab` cannot be used, or there is no display.
    """
    decisions = decisions_of(arguments)
    _check(arguments)
    frames: list[NDArray[np.uint8]] = []
    run_phase = _run_training if arguments.phase == "training" else _run_recall
    run_phase(arguments, frames)
    if arguments.out is not None:
        save_film(frames, arguments.out, fps=1 / (decisions.round_duration * arguments.every))
        print(f"{arguments.out}: {len(frames)} frames")
    return 0


def _check(arguments: argparse.Namespace) -> None:
    """Refuse what has no effect in this phase, check what is needed, and fill in the defaults.

    Raises:
        ValueError: An option that was given is ignored, or the film has another ending.
        ImportError: An extra is not installed.
        OSError: There is no display.
    """
    if arguments.phase == "training":
        refuse_ignored(
            arguments,
            ["--experience", "--learner", "--foods", "--allow-other-decisions", "--recover"],
            "with `watch recall`",
        )
        if is_real(arguments.lab):
            refuse_ignored(arguments, ["--num-learners"], "without --lab; the file lists the learners")
            refuse_ignored(arguments, ["--arena"], "without --lab; the file names the arena")
        if arguments.lab is not None:
            refuse_ignored(arguments, ["--noise"], "without --lab")
    else:
        refuse_ignored(arguments, ["--num-learners"], "with `watch training`")
        check_policy_arguments(arguments)
    extras = ["render"]
    if arguments.out is None:
        refuse_ignored(arguments, ["--every"], "with --out")
    elif (kind := arguments.out.suffix.lower()) not in FILM_EXTRAS:
        raise ValueError(
            f"--out is {str(arguments.out)!r}; allowed: a name that ends in {', '.join(FILM_EXTRAS)}"
        )
    else:
        extras.append(FILM_EXTRAS[kind])
    if arguments.lab is not None:
        extras += ["robots", "camera"]
    require("khepera-forage watch", *dict.fromkeys(extras))
    if arguments.out is None:
        open_display()
    arguments.every = arguments.every or EVERY


def _run_training(arguments: argparse.Namespace, frames: list[NDArray[np.uint8]]) -> None:
    settings: dict[str, Any] = {"render_mode": _render_mode(arguments)}
    if arguments.lab is None:
        settings["noise"] = noise_of(arguments.noise)
    with closing(training_env(arguments, **settings)) as env:
        seed = arguments.seed
        if arguments.out is not None and arguments.lab is None:
            seed = _complete_attempt(env, seed)
        result = training.attempt(env, seed, _ignore, callback=_frame_recorder(env, frames, arguments))
    outcome = "complete" if result.complete else result.lost or result.reason
    print(f"{outcome} after {result.rounds} rounds")


def _complete_attempt(env: TrainingEnv, seed: int) -> int:
    """The seed of the first attempt that is complete, the given one or one derived from it; else the given one."""
    others = np.random.SeedSequence(seed).generate_state(TRIES - 1).tolist()
    for number, each in enumerate((seed, *others), 1):
        result = training.attempt(env, each, _ignore)
        if result.complete:
            return int(each)
        print(f"attempt {number}: {result.reason} after {result.rounds} rounds, not filmed", flush=True)
    print(f"none of {TRIES} attempts is complete, so the film shows the first", flush=True)
    return seed


def _ignore(vector: object, behaviour: object) -> None:
    """A recording of which nothing is kept."""


def _run_recall(arguments: argparse.Namespace, frames: list[NDArray[np.uint8]]) -> None:
    with closing(recall_env(arguments, render_mode=_render_mode(arguments))) as env:
        policy, learner, size = policy_of(arguments, env)
        row = recall_rollouts.recall(
            env,
            policy,
            arguments.seed,
            learner=learner,
            noise=arguments.noise or "laboratory",
            experience_size=size,
            callback=_frame_recorder(env, frames, arguments),
        )
    print(f"score {row.score:.1f} % in {row.steps} steps, food {row.delivered} / {row.foods}")


def _render_mode(arguments: argparse.Namespace) -> str:
    return "human" if arguments.out is None else "rgb_array"


def _frame_recorder(
    env: Any, frames: list[NDArray[np.uint8]], arguments: argparse.Namespace
) -> Callable[[], None]:
    """A callback that appends a frame every `--every` rounds; without `--out` the environment draws by itself."""
    rounds = progress(hidden=arguments.out is None, desc="film", unit="round")
    number = itertools.count()

    def record() -> None:
        if arguments.out is not None and next(number) % arguments.every == 0:
            frames.append(env.render())
        rounds.update()

    return record
