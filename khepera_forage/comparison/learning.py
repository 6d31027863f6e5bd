"""How each learner learns, in growing amounts, and what it reaches in every arena: the units of work and their rows.

All of them learn in the corridor alone.
"""

import inspect
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, fields
from functools import cache, lru_cache, partial
from importlib.util import find_spec
from pathlib import Path
from time import perf_counter
from typing import Any, ClassVar, NamedTuple
from zlib import crc32

import numpy as np
from numpy.typing import NDArray
from threadpoolctl import threadpool_limits

from khepera_forage.envs.arena_settings import procedural_settings
from khepera_forage.envs.behaviours_env import BehavioursEnv
from khepera_forage.envs.training import TrainingEnv
from khepera_forage.policies import Teacher
from khepera_forage.policies.learner_registry import LearnerError, installed_learners, own_errors
from khepera_forage.policies.learners import (
    LEARNERS,
    InteractiveImitation,
    Learner,
    OfflineImitation,
    ReinforcementLearner,
)
from khepera_forage.policies.policy import UniformPolicy
from khepera_forage.rollouts.dagger import dagger
from khepera_forage.rollouts.recall import WheelsRecall, recall, recall_env, recall_wheels, recall_wheels_env
from khepera_forage.rollouts.reinforcement import reinforce
from khepera_forage.rollouts.rows import RecallRow
from khepera_forage.rollouts.training import arrays, train
from khepera_forage.sim.arenas.difficulty import DIFFICULTIES
from khepera_forage.sim.arenas.named import ARENAS as NAMED
from khepera_forage.sim.arenas.thesis import THESIS_ARENAS
from khepera_forage.task.states import FoodType, StateVector

ARENAS = THESIS_ARENAS
"""Where learners are tested by default; all of them learn in the first."""
ALL_ARENAS = (*NAMED, *DIFFICULTIES)
"""Where they can be tested: named arenas, and procedural test arenas of a difficulty."""


@dataclass(frozen=True, slots=True)
class RecallBatch:
    """Recalls of one learner, after one amount of learning, in one arena.

    Attributes:
        learner: Its name among the learners; `teacher` and `random` learn nothing.
        replication: Number of the repetition, with seeds and training files of its own.
        amount: Training episodes, queries, or environment steps, as requested; 0 without learning.
        arena: One of `ALL_ARENAS`.
        steps: Environment steps of the learning: rounds of all training attempts, queries, or steps of the trials.
        vectors: Experience vectors or answers of the teacher that the learner used; 0 for reinforcement learning.
        score: Their mean (equation 5.1), in percent.
        delivered: Food objects carried home in all of them, without poisonous ones.
        foods: Food objects in all of them that are not poisonous.
        recall_steps: Steps of all of them.
        seconds: Wall time of the learning so far, including the simulation.
    """

    learner: str
    replication: int
    amount: int
    arena: str
    steps: int
    vectors: int
    recalls: int
    score: float
    delivered: int
    foods: int
    recall_steps: int
    seconds: float


@dataclass(frozen=True, slots=True)
class Baseline:
    """A policy that learns nothing, for comparison: the expert is the teacher, the other draws uniformly."""

    title: str
    expert: bool
    needs: ClassVar[None] = None


BASELINES = {"teacher": Baseline("the teacher", True), "random": Baseline("random behaviours", False)}
"""By name: the upper limit for imitation, and the chance level."""
Compared = Learner | Baseline


class Learned(NamedTuple):
    """A learner after some environment steps of learning."""

    steps: int
    vectors: int
    seconds: float
    policy: Callable[[Any], Any]


def learn(learner: Compared, amounts: Sequence[int], seeds: np.random.SeedSequence) -> Iterator[Learned]:
    """The learner after each amount of learning, in increasing order.

    All imitators of a replication, which has its seeds, have the same training episodes.
    """
    seed = int(seeds.generate_state(1)[0]) % 2**31
    match learner:
        case OfflineImitation():
            yield from _imitate(learner, amounts, seeds.spawn(amounts[-1]), seed)
        case InteractiveImitation():
            yield from _query(learner, amounts, seed)
        case ReinforcementLearner():
            for policy, steps, seconds in reinforce(learner, amounts, seed):
                yield Learned(steps, 0, seconds, partial(lambda policy, env: policy, policy))
        case Baseline():
            yield Learned(0, 0, 0.0, Teacher.of if learner.expert else lambda _: UniformPolicy())


def _imitate(
    learner: OfflineImitation, amounts: Sequence[int], seeds: Sequence[np.random.SeedSequence], seed: int
) -> Iterator[Learned]:
    env = TrainingEnv()
    files = []
    steps, seconds = 0, 0.0
    for number, file_seed in enumerate(seeds, 1):
        began = perf_counter()
        experience, attempts = train(env, file_seed, file=number)
        seconds += perf_counter() - began
        files.append(experience)
        steps += sum(row.rounds for row in attempts)
        if number in amounts:
            vectors, behaviours = arrays(files)
            groups = np.repeat(np.arange(number), [len(file.vectors) for file in files])
            policy, fitting = _policy(learner, vectors, behaviours, seed, groups)
            yield Learned(steps, len(vectors), seconds + fitting, policy)
    env.close()


def _query(learner: InteractiveImitation, amounts: Sequence[int], seed: int) -> Iterator[Learned]:
    """Every amount is learned from the start with the same seed, so that its time is complete."""
    student = learner.learner
    env = recall_env("corridor")
    for amount in amounts:
        began = perf_counter()
        asked = dagger(
            lambda: student.classifier(env.diagonal, seed), env, amount, seed, sample=student.sample, **learner.settings
        )
        seconds = perf_counter() - began
        policy, _ = _policy(student, asked.vectors, asked.behaviours, seed, None)
        yield Learned(amount, amount, seconds, policy)
    env.close()


def _policy(
    learner: OfflineImitation,
    vectors: NDArray[np.int64],
    behaviours: NDArray[np.int64],
    seed: int,
    groups: NDArray[np.int64] | None,
) -> tuple[Callable[[BehavioursEnv], Any], float]:
    """The policy in an environment, the same in all if the learner takes no diagonal; and the seconds of one fit."""
    corridor = recall_env(ARENAS[0]).diagonal
    fitted = cache(lambda diagonal: learner.learn(vectors, behaviours, diagonal, seed, groups))
    began = perf_counter()
    fitted(corridor)
    seconds = perf_counter() - began
    return lambda env: fitted(env.diagonal if learner.diagonal else corridor), seconds


def learn_and_forage(
    seed: int,
    replication: int,
    name: str,
    learner: Compared,
    amounts: Sequence[int],
    recalls: int,
    arenas: Sequence[str],
) -> list[RecallBatch]:
    """One learner in one replication learns and is tested in some arenas; the rows by amount, then arena.

    Amounts are training episodes, queries or steps in increasing order; after each there are so many recalls in each
    of the thesis's arenas, and after the last one in each of the others, where recalls take long. Linear algebra runs
    on one thread, because sums depend on the number of threads.
    """
    sequence = np.random.SeedSequence(seed, spawn_key=(replication,))
    learning, *testing = sequence.spawn(1 + len(ALL_ARENAS))
    # The same places for every learner and after every amount.
    seeds = {arena: testing[ALL_ARENAS.index(arena)].generate_state(recalls).tolist() for arena in arenas}
    batches = []
    # For this call alone: pymunk reports an error for worlds that are left when Python ends.
    env_of, wheels_env_of = lru_cache(len(ALL_ARENAS))(_recall_env), cache(recall_wheels_env)
    with threadpool_limits(1), own_errors(f"learner {name}"):
        for amount, learned in zip(amounts, learn(learner, amounts, learning), strict=True):
            for arena in arenas:
                if arena not in ARENAS and amount != amounts[-1]:
                    continue
                foods, rows = 0, list[RecallRow | WheelsRecall]()
                for level, own in enumerate(seeds[arena], replication * recalls):
                    if isinstance(learner, ReinforcementLearner) and learner.wheels:
                        env: Any = wheels_env_of(arena)
                        rows.append(recall_wheels(env, learned.policy(env), own))
                    else:
                        env = env_of(arena, level if arena in DIFFICULTIES else 0)
                        rows.append(recall(env, learned.policy(env), own))
                    foods += sum(food.type != FoodType.POISONOUS for food in env.forager.food.objects)
                batches.append(
                    RecallBatch(
                        learner=name,
                        replication=replication,
                        amount=amount,
                        arena=arena,
                        steps=learned.steps,
                        vectors=learned.vectors,
                        recalls=len(rows),
                        score=float(np.mean([row.score for row in rows])),
                        delivered=sum(row.delivered for row in rows),
                        foods=foods,
                        recall_steps=sum(row.steps for row in rows),
                        seconds=learned.seconds,
                    )
                )
    return batches


def _recall_env(arena: str, level: int) -> BehavioursEnv:
    if arena not in DIFFICULTIES:
        return recall_env(arena)
    settings = procedural_settings(arena, "test", 1, level)
    return BehavioursEnv(**{**settings, "arena": settings["arena"][0]})


def check_form(name: str, learner: Compared) -> None:
    """Fit a learner from vectors or queries to one training episode, before any work is done.

    Raises:
        ValueError: It is no classifier of state vectors.
        LearnerError: Its own code raises an error.
    """
    student = learner.learner if isinstance(learner, InteractiveImitation) else learner
    if not isinstance(student, OfflineImitation):
        return
    vectors, behaviours = arrays([train(TrainingEnv(), 0)[0]])
    groups = np.zeros(len(vectors), np.int64)
    try:
        with own_errors(f"learner {name}"):
            policy = student.learn(vectors, behaviours, groups=groups)
            policy.act(StateVector(*vectors[0].tolist()), np.random.default_rng(0))
    except LearnerError:
        raise
    except (ValueError, TypeError, AttributeError) as error:
        raise ValueError(f"learner {name}: {error}") from None


def all_learners() -> dict[str, Compared]:
    """The references, all learners of the registry, and those of installed packages, by name."""
    return {**BASELINES, **LEARNERS, **installed_learners().learners}


def unable(learner: Compared, arenas: Sequence[str] = ARENAS) -> str:
    """Why a learner cannot be compared here; empty if it can."""
    if not isinstance(learner, ReinforcementLearner):
        return ""
    if find_spec("stable_baselines3") is None:
        return "stable-baselines3 is not installed (pip install 'khepera-forage[baselines]')"
    if learner.wheels and any(arena in DIFFICULTIES for arena in arenas):
        return "it acts on wheels, and procedural arenas have environments of behaviours only"
    return ""


def fingerprint(learner: Compared) -> str:
    """What the rows of a learner depend on, in one line: its settings and, of a user's learner, the code's file."""
    student = learner.learner if isinstance(learner, InteractiveImitation) else learner
    make = getattr(student, "make", None)
    module = inspect.getmodule(getattr(make, "func", make))
    file = getattr(module, "__file__", None)
    if module is None or file is None or module.__name__.partition(".")[0] == __package__.partition(".")[0]:
        return settings_text(learner)  # the version of this package counts anyway
    return f"{settings_text(learner)} of {Path(file).name} ({crc32(Path(file).read_bytes()):08x})"


def settings_text(learner: Compared) -> str:
    """A learner's settings in one line, as they stand on the page."""
    match learner:
        case OfflineImitation():
            name = getattr(learner.make, "__name__", type(learner.make).__name__)
            diagonal = "; diagonal of the arena" if learner.diagonal else ""
            choice = "" if learner.sample else "; most probable behaviour"
            return f"{name}({_arguments(learner.settings)}){diagonal}{choice}"
        case InteractiveImitation():
            return f"{settings_text(learner.learner)}; {_arguments(learner.settings)}"
        case ReinforcementLearner():
            apart = ("title", "algorithm", "settings")
            own = {f.name: getattr(learner, f.name) for f in fields(learner) if f.name not in apart}
            return f"{learner.algorithm}({_arguments(learner.settings)}); {_arguments(own)}"
    return "learns nothing"


def _arguments(values: Mapping[str, Any]) -> str:
    return ", ".join(f"{name}={value!r}" for name, value in values.items())
