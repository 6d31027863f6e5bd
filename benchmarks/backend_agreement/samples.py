"""Recalls under the same conditions on both backends: one by one with pymunk, all at once compiled."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from joblib import Parallel, delayed
from numpy.typing import NDArray

from khepera_forage.envs.training import TrainingEnv
from khepera_forage.policies import NearestNeighbourImitator, Policy, Teacher
from khepera_forage.policies.nearest_neighbour.memories import memories_of
from khepera_forage.rollouts.recall import recall, recall_env
from khepera_forage.rollouts.training import arrays, train

TEACHER, IMITATOR = "teacher", "imitator"
FOODS, LIMITS = {"corridor": 1, "rectangle": 2}, {"corridor": 500, "rectangle": 700}
"""As in the thesis."""
SLOW = 0.98
"""Speed of the wheels in the artificial difference."""
IMITATORS, QUICK_IMITATORS, TRAININGS = 20, 5, 3
"""Imitators that take turns, the same on both backends; their number with `--quick`; training episodes of each."""
COMPILED_FACTOR = 10
"""Compiled recalls for each recall with pymunk."""
BLOCK = 25
"""Recalls of one unit of work."""

Vectors = tuple[NDArray[np.int64], NDArray[np.int64]]
"""State vectors and behaviours."""


class Condition(NamedTuple):
    """A policy in an arena.

    Attributes:
        policy: `teacher` or `imitator`.
        arena: `corridor` or `rectangle`.
    """

    policy: str
    arena: str


CONDITIONS = tuple(Condition(policy, arena) for arena in FOODS for policy in (TEACHER, IMITATOR))


@dataclass(frozen=True, slots=True)
class PymunkRecall:
    """One recall with pymunk.

    Attributes:
        policy: `teacher` or `imitator`.
        arena: `corridor` or `rectangle`.
        imitator: Number of the imitator, -1 for the teacher.
        seed: Of the episode.
        score: Equation 5.1, percent.
        steps: How many it took.
        delivered: Food brought home.
    """

    policy: str
    arena: str
    imitator: int
    seed: int
    score: float
    steps: int
    delivered: int


class Sample(NamedTuple):
    """The compared quantities, one element a recall."""

    score: NDArray[np.float64]
    steps: NDArray[np.float64]
    delivered: NDArray[np.float64]


class Block(NamedTuple):
    """Some recalls under one condition with pymunk.

    Attributes:
        condition: Which.
        seeds: One a recall.
        first: Number of the first recall; the imitators take turns.
        experience: Of each imitator; empty for the teacher.
    """

    condition: Condition
    seeds: tuple[int, ...]
    first: int
    experience: tuple[Vectors, ...]

    @property
    def key(self) -> str:
        """Condition and numbers of the recalls."""
        return f"{' '.join(self.condition)} {self.first}-{self.first + len(self.seeds)}"

    def run(self) -> list[PymunkRecall]:
        """Recall from each start, in the laboratory's noise."""
        policy, arena = self.condition
        env = recall_env(arena)
        policies: dict[int, Policy] = {-1: Teacher.of(env)}
        rows = []
        for number, seed in enumerate(self.seeds, self.first):
            imitator = number % len(self.experience) if policy == IMITATOR else -1
            if imitator not in policies:
                policies[imitator] = NearestNeighbourImitator(env.diagonal).fit(*self.experience[imitator])
            row = recall(env, policies[imitator], seed, learner=policy)
            rows.append(PymunkRecall(policy, arena, imitator, seed, row.score, row.steps, row.delivered))
        env.close()
        return rows


def experience(seed: int, jobs: int, quick: bool) -> tuple[Vectors, ...]:
    """The experience of each imitator, from training with pymunk."""
    numbers = range(QUICK_IMITATORS if quick else IMITATORS)
    return tuple(Parallel(n_jobs=jobs)(delayed(_train)(seed, number) for number in numbers))


def _train(seed: int, imitator: int) -> Vectors:
    env = TrainingEnv()
    seeds = np.random.SeedSequence(seed, spawn_key=(0, imitator)).spawn(TRAININGS)
    files = [train(env, file_seed)[0] for file_seed in seeds]
    env.close()
    return arrays(files)


def blocks(seed: int, episodes: int, imitators: tuple[Vectors, ...]) -> list[Block]:
    """All recalls with pymunk."""
    work = []
    for number, condition in enumerate(CONDITIONS):
        seeds = np.random.SeedSequence(seed, spawn_key=(1, number)).generate_state(episodes).tolist()
        own = imitators if condition.policy == IMITATOR else ()
        work += [Block(condition, tuple(seeds[i : i + BLOCK]), i, own) for i in range(0, episodes, BLOCK)]
    return work


def compiled(
    seed: int,
    condition: Condition,
    episodes: int,
    imitators: tuple[Vectors, ...],
    wheel_speed: float = 1.0,
) -> Sample:
    """Compiled recalls of one condition, with random numbers of their own."""
    from khepera_forage.rollouts.compiled import recalls

    policy, arena = condition
    memories, which = None, np.full(episodes, recalls.TEACHER)
    if policy == IMITATOR:
        memories, which = memories_of(imitators), np.arange(episodes) % len(imitators)
    key = (2, CONDITIONS.index(condition), int(wheel_speed != 1.0))
    done = recalls.run_recalls(
        arena,
        memories,
        which,
        int(np.random.SeedSequence(seed, spawn_key=key).generate_state(1)[0]),
        foods=FOODS[arena],
        limit=LIMITS[arena],
        wheel_speed=wheel_speed,
    )
    return Sample(done.score, done.steps.astype(np.float64), done.delivered.astype(np.float64))


def sample_of(rows: Sequence[PymunkRecall]) -> Sample:
    """The compared quantities of some recalls."""
    return Sample(*(np.array([getattr(row, name) for row in rows], np.float64) for name in Sample._fields))
