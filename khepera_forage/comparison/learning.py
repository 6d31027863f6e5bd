"""How each kind of learner learns, in growing amounts; all of them learn in the corridor alone."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from time import perf_counter
from typing import Any, ClassVar, NamedTuple

import numpy as np
from numpy.typing import NDArray

from khepera_forage.envs.arguments import checked_arena
from khepera_forage.envs.forager import arena_map_of
from khepera_forage.envs.training import TrainingEnv
from khepera_forage.policies import Policy, Teacher
from khepera_forage.policies.learners import FromQueries, FromSteps, FromVectors, Learner
from khepera_forage.policies.uniform import UniformPolicy
from khepera_forage.rollouts.dagger import dagger
from khepera_forage.rollouts.recall import recall_env
from khepera_forage.rollouts.reinforcement import reinforce
from khepera_forage.rollouts.training import arrays, train
from khepera_forage.sim.arenas.thesis import THESIS_ARENAS
from khepera_forage.task.decisions import DEFAULT_DECISIONS

ARENA_MAPS = {name: arena_map_of(checked_arena(name, DEFAULT_DECISIONS)) for name in THESIS_ARENAS}
"""What is given of each arena from the beginning."""


@dataclass(frozen=True, slots=True)
class Reference:
    """A policy that learns nothing, for comparison.

    Attributes:
        title: For tables and figures.
        expert: Whether it is the teacher; if not, behaviours are drawn uniformly.
    """

    title: str
    expert: bool
    needs: ClassVar[None] = None


REFERENCES = {"teacher": Reference("the teacher", True), "random": Reference("random behaviours", False)}
"""By name: the upper limit for imitation, and the chance level."""
Compared = Learner | Reference


class Learned(NamedTuple):
    """A learner after some amount of learning.

    Attributes:
        steps: Environment steps of the learning.
        vectors: That it learned from.
        seconds: Wall time so far.
        policies: By the name of the arena they are for.
    """

    steps: int
    vectors: int
    seconds: float
    policies: Mapping[str, Any]


def learn(learner: Compared, amounts: Sequence[int], seeds: np.random.SeedSequence) -> Iterator[Learned]:
    """The learner after each amount of learning.

    Args:
        learner: An entry of `LEARNERS`, or one of `REFERENCES`.
        amounts: Training episodes, queries or steps, in increasing order.
        seeds: Of one replication; all imitators of a replication have the same training episodes.
    """
    seed = int(seeds.generate_state(1)[0]) % 2**31
    match learner:
        case FromVectors():
            yield from _imitate(learner, amounts, seeds.spawn(amounts[-1]), seed)
        case FromQueries():
            yield from _query(learner, amounts, seed)
        case FromSteps():
            for policy, steps, seconds in reinforce(learner, amounts, seed):
                yield Learned(steps, 0, seconds, dict.fromkeys(ARENA_MAPS, policy))
        case Reference():
            policies = {
                arena: Teacher(arena_map.home_radius) if learner.expert else UniformPolicy()
                for arena, arena_map in ARENA_MAPS.items()
            }
            yield Learned(0, 0, 0.0, policies)


def _imitate(
    learner: FromVectors, amounts: Sequence[int], seeds: Sequence[np.random.SeedSequence], seed: int
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
            policies, fitting = _policies(learner, vectors, behaviours, seed, groups)
            yield Learned(steps, len(vectors), seconds + fitting, policies)
    env.close()


def _query(learner: FromQueries, amounts: Sequence[int], seed: int) -> Iterator[Learned]:
    """Every amount is learned from the start with the same seed, so that its time is complete."""
    student = learner.learner
    env = recall_env("corridor")
    for amount in amounts:
        began = perf_counter()
        asked = dagger(
            lambda: student.classifier(env.diagonal, seed),
            env,
            amount,
            seed,
            sample=student.sample,
            **learner.settings,
        )
        seconds = perf_counter() - began
        policies, _ = _policies(student, asked.vectors, asked.behaviours, seed, None)
        yield Learned(amount, amount, seconds, policies)
    env.close()


def _policies(
    learner: FromVectors,
    vectors: NDArray[np.int64],
    behaviours: NDArray[np.int64],
    seed: int,
    groups: NDArray[np.int64] | None,
) -> tuple[dict[str, Policy], float]:
    """A policy for each arena, the same one if the learner takes no diagonal; and the seconds of one fit."""
    began = perf_counter()
    first = learner.learn(vectors, behaviours, ARENA_MAPS["corridor"].diagonal, seed, groups)
    seconds = perf_counter() - began
    if not learner.diagonal:
        return dict.fromkeys(ARENA_MAPS, first), seconds
    second = learner.learn(vectors, behaviours, ARENA_MAPS["rectangle"].diagonal, seed, groups)
    return {"corridor": first, "rectangle": second}, seconds
