"""The jobs of a reproduction: independent parts of the experiments, for either backend."""

from collections.abc import Iterator
from typing import NamedTuple

from khepera_forage.envs.backends import PYMUNK
from khepera_forage.estimates import MIN_REPLICATIONS
from khepera_forage.noise import Noise
from khepera_forage.rollouts.rows import RANDOM, TEACHER
from khepera_forage.sim.arenas.thesis import THESIS_ARENAS
from khepera_forage.study import Unit
from khepera_forage.task.decisions import Decisions
from khepera_forage.thesis.design import (
    LABORATORY,
    LABORATORY_NOISE,
    NO_LOSSES,
    NO_NOISE,
    THESIS,
    Cell,
    noise_conditions,
)
from khepera_forage.thesis.replication import Baseline, Replication

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
    """The repetitions that belong to a number of replications.

    Args:
        replications: Of the whole design; each other noise condition has a share of them, and at least as many as an
            interval needs.
        backend: `pymunk` or `compiled`.
        quick: Run every part of the experiments, but only a few times.
    """
    if quick:
        return JobCounts(replications, 1, (NO_NOISE,), 2, 5)
    conditions = tuple(name for name in noise_conditions() if name != LABORATORY)
    divisor = 3 if backend == PYMUNK else 10
    return JobCounts(replications, max(MIN_REPLICATIONS, replications // divisor), conditions, 20, 25)


def comparison_counts(replications: int) -> JobCounts:
    """The repetitions of the thesis's cells under other decisions, to compare them with those of the whole design.

    Args:
        replications: Of the whole design. The comparison has a fifth of them, at least as many as an interval needs,
            and never more than the design itself.
    """
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
    """All jobs for the compiled backend.

    Args:
        seed: Of the whole reproduction.
        counts: How often each part is repeated.
        decisions: Of all experiments.
        laboratory: The laboratory's noise, from which the other noise conditions are derived.

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
