"""The jobs of a reproduction, for either backend, and replications of the thesis's design on pymunk (5.4)."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from khepera_forage.envs.arguments import checked_arena
from khepera_forage.envs.backends import PYMUNK
from khepera_forage.envs.layouts import arena_map_of
from khepera_forage.envs.training import TrainingEnv
from khepera_forage.estimates import MIN_REPLICATIONS
from khepera_forage.experience import Experience
from khepera_forage.noise import Noise
from khepera_forage.policies import Policy, Teacher
from khepera_forage.policies.policy import UniformPolicy
from khepera_forage.rollouts.recall import recall, recall_env
from khepera_forage.rollouts.rows import RANDOM, TEACHER, RecallRow, TrainingRow
from khepera_forage.rollouts.training import arrays, train
from khepera_forage.sim.arenas.thesis import CORRIDOR, THESIS_ARENAS
from khepera_forage.study import Unit
from khepera_forage.task.decisions import DEFAULT_DECISIONS, Decisions
from khepera_forage.thesis.design import (
    LABORATORY,
    LABORATORY_NOISE,
    NO_LOSSES,
    NO_NOISE,
    THESIS,
    Cell,
    Subset,
    files_needed,
    noise_conditions,
)
from khepera_forage.thesis.orient_analysis import OrientRow, arrival_vectors, imitator_levels, orient_rows

if TYPE_CHECKING:
    from khepera_forage.policies import NearestNeighbourImitator

TEACHER_LIMIT_FACTOR = 3
"""The teacher forages with this many times the thesis's time limit, to measure whether that limit is enough."""


def replication_seeds(seed: int, number: int, noise: str) -> np.random.SeedSequence:
    """The seeds of training and recalls in one replication under a noise condition."""
    return np.random.SeedSequence(seed, spawn_key=(number, list(noise_conditions()).index(noise)))


def baseline_seeds(seed: int, block: int, learner: str, arena: str, forages: int) -> NDArray[np.int64]:
    """The seeds of the forages in one block of `Baseline`."""
    key = (block, 1000 + (learner == RANDOM), len(arena))
    return np.random.SeedSequence(seed, spawn_key=key).generate_state(forages).astype(np.int64)


def baseline_limit(learner: str, arena: str) -> int:
    """Time limit, in steps, of a forage of the teacher or a random policy."""
    limit = next(cell.limit for cell in THESIS if cell.arena == arena)
    return limit * TEACHER_LIMIT_FACTOR if learner == TEACHER else limit


Row = RecallRow | TrainingRow | OrientRow
"""A row of a job."""


@dataclass(frozen=True, slots=True)
class Replication:
    """Ten new training files, and the recalls of some cells with them.

    Attributes:
        seed: Of the whole reproduction.
        number: Of the replication.
        noise: Name of the noise condition.
        cells: The tables of appendix A to repeat; without any, only the training files.
        decisions: Of training and recall.
    """

    seed: int
    number: int
    noise: str = LABORATORY
    cells: tuple[Cell, ...] = THESIS
    decisions: Decisions = DEFAULT_DECISIONS

    @property
    def key(self) -> str:
        """Noise and number."""
        return f"{self.noise} {self.number}"

    def run(self) -> list[Row]:
        """Train, recall, and return the rows."""
        noise = noise_conditions()[self.noise]
        training, recalling = replication_seeds(self.seed, self.number, self.noise).spawn(2)
        files, trainings = self._train(noise, training)
        orient = self._orient_rows(files) if self.noise == LABORATORY else ()
        return [*self._recalls(noise, files, recalling), *trainings, *orient]

    def _train(
        self, noise: Noise, seeds: np.random.SeedSequence
    ) -> tuple[list[Experience], list[TrainingRow]]:
        env = TrainingEnv(noise=noise, decisions=self.decisions)
        files, rows = [], []
        for file, seed in enumerate(seeds.spawn(files_needed(self.cells)), 1):
            experience, attempts = train(env, seed, self.noise, self.number, file)
            files.append(experience)
            rows += attempts
        env.close()
        return files, rows

    def _recalls(
        self, noise: Noise, files: Sequence[Experience], seeds: np.random.SeedSequence
    ) -> Iterator[RecallRow]:
        for cell, cell_seeds in zip(self.cells, seeds.spawn(len(self.cells)), strict=True):
            env = recall_env(cell.arena, noise, decisions=self.decisions)
            numbers = iter(cell_seeds.generate_state(cell.size).tolist())
            for subset in cell.subsets:
                imitator, size = self._imitator(subset, files, env.diagonal)
                for i in range(cell.recalls):
                    yield recall(
                        env,
                        imitator,
                        next(numbers),
                        noise=self.noise,
                        replication=self.number,
                        episodes=cell.episodes,
                        file_id=subset.name,
                        number=i,
                        experience_size=size,
                    )
            env.close()

    def _orient_rows(self, files: Sequence[Experience]) -> Iterator[OrientRow]:
        for cell in self.cells:
            if cell.arena == CORRIDOR:
                for subset in cell.subsets:
                    imitator, _ = self._imitator(
                        subset, files, arena_map_of(checked_arena(CORRIDOR, self.decisions)).diagonal
                    )
                    levels = imitator_levels(imitator, arrival_vectors(self.decisions))
                    yield from orient_rows(levels, self.number, cell.episodes, subset.name, self.decisions)

    def _imitator(
        self, subset: Subset, files: Sequence[Experience], diagonal: int
    ) -> "tuple[NearestNeighbourImitator, int]":
        from khepera_forage.policies import NearestNeighbourImitator

        vectors, behaviours = arrays([files[f - 1] for f in subset.files])
        imitator = NearestNeighbourImitator(diagonal, arithmetic=self.decisions.distance_arithmetic)
        return imitator.fit(vectors, behaviours), len(behaviours)


@dataclass(frozen=True, slots=True)
class Baseline:
    """A block of forages of the teacher, or of a random policy, which counts as a replication."""

    seed: int
    number: int
    learner: str
    arena: str
    forages: int
    decisions: Decisions = DEFAULT_DECISIONS

    @property
    def key(self) -> str:
        """Policy, arena and number."""
        return f"{self.learner} {self.arena} {self.number}"

    def run(self) -> list[Row]:
        """Forage, and return the rows."""
        limit = baseline_limit(self.learner, self.arena)
        env = recall_env(self.arena, limit=limit, decisions=self.decisions)
        policy: Policy = Teacher.of(env) if self.learner == TEACHER else UniformPolicy()
        seeds = baseline_seeds(self.seed, self.number, self.learner, self.arena, self.forages)
        rows: list[Row] = [
            recall(env, policy, seed, learner=self.learner, replication=self.number, number=i)
            for i, seed in enumerate(seeds.tolist())
        ]
        env.close()
        return rows


NOISE_CELLS: tuple[Cell, ...] = tuple(cell for cell in THESIS if cell.episodes == 10)
"""Cells that are repeated under each noise condition: ten training episodes, recalls in both arenas."""


class JobCounts(NamedTuple):
    """How often each part of the experiments is repeated.

    Attributes:
        replications: Of the whole design under the laboratory's noise.
        noise_replications: Of `noise_cells` under each other noise condition.
        noise_conditions: Names of these conditions.
        baseline_blocks: Blocks of forages of the teacher, and of a random policy, in each arena; may be 0.
        block_forages: Forages of the teacher in a block; a random policy has a fifth of them.
        noise_cells: Cells under each other noise condition; without any, only the training files.
    """

    replications: int
    noise_replications: int
    noise_conditions: tuple[str, ...]
    baseline_blocks: int
    block_forages: int
    noise_cells: tuple[Cell, ...] = NOISE_CELLS


def job_counts(replications: int, backend: str, quick: bool = False) -> JobCounts:
    """The repetitions that belong to a number of replications of the whole design; a few of each with `quick`."""
    if quick:
        return JobCounts(replications, 1, (NO_NOISE,), 2, 5)
    conditions = tuple(name for name in noise_conditions() if name != LABORATORY)
    divisor = 3 if backend == PYMUNK else 10
    return JobCounts(replications, max(MIN_REPLICATIONS, replications // divisor), conditions, 20, 25)


def comparison_counts(replications: int) -> JobCounts:
    """The repetitions of the thesis's cells under other decisions: a fifth of those of the whole design."""
    return JobCounts(min(replications, max(MIN_REPLICATIONS, replications // 5)), 0, (), 0, 0)


def pymunk_jobs(seed: int, counts: JobCounts, decisions: Decisions) -> list[Unit]:
    """All jobs for pymunk, those that take longest first."""
    jobs: list[Unit] = [Replication(seed, i, decisions=decisions) for i in range(counts.replications)]
    for noise in counts.noise_conditions:
        jobs += [
            Replication(seed, i, noise, counts.noise_cells, decisions)
            for i in range(counts.noise_replications)
        ]
    # The claim on tracking losses (5.3.1) compares the same number of trainings with and without losses.
    if NO_LOSSES in counts.noise_conditions:
        jobs += [
            Replication(seed, i, NO_LOSSES, (), decisions)
            for i in range(counts.noise_replications, counts.replications)
        ]
    for arena, learner, forages in _baselines(counts):
        jobs += [Baseline(seed, i, learner, arena, forages, decisions) for i in range(counts.baseline_blocks)]
    return jobs


def compiled_jobs(
    seed: int, counts: JobCounts, decisions: Decisions, laboratory: Noise = LABORATORY_NOISE
) -> list[Unit]:
    """All jobs for the compiled backend; the other noise conditions are derived from the laboratory's noise.

    Raises:
        ImportError: numba is not installed.
    """
    from khepera_forage.thesis.compiled_replications import (
        GROUP_SIZE,
        CompiledBaseline,
        CompiledReplications,
    )

    def groups(count: int, noise: str, cells: tuple[Cell, ...]) -> list[Unit]:
        return [
            CompiledReplications(
                seed, first, min(GROUP_SIZE, count - first), noise, cells, decisions, laboratory
            )
            for first in range(0, count, GROUP_SIZE)
        ]

    jobs = groups(counts.replications, LABORATORY, THESIS)
    for noise in counts.noise_conditions:
        jobs += groups(counts.noise_replications, noise, counts.noise_cells)
    return jobs + [
        CompiledBaseline(seed, counts.baseline_blocks, learner, arena, forages, decisions, laboratory)
        for arena, learner, forages in _baselines(counts)
    ]


def _baselines(counts: JobCounts) -> Iterator[tuple[str, str, int]]:
    """Arena, policy and forages in a block of every baseline, if there are blocks."""
    for arena in THESIS_ARENAS if counts.baseline_blocks else ():
        yield arena, TEACHER, counts.block_forages
        yield arena, RANDOM, counts.block_forages // 5
