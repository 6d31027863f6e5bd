"""`khepera-forage recall` and `watch`: a trained learner, or the teacher, forages alone (4.6, 5.4), and is shown."""

import argparse
import itertools
import warnings
from collections.abc import Callable
from contextlib import closing
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from khepera_forage.cli import options
from khepera_forage.cli.options import command, flag, option
from khepera_forage.envs.behaviours_env import BehavioursEnv
from khepera_forage.envs.rendering.output import FILM_EXTRAS, open_display, save_film
from khepera_forage.envs.training import TrainingEnv
from khepera_forage.experience import Experience, ExperienceWarning
from khepera_forage.experience.experience import experience_files, load_each
from khepera_forage.extras import require
from khepera_forage.option_values import given_path, progress, whole_number
from khepera_forage.policies import NearestNeighbourImitator, Policy, Teacher
from khepera_forage.policies.learner_registry import installed_learners, learner_at, own_errors
from khepera_forage.policies.learners import LEARNERS, OfflineImitation
from khepera_forage.rollouts import recall as recall_rollouts
from khepera_forage.rollouts import training
from khepera_forage.rollouts.row_files import RowWriter
from khepera_forage.rollouts.rows import IMITATOR, TEACHER, RecallRow

EVERY = 2
"""Rounds a frame of a film, without `--every`."""
TRIES = 20
"""Attempts at a training among which the first complete one is filmed."""
_EXPERIENCE = "experience files of the learner, or a folder of them (without any, the teacher forages)"
_LEARNER = """what learns from the experience: an imitator that `khepera-forage compare --list` lists, or
package.module:name of what makes a classifier (imitator)"""
_POLICY = (
    option("--experience", _EXPERIENCE, given_path, "FILE", nargs="+", default=[]),
    option("--learner", _LEARNER, None, "NAME|PLACE"),
    options.ARENA,
    option("--foods", "food objects (those of the arena)", whole_number(1), "N"),
    options.FOOD_TYPE,
    options.NOISE,
    options.seed("the same seed gives the same episodes"),
    flag("--recover", "also read experience files of interrupted training episodes, as far as they go"),
    options.LAB,
    options.DECISION,
    options.ALLOW_OTHER_DECISIONS,
)


@command(*_POLICY, options.episodes(10, "recall episodes"), options.out("results/recall.csv", "file for the rows"))
def recall_command(arguments: argparse.Namespace) -> None:
    """Let a trained learner, or the teacher, forage alone."""
    _check_policy(arguments)
    if arguments.out.exists() and any(arguments.out.samefile(file) for file in experience_files(arguments.experience)):
        raise ValueError(f"--out is {str(arguments.out)!r}, a file of --experience; allowed: another name")
    with closing(options.recall_env(arguments)) as env:
        rows = _rows(env, arguments)
        options.print_late_rounds(env)
    if not rows:
        raise ConnectionError("a robot or the camera was lost in every recall; there is no result")
    food = f"{sum(row.delivered for row in rows)} / {sum(row.foods for row in rows)}"
    print(f"mean score {np.mean([row.score for row in rows]):.1f} %, food {food}; rows in {arguments.out}")


def _check_policy(arguments: argparse.Namespace) -> None:
    """Refuse what has no effect on the policy or in a laboratory."""
    options.refuse_ignored_in_laboratory(arguments)
    if not arguments.experience:
        ignored = ["--learner", "--allow-other-decisions", "--recover"]
        options.refuse_ignored(arguments, ignored, "with --experience")


def _rows(env: BehavioursEnv, arguments: argparse.Namespace) -> list[RecallRow]:
    """One row for each episode; an episode in which a real robot or the camera was lost is reported without a row."""
    forage = _forage(env, arguments)
    seeds = np.random.SeedSequence(arguments.seed).generate_state(arguments.episodes).tolist()
    rows = []
    hidden = arguments.lab is not None  # an operator of real robots answers questions on that screen
    print(" recall    steps  correct  penalty    score     food")
    with RowWriter(arguments.out, RecallRow) as writer:
        for number, each in enumerate(progress(seeds, hidden, unit="recall")):
            try:
                row = forage(each, number=number)
            except recall_rollouts.RecallInterruptedError as error:
                print(f"{number + 1:7d} interrupted {error}")
                continue
            writer.write(row)
            rows.append(row)
            counts = f"{number + 1:7d} {row.steps:8d} {row.correct:8d} {row.penalty:7d} %"
            print(f"{counts} {row.score:6.1f} % {row.delivered:4d} / {row.foods}")
    return rows


def _forage(env: BehavioursEnv, arguments: argparse.Namespace) -> Callable[..., RecallRow]:
    """A recall by a seed, with the policy that the arguments choose."""
    forage: Callable[..., RecallRow] = partial(recall_rollouts.recall, env, noise=arguments.noise or "laboratory")
    if not arguments.experience:
        return partial(forage, Teacher.of(env), learner=TEACHER, experience_size=0)
    name = arguments.learner or IMITATOR
    learner = _learner(name)
    others = arguments.allow_other_decisions
    with warnings.catch_warnings(record=True) as recovered:
        warnings.simplefilter("always", ExperienceWarning)
        parts = load_each(  # one for each training episode
            arguments.experience, decisions=env.decisions, allow_other_decisions=others, recover=arguments.recover
        )
    for warning in recovered:
        print(warning.message)
    vectors, behaviours = Experience.join(parts, allow_other_decisions=others).arrays()
    if not len(vectors):
        raise ValueError("--experience has no experience vectors; allowed: at least one")
    if name == IMITATOR:
        imitator = NearestNeighbourImitator(env.diagonal, arithmetic=env.decisions.distance_arithmetic)
        policy: Policy = imitator.fit(vectors, behaviours)
    else:
        with own_errors(f"--learner {name}"):
            groups = np.repeat(np.arange(len(parts)), [len(part) for part in parts])
            policy = learner.learn(vectors, behaviours, env.diagonal, arguments.seed, groups)
        forage = own_errors(f"--learner {name}")(forage)
    return partial(forage, policy, learner=name, experience_size=len(behaviours))


def _learner(name: str) -> OfflineImitation:
    """The learner of `--learner`, which must learn from experience vectors."""
    installed = installed_learners()
    known = {**LEARNERS, **installed.learners}
    usable = {key: value for key, value in known.items() if isinstance(value, OfflineImitation)}
    if name in usable:
        return usable[name]
    if ":" not in name:
        why = installed.why_not(name)
        raise ValueError(f"--learner is {name!r}{why}; allowed: {', '.join(usable)}, or package.module:name")
    try:
        _, learner = learner_at(name)
    except ValueError as error:
        raise ValueError(f"--{error}") from None
    if not isinstance(learner, OfflineImitation):
        raise ValueError(f"--learner is {name!r}, which learns from {learner.needs.value}; allowed: from vectors")
    return learner


@command(
    option("phase", "what to show", choices=("training", "recall")),
    *_POLICY,
    option("--num-learners", "learners in training (1)", whole_number(1)),
    option("--out", "save a film (.gif, .mp4, .avi) here, without a window", given_path),
    option("--every", f"the film has one frame every N rounds ({EVERY})", whole_number(1, 1000), "N"),
)
def watch_command(arguments: argparse.Namespace) -> None:
    """Show a training or recall episode in a window, or save it as a film."""
    decisions = options.decisions_of(arguments)
    _check_watch(arguments)
    film: Path | None = arguments.out
    frames: list[Any] = []
    is_training = arguments.phase == "training"
    made: Any = options.training_env if is_training else options.recall_env
    with closing(made(arguments, render_mode="human" if film is None else "rgb_array")) as env:
        rounds = progress(hidden=film is None, desc="film", unit="round")
        number = itertools.count()

        def record() -> None:
            """Keep a frame every `--every` rounds; without a film the environment draws by itself."""
            if film is not None and next(number) % arguments.every == 0:
                frames.append(env.render())
            rounds.update()

        if is_training:
            print(_watch_training(env, arguments, record))
        else:
            row = _forage(env, arguments)(arguments.seed, callback=record)
            print(f"score {row.score:.1f} % in {row.steps} steps, food {row.delivered} / {row.foods}")
        if film is not None and (next(number) - 1) % arguments.every:
            frames.append(env.render())  # how it ended, also between two frames
    if film is not None:
        save_film(frames, film, fps=1 / (decisions.round_duration * arguments.every))
        print(f"{film}: {len(frames)} frames")


def _check_watch(arguments: argparse.Namespace) -> None:
    """Refuse what has no effect in this phase, check what is needed, and fill in the defaults."""
    if arguments.phase == "training":
        ignored = ["--experience", "--learner", "--foods", "--allow-other-decisions", "--recover"]
        options.refuse_ignored(arguments, ignored, "with `watch recall`")
        options.refuse_ignored_in_laboratory(arguments)
    else:
        options.refuse_ignored(arguments, ["--num-learners"], "with `watch training`")
        _check_policy(arguments)
    extras = ["render", *(["robots", "camera"] if arguments.lab is not None else [])]
    if arguments.out is None:
        options.refuse_ignored(arguments, ["--every"], "with --out")
        require("khepera-forage watch", *extras)
        open_display()
    else:
        options.check_file(arguments.out, FILM_EXTRAS)
        require("khepera-forage watch", *dict.fromkeys([*extras, FILM_EXTRAS[arguments.out.suffix.lower()]]))
    arguments.every = arguments.every or EVERY


def _watch_training(env: Any, arguments: argparse.Namespace, record: Callable[[], None]) -> str:
    is_chosen = arguments.out is not None and arguments.lab is None
    seed = _complete_attempt(env, arguments.seed) if is_chosen else arguments.seed
    result = training.attempt(env, seed, lambda vector, behaviour: None, callback=record)
    return f"{'complete' if result.complete else result.lost or result.reason} after {result.rounds} rounds"


def _complete_attempt(env: TrainingEnv, seed: int) -> int:
    """The seed of the first attempt that is complete, the given one or one derived from it; else the given one."""
    others = np.random.SeedSequence(seed).generate_state(TRIES - 1).tolist()
    for number, each in enumerate((seed, *others), 1):
        result = training.attempt(env, each, lambda vector, behaviour: None)
        if result.complete:
            return int(each)
        print(f"attempt {number}: {result.reason} after {result.rounds} rounds, not filmed", flush=True)
    print(f"none of {TRIES} attempts is complete, so the film shows the first", flush=True)
    return seed
