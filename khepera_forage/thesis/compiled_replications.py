"""A hundred replications of the thesis's design at a time, simulated by the compiled kernels (5.4).

The design, files, subsets and rows are those of `replication`; only the backend differs. Needs numba (extra `fast`).
"""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from khepera_forage.envs.arguments import checked_arena
from khepera_forage.envs.layouts import arena_map_of
from khepera_forage.noise import Noise
from khepera_forage.policies.memories import memories_of
from khepera_forage.rollouts.compiled.imitators import confidence_levels
from khepera_forage.rollouts.compiled.recalls import TEACHER as TEACHES
from khepera_forage.rollouts.compiled.recalls import UNIFORM, Episodes, recall_rows, run_recalls
from khepera_forage.rollouts.compiled.training import Trained, train_learners
from khepera_forage.rollouts.rows import IMITATOR, TEACHER, TrainingRow
from khepera_forage.rollouts.training import IncompleteTrainingError
from khepera_forage.sim.arenas.thesis import CORRIDOR
from khepera_forage.task.decisions import DEFAULT_DECISIONS, Decisions, decisions_text
from khepera_forage.thesis.design import (
    FOODS,
    LABORATORY,
    LABORATORY_NOISE,
    THESIS,
    Cell,
    files_needed,
    noise_conditions,
)
from khepera_forage.thesis.orient_analysis import arrival_vectors, orient_rows
from khepera_forage.thesis.replication import Row, baseline_limit, baseline_seeds, replication_seeds, untrained

Learned = Sequence[tuple[NDArray[np.int16], NDArray[np.int16]]]
"""State vectors and behaviours that imitators have learned."""
GROUP_SIZE = 100
"""Replications that run together: enough to use all lanes of the kernels."""


def replicate(
    seed: int,
    first: int,
    count: int,
    noise: str = LABORATORY,
    cells: Sequence[Cell] = THESIS,
    decisions: Decisions = DEFAULT_DECISIONS,
    laboratory: Noise = LABORATORY_NOISE,
) -> list[Row]:
    """Replications `first` to `first + count - 1`; arguments as for `replication.replicate`.

    `first` is a multiple of `GROUP_SIZE`, and `count` at most that, so that a replication does not depend on the total
    number. A replication that cannot be trained leaves all of the call without result.
    """
    sources = noise_conditions(laboratory)[noise]
    seeds = [replication_seeds(seed, number, noise).spawn(2) for number in range(first, first + count)]
    key, files = int(seeds[0][0].generate_state(1)[0]), files_needed(cells)
    try:
        trained = train_learners(count, seed=key, noise=sources, episodes=files, decisions=decisions)
    except IncompleteTrainingError as error:
        return [untrained(error, first, count, noise, decisions)]
    recalling = [parts.spawn(len(cells)) for _, parts in seeds]
    recalls: list[Row] = []
    orient: list[Row] = []
    for i, cell in enumerate(cells):
        states = np.concatenate([own[i].generate_state(cell.size) for own in recalling]).astype(np.int64)
        experience = experience_of(cell, trained, count)
        sizes = [len(heard) for _, heard in experience]
        about = {
            "replication": np.repeat(range(first, first + count), cell.size).tolist(),
            "file_id": [s.name for s in cell.subsets for _ in range(cell.recalls)] * count,
            "recall": list(range(cell.recalls)) * len(sizes),
            "seed": states.tolist(),
            "experience_size": np.repeat(sizes, cell.recalls).tolist(),
        }
        played = recalls_of(cell, experience, states, sources, decisions)
        common = {"learner": IMITATOR, "episodes": cell.episodes, "noise": noise, "limit": cell.limit}
        recalls += recall_rows(played, checked_arena(cell.arena, decisions), about, decisions, **common)

        if noise == LABORATORY and cell.arena == CORRIDOR:
            diagonal = arena_map_of(checked_arena(CORRIDOR, decisions)).diagonal
            vectors: Any = arrival_vectors(decisions)
            arithmetic: Any = decisions.values().distance_arithmetic
            levels = iter(confidence_levels(memories_of(experience), vectors, diagonal, arithmetic))
            for number in range(first, first + count):
                for subset in cell.subsets:
                    orient += orient_rows(next(levels), number, cell.episodes, subset.name, decisions)
    text = decisions_text(decisions)
    attempts = zip(*(column.tolist() for column in trained.attempts), strict=True)
    trainings: list[Row] = [
        TrainingRow(first + learner, file + 1, attempt, trained.seed + learner, noise, *(*values, text))
        for learner, file, attempt, *values in attempts
    ]
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
    """Blocks of forages as by `replication.baselines`."""
    place, limit, blocks = checked_arena(arena, decisions), baseline_limit(learner, arena), range(first, first + count)
    seeds = np.concatenate([baseline_seeds(seed, i, learner, arena, forages) for i in blocks])
    played = run_recalls(
        place,
        None,
        np.full(len(seeds), TEACHES if learner == TEACHER else UNIFORM),
        seeds,
        foods=FOODS[arena],
        limit=limit,
        noise=laboratory,
        decisions=decisions,
    )
    own = {
        "replication": np.repeat(blocks, forages).tolist(),
        "recall": list(range(forages)) * count,
        "seed": seeds.tolist(),
    }
    about = {"learner": learner, "episodes": 0, "file_id": "-", "experience_size": 0}
    return [*recall_rows(played, place, own, decisions, noise=LABORATORY, limit=limit, **about)]


def recalls_of(
    cell: Cell, experience: Learned, seeds: NDArray[np.int64], noise: Noise, decisions: Decisions
) -> Episodes:
    """The recalls of one cell in some replications: by learner, set of files, and recall."""
    return run_recalls(
        checked_arena(cell.arena, decisions),
        memories_of(experience),
        np.repeat(np.arange(len(experience)), cell.recalls),
        seeds,
        foods=cell.foods,
        limit=cell.limit,
        noise=noise,
        decisions=decisions,
    )


def experience_of(cell: Cell, trained: Trained, count: int) -> Learned:
    """The experience of every learner and set of files."""
    together = [
        np.concatenate([trained.vectors_of(learner, file - 1) for file in subset.files])
        for learner in range(count)
        for subset in cell.subsets
    ]
    return [(rows[:, :5], rows[:, 5]) for rows in together]
