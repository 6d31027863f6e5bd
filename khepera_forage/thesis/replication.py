"""The jobs of a reproduction, for either backend, and replications of the thesis's design on pymunk (5.4)."""

from collections.abc import Sequence
from contextlib import closing
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from khepera_forage.envs.backends import PYMUNK
from khepera_forage.envs.training import TrainingEnv
from khepera_forage.estimates import MIN_REPLICATIONS
from khepera_forage.experience import Experience
from khepera_forage.noise import Noise
from khepera_forage.policies import NearestNeighbourImitator, Policy, Teacher
from khepera_forage.policies.policy import UniformPolicy
from khepera_forage.rollouts.recall import recall, recall_env
from khepera_forage.rollouts.rows import RANDOM, TEACHER, RecallRow, TrainingRow
from khepera_forage.rollouts.training import arrays, train
from khepera_forage.sim.arenas.thesis import CORRIDOR, THESIS_ARENAS
from khepera_forage.study import Job
from khepera_forage.task.decisions import DEFAULT_DECISIONS, Decisions
from khepera_forage.thesis.design import (
    LABORATORY,
    LABORATORY_NOISE,
    LIMITS,
    NO_LOSSES,
    NO_NOISE,
    THESIS,
    Cell,
    files_needed,
    noise_conditions,
)
from khepera_forage.thesis.orient_analysis import OrientRow, arrival_vectors, imitator_levels, orient_rows

Row = RecallRow | TrainingRow | OrientRow
"""A row of a job."""
TEACHER_LIMIT_FACTOR = 3
"""The teacher forages with this many times the thesis's time limit, to measure whether that limit is enough."""
NOISE_CELLS: tuple[Cell, ...] = tuple(cell for cell in THESIS if cell.episodes == 10)
"""Cells that are repeated under each noise condition: ten training episodes, recalls in both arenas."""


def replication_seeds(seed: int, number: int, noise: str) -> np.random.SeedSequence:
    """The seeds of training and recalls in one replication under a noise condition."""
    return np.random.SeedSequence(seed, spawn_key=(number, list(noise_conditions()).index(noise)))


def baseline_seeds(seed: int, block: int, learner: str, arena: str, forages: int) -> NDArray[np.int64]:
    """The seeds of the forages in one block of a baseline."""
    key = (block, 1000 + (learner == RANDOM), len(arena))
    return np.random.SeedSequence(seed, spawn_key=key).generate_state(forages).astype(np.int64)


def baseline_limit(learner: str, arena: str) -> int:
    """Time limit, in steps, of a forage of the teacher or a random policy."""
    return LIMITS[arena] * (TEACHER_LIMIT_FACTOR if learner == TEACHER else 1)


def replicate(
    seed: int,
    number: int,
    noise: str = LABORATORY,
    cells: Sequence[Cell] = THESIS,
    decisions: Decisions = DEFAULT_DECISIONS,
) -> list[Row]:
    """Train new files, and recall with them; without cells only ten training files.

    The seed is that of the whole reproduction.
    """
    sources = noise_conditions()[noise]
    training, recalling = replication_seeds(seed, number, noise).spawn(2)
    files: list[Experience] = []
    trainings: list[Row] = []
    with closing(TrainingEnv(noise=sources, decisions=decisions)) as env:
        for file, own in enumerate(training.spawn(files_needed(cells)), 1):
            experience, attempts = train(env, own, noise, number, file)
            files.append(experience)
            trainings += attempts
    recalls: list[Row] = []
    orient: list[Row] = []
    for cell, own in zip(cells, recalling.spawn(len(cells)), strict=True):
        numbers = iter(own.generate_state(cell.size).tolist())
        with closing(recall_env(cell.arena, sources, decisions=decisions)) as alone:
            for subset in cell.subsets:
                vectors, behaviours = arrays([files[f - 1] for f in subset.files])
                imitator = NearestNeighbourImitator(alone.diagonal, arithmetic=decisions.distance_arithmetic).fit(
                    vectors, behaviours
                )
                about: dict[str, Any] = {"noise": noise, "replication": number, "episodes": cell.episodes}
                about |= {"file_id": subset.name, "experience_size": len(behaviours)}
                recalls += [recall(alone, imitator, next(numbers), number=i, **about) for i in range(cell.recalls)]
                if noise == LABORATORY and cell.arena == CORRIDOR:
                    levels = imitator_levels(imitator, arrival_vectors(decisions))
                    orient += orient_rows(levels, number, cell.episodes, subset.name, decisions)
    return [*recalls, *trainings, *orient]


def baseline(
    seed: int, block: int, learner: str, arena: str, forages: int, decisions: Decisions = DEFAULT_DECISIONS
) -> list[Row]:
    """A block of forages of the teacher, or of a random policy, which counts as a replication."""
    with closing(recall_env(arena, limit=baseline_limit(learner, arena), decisions=decisions)) as env:
        policy: Policy = Teacher.of(env) if learner == TEACHER else UniformPolicy()
        seeds = baseline_seeds(seed, block, learner, arena, forages).tolist()
        return [recall(env, policy, own, learner=learner, replication=block, number=i) for i, own in enumerate(seeds)]


class JobCounts(NamedTuple):
    """How often each part of the experiments is repeated.

    Attributes:
        replications: Of the whole design under the laboratory's noise.
        noise_replications: Of `noise_cells` under each other noise condition; without cells, of the training files.
        baseline_blocks: Blocks of forages of the teacher, and of a random policy, in each arena.
        block_forages: Forages of the teacher in a block; a random policy has a fifth of them.
    """

    replications: int
    noise_replications: int = 0
    noise_conditions: tuple[str, ...] = ()
    baseline_blocks: int = 0
    block_forages: int = 0
    noise_cells: tuple[Cell, ...] = NOISE_CELLS

    @property
    def baselines(self) -> list[tuple[str, str, int]]:
        """Policy, arena and forages in a block of every baseline, if there are blocks."""
        forages = {TEACHER: self.block_forages, RANDOM: self.block_forages // 5}
        if not self.baseline_blocks:
            return []
        return [(learner, arena, count) for arena in THESIS_ARENAS for learner, count in forages.items()]


def job_counts(replications: int, backend: str, quick: bool = False) -> JobCounts:
    """The repetitions that belong to a number of replications of the whole design; a few of each with `quick`."""
    if quick:
        return JobCounts(replications, 1, (NO_NOISE,), 2, 5)
    conditions = tuple(name for name in noise_conditions() if name != LABORATORY)
    divisor = 3 if backend == PYMUNK else 10
    return JobCounts(replications, max(MIN_REPLICATIONS, replications // divisor), conditions, 20, 25)


def comparison_counts(replications: int) -> JobCounts:
    """The repetitions of the thesis's cells under other decisions: a fifth of those of the whole design."""
    return JobCounts(min(replications, max(MIN_REPLICATIONS, replications // 5)))


def pymunk_jobs(seed: int, counts: JobCounts, decisions: Decisions) -> list[Job]:
    """All jobs for pymunk, those that take longest first."""

    def several(numbers: range, noise: str, cells: tuple[Cell, ...]) -> list[Job]:
        return [Job(f"{noise} {i}", replicate, (seed, i, noise, cells, decisions)) for i in numbers]

    jobs = several(range(counts.replications), LABORATORY, THESIS)
    for noise in counts.noise_conditions:
        jobs += several(range(counts.noise_replications), noise, counts.noise_cells)
    # The claim on tracking losses (5.3.1) compares the same number of trainings with and without losses.
    if NO_LOSSES in counts.noise_conditions:
        jobs += several(range(counts.noise_replications, counts.replications), NO_LOSSES, ())
    return jobs + [
        Job(f"{learner} {arena} {i}", baseline, (seed, i, learner, arena, forages, decisions))
        for learner, arena, forages in counts.baselines
        for i in range(counts.baseline_blocks)
    ]


def compiled_jobs(
    seed: int, counts: JobCounts, decisions: Decisions, laboratory: Noise = LABORATORY_NOISE
) -> list[Job]:
    """All jobs for the compiled backend; the other noise conditions are derived from the laboratory's noise.

    Raises:
        ImportError: numba is not installed.
    """
    from khepera_forage.thesis.compiled_replications import GROUP_SIZE, baselines, replicate_together

    def groups(count: int, noise: str, cells: tuple[Cell, ...]) -> list[Job]:
        jobs = []
        for first in range(0, count, GROUP_SIZE):
            own = min(GROUP_SIZE, count - first)
            arguments = seed, first, own, noise, cells, decisions, laboratory
            jobs.append(Job(f"{noise} {first} to {first + own - 1}", replicate_together, arguments))
        return jobs

    jobs = groups(counts.replications, LABORATORY, THESIS)
    for noise in counts.noise_conditions:
        jobs += groups(counts.noise_replications, noise, counts.noise_cells)
    blocks = counts.baseline_blocks
    return jobs + [
        Job(
            f"{learner} {arena} {blocks} times {forages}",
            baselines,
            (seed, blocks, learner, arena, forages, decisions, laboratory),
        )
        for learner, arena, forages in counts.baselines
    ]
