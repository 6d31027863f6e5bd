"""The jobs of a reproduction, for either backend, and replications of the thesis's design on pymunk (5.4)."""

from collections.abc import Callable, Sequence
from contextlib import closing
from dataclasses import dataclass
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
from khepera_forage.rollouts.training import IncompleteTrainingError, arrays, train
from khepera_forage.sim.arenas.thesis import CORRIDOR, THESIS_ARENAS
from khepera_forage.study import Job
from khepera_forage.task.decisions import DEFAULT_DECISIONS, Decisions, decisions_text
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


@dataclass(frozen=True, slots=True)
class UntrainedRow:
    """Replications without result, because no attempt at one of their training episodes was complete.

    Attributes:
        replication: Number of the first one.
        count: How many.
        noise: Name of the noise condition.
        reason: Says how many attempts there were.
        decisions: As in `RecallRow`.
    """

    replication: int
    count: int
    noise: str
    reason: str
    decisions: str = ""


Row = RecallRow | TrainingRow | OrientRow | UntrainedRow
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
    first: int,
    count: int,
    noise: str = LABORATORY,
    cells: Sequence[Cell] = THESIS,
    decisions: Decisions = DEFAULT_DECISIONS,
    laboratory: Noise = LABORATORY_NOISE,
) -> list[Row]:
    """Replications `first` to `first + count - 1`: each trains new files, and recalls with them.

    The noise condition is derived from the laboratory's noise. Under another one, a replication that cannot be trained
    leaves an `UntrainedRow`. Without any table of appendix A (`cells`) there are only ten training files.

    Raises:
        IncompleteTrainingError: No attempt at a training episode under the laboratory's noise was complete.
    """
    sources = noise_conditions(laboratory)[noise]
    rows: list[Row] = []
    for number in range(first, first + count):
        try:
            rows += _replication(seed, number, noise, sources, cells, decisions)
        except IncompleteTrainingError as error:
            rows.append(untrained(error, number, 1, noise, decisions))
    return rows


def untrained(error: IncompleteTrainingError, first: int, count: int, noise: str, decisions: Decisions) -> UntrainedRow:
    """The row of replications that cannot be trained; the laboratory's, which everything else needs, are an error."""
    if noise == LABORATORY:
        raise IncompleteTrainingError(f"{error}, with the noise {noise!r}") from None
    return UntrainedRow(first, count, noise, str(error), decisions_text(decisions))


def _replication(
    seed: int, number: int, noise: str, sources: Noise, cells: Sequence[Cell], decisions: Decisions
) -> list[Row]:
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


def baselines(
    seed: int,
    first: int,
    count: int,
    learner: str,
    arena: str,
    forages: int,
    decisions: Decisions = DEFAULT_DECISIONS,
    laboratory: Noise = LABORATORY_NOISE,
) -> list[Row]:
    """Blocks of forages of the teacher, or of a random policy; each block counts as a replication."""
    with closing(recall_env(arena, laboratory, baseline_limit(learner, arena), decisions=decisions)) as env:
        policy: Policy = Teacher.of(env) if learner == TEACHER else UniformPolicy()
        return [
            recall(env, policy, own, learner=learner, noise=LABORATORY, replication=block, number=i)
            for block in range(first, first + count)
            for i, own in enumerate(baseline_seeds(seed, block, learner, arena, forages).tolist())
        ]


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


def jobs(
    seed: int, counts: JobCounts, decisions: Decisions, backend: str, laboratory: Noise = LABORATORY_NOISE
) -> list[Job]:
    """All jobs of a reproduction, those that take longest first; other noise conditions are derived from `laboratory`.

    Raises:
        ImportError: The backend is "compiled", and numba is not installed.
    """
    if backend == PYMUNK:
        size, replicating, foraging = 1, replicate, baselines
    else:
        from khepera_forage.thesis import compiled_replications as compiled

        size, replicating, foraging = compiled.GROUP_SIZE, compiled.replicate, compiled.baselines
    made: list[Job] = []

    def add(name: str, function: Callable[..., list[Row]], first: int, end: int, *about: Any) -> None:
        for start in range(first, end, size):
            count = min(size, end - start)
            key = f"{name} {start} to {start + count - 1}"
            made.append(Job(key, function, (seed, start, count, *about, decisions, laboratory)))

    add(LABORATORY, replicating, 0, counts.replications, LABORATORY, THESIS)
    for noise in counts.noise_conditions:
        add(noise, replicating, 0, counts.noise_replications, noise, counts.noise_cells)
    # The claim on tracking losses (5.3.1) compares the same number of trainings with and without losses.
    if backend == PYMUNK and NO_LOSSES in counts.noise_conditions:
        add(NO_LOSSES, replicating, counts.noise_replications, counts.replications, NO_LOSSES, ())
    for arena in THESIS_ARENAS:
        for learner, forages in ((TEACHER, counts.block_forages), (RANDOM, counts.block_forages // 5)):
            add(f"{learner} {arena}", foraging, 0, counts.baseline_blocks, learner, arena, forages)
    return made
