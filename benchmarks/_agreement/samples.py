"""Recalls under the same conditions in pymunk, one by one, and in the batch, all at once."""

import sys
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from joblib import Parallel, delayed
from numpy.typing import NDArray
from tqdm import tqdm

from khepera_forage.envs.training import TrainingEnv
from khepera_forage.policies import NearestNeighbourImitator, Policy, Teacher
from khepera_forage.policies.nearest_neighbour.memories import memories_of
from khepera_forage.rollouts.recall import recall, recall_env
from khepera_forage.rollouts.training import arrays, train

TEACHER, IMITATOR = "teacher", "imitator"
FOODS, LIMITS = {"corridor": 1, "rectangle": 2}, {"corridor": 500, "rectangle": 700}
"""The thesis' own."""
SLOW = 0.98
"""Speed of the wheels in the planted difference."""
MEMORIES, TRAININGS = 20, 3
"""Imitators that take turns, the same ones in both simulators, and training episodes of each."""
BATCH_FACTOR = 10
"""Episodes of the batch for each of pymunk."""
BLOCK = 25
"""Recalls in one piece of work."""

Experience = tuple[NDArray[np.int64], NDArray[np.int64]]


class Condition(NamedTuple):
    """Who forages where.

    Attributes:
        policy: `teacher` or `imitator`.
        arena: `corridor` or `rectangle`.
    """

    policy: str
    arena: str


CONDITIONS = tuple(Condition(policy, arena) for arena in FOODS for policy in (TEACHER, IMITATOR))


@dataclass(frozen=True, slots=True)
class Recalled:
    """One recall in pymunk.

    Attributes:
        policy: Who foraged.
        arena: Where.
        memory: Number of the imitator, -1 for the teacher.
        seed: Of the episode.
        score: Equation 5.1, percent.
        steps: How many it took.
        delivered: Food brought home.
    """

    policy: str
    arena: str
    memory: int
    seed: int
    score: float
    steps: int
    delivered: int


class Sample(NamedTuple):
    """What is compared, one element a recall."""

    score: NDArray[np.float64]
    steps: NDArray[np.float64]
    delivered: NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Lesson:
    """The training of one imitator, in pymunk."""

    seed: int
    memory: int

    def run(self) -> Experience:
        """Train."""
        env = TrainingEnv()
        seeds = np.random.SeedSequence(self.seed, spawn_key=(0, self.memory)).spawn(TRAININGS)
        files = [train(env, seed)[0] for seed in seeds]
        env.close()
        return arrays(files)


@dataclass(frozen=True, slots=True)
class Block:
    """Some recalls under one condition, in pymunk.

    Attributes:
        condition: Which.
        seeds: One a recall.
        first: Number of the first of them; the imitators take turns.
        experiences: Of all imitators.
    """

    condition: Condition
    seeds: tuple[int, ...]
    first: int
    experiences: tuple[Experience, ...]

    def run(self) -> list[Recalled]:
        """Forage from each start, in the laboratory's noise."""
        policy, arena = self.condition
        env = recall_env(arena)
        who: dict[int, Policy] = {-1: Teacher(env.home_radius)}
        rows = []
        for number, seed in enumerate(self.seeds, self.first):
            memory = number % len(self.experiences) if policy == IMITATOR else -1
            if memory not in who:
                who[memory] = NearestNeighbourImitator(env.diagonal).fit(*self.experiences[memory])
            row = recall(env, who[memory], seed, learner=policy)
            rows.append(Recalled(policy, arena, memory, seed, row.score, row.steps, row.delivered))
        env.close()
        return rows


def experiences(seed: int, jobs: int) -> tuple[Experience, ...]:
    """What each imitator has learned."""
    return tuple(Parallel(n_jobs=jobs)(delayed(Lesson.run)(Lesson(seed, k)) for k in range(MEMORIES)))


def in_pymunk(seed: int, episodes: int, known: tuple[Experience, ...], jobs: int) -> list[Recalled]:
    """Recalls of every condition; the rows come in the same order on any number of processes."""
    work = []
    for number, condition in enumerate(CONDITIONS):
        seeds = np.random.SeedSequence(seed, spawn_key=(1, number)).generate_state(episodes).tolist()
        given = known if condition.policy == IMITATOR else ()
        work += [Block(condition, tuple(seeds[i : i + BLOCK]), i, given) for i in range(0, episodes, BLOCK)]
    running = Parallel(n_jobs=jobs, return_as="generator")(delayed(Block.run)(block) for block in work)
    progress = tqdm(running, total=len(work), desc="pymunk", unit="block", disable=not sys.stderr.isatty())
    return [row for rows in progress for row in rows]


def in_batch(
    seed: int, condition: Condition, episodes: int, known: tuple[Experience, ...], wheel_speed: float = 1.0
) -> Sample:
    """Recalls of one condition, with random numbers of their own."""
    from khepera_forage.rollouts.compiled import recalls as batch

    policy, arena = condition
    memories, which = None, np.full(episodes, batch.TEACHER)
    if policy == IMITATOR:
        memories, which = memories_of(known), np.arange(episodes) % len(known)
    key = (2, CONDITIONS.index(condition), int(wheel_speed != 1.0))
    played = batch.run_recalls(
        arena,
        memories,
        which,
        int(np.random.SeedSequence(seed, spawn_key=key).generate_state(1)[0]),
        foods=FOODS[arena],
        limit=LIMITS[arena],
        wheel_speed=wheel_speed,
    )
    return Sample(played.score, played.steps.astype(np.float64), played.delivered.astype(np.float64))


def sample_of(rows: Sequence[Recalled], condition: Condition) -> Sample:
    """The recalls of one condition."""
    own = [row for row in rows if (row.policy, row.arena) == condition]
    return Sample(*(np.array([getattr(row, name) for row in own], np.float64) for name in Sample._fields))
