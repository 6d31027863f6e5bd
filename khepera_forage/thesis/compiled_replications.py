"""A hundred replications of the thesis's design at a time, simulated by the compiled kernels (5.4).

The design, files, subsets and rows are those of `replication`; only the backend differs. Needs numba (extra `fast`).
"""

from collections.abc import Iterator
from dataclasses import dataclass
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
from khepera_forage.rollouts.rows import IMITATOR, TEACHER, RecallRow, TrainingRow
from khepera_forage.sim.arenas.thesis import CORRIDOR
from khepera_forage.task.decisions import DEFAULT_DECISIONS, Decisions, decisions_text
from khepera_forage.thesis.design import (
    LABORATORY,
    LABORATORY_NOISE,
    THESIS,
    Cell,
    Subset,
    files_needed,
    noise_conditions,
)
from khepera_forage.thesis.orient_analysis import OrientRow, arrival_vectors, orient_rows
from khepera_forage.thesis.replication import Row, baseline_limit, baseline_seeds, replication_seeds

GROUP_SIZE = 100
"""Replications that run together: enough to use all lanes of the kernels."""


@dataclass(frozen=True, slots=True)
class CompiledReplications:
    """Replications `first` to `first + count - 1`, each with ten new training files and the recalls of some cells.

    Attributes:
        seed: Of the whole reproduction.
        first: A multiple of `GROUP_SIZE`, so that a replication does not depend on the total number.
        count: At most `GROUP_SIZE`.
        noise: Name of the noise condition, in training and recall.
        cells: The tables of appendix A to repeat; without any, only the training files.
        decisions: Of training and recall.
        laboratory: The laboratory's noise, from which the noise condition is derived.
    """

    seed: int
    first: int
    count: int
    noise: str = LABORATORY
    cells: tuple[Cell, ...] = THESIS
    decisions: Decisions = DEFAULT_DECISIONS
    laboratory: Noise = LABORATORY_NOISE

    @property
    def key(self) -> str:
        """Noise and numbers."""
        return f"{self.noise} {self.first} to {self.first + self.count - 1}"

    def run(self) -> list[Row]:
        """Train, recall, and return the rows."""
        noise = noise_conditions(self.laboratory)[self.noise]
        seeds = [replication_seeds(self.seed, number, self.noise).spawn(2) for number in self._numbers]
        first_training, _ = seeds[0]
        training_seed = int(first_training.generate_state(1)[0])
        trained = train_learners(
            self.count,
            seed=training_seed,
            noise=noise,
            episodes=files_needed(self.cells),
            decisions=self.decisions,
        )
        recalling = [parts.spawn(len(self.cells)) for _, parts in seeds]
        recalls: list[RecallRow] = []
        for i, cell in enumerate(self.cells):
            states = [cells[i].generate_state(cell.size) for cells in recalling]
            recalls += self._recalls(cell, noise, trained, np.concatenate(states).astype(np.int64))
        orient = self._orient_rows(trained) if self.noise == LABORATORY else ()
        return [*recalls, *self._trainings(trained), *orient]

    @property
    def _numbers(self) -> range:
        return range(self.first, self.first + self.count)

    def _trainings(self, trained: Trained) -> Iterator[TrainingRow]:
        attempts, decisions = trained.attempts, decisions_text(self.decisions)
        for learner, episode, attempt, complete, rounds, vectors, separations, reason in zip(
            *(column.tolist() for column in attempts), strict=True
        ):
            yield TrainingRow(
                replication=self.first + learner,
                file=episode + 1,
                attempt=attempt,
                seed=trained.seed,
                noise=self.noise,
                complete=complete,
                rounds=rounds,
                vectors=vectors,
                separations=separations,
                reason=reason,
                decisions=decisions,
            )

    def _recalls(
        self, cell: Cell, noise: Noise, trained: Trained, seeds: NDArray[np.int64]
    ) -> list[RecallRow]:
        played = recalls_of(cell, trained, self.count, seeds, noise, self.decisions)
        sizes = [len(y) for _, y in _experience_of_cell(cell, trained, self.count)]
        own = {
            "replication": np.repeat(self._numbers, cell.size).tolist(),
            "file_id": [s.name for s in cell.subsets for _ in range(cell.recalls)] * self.count,
            "recall": list(range(cell.recalls)) * len(sizes),
            "seed": seeds.tolist(),
            "experience_size": np.repeat(sizes, cell.recalls).tolist(),
        }
        return recall_rows(
            played,
            checked_arena(cell.arena, self.decisions),
            own,
            self.decisions,
            episodes=cell.episodes,
            learner=IMITATOR,
            noise=self.noise,
            limit=cell.limit,
        )

    def _orient_rows(self, trained: Trained) -> Iterator[OrientRow]:
        for cell in self.cells:
            if cell.arena == CORRIDOR:
                imitators = [(i, subset) for i in range(self.count) for subset in cell.subsets]
                memories = memories_of([_experience(trained, i, subset) for i, subset in imitators])
                diagonal = arena_map_of(checked_arena(CORRIDOR, self.decisions)).diagonal
                vectors: Any = arrival_vectors(self.decisions)
                arithmetic: Any = self.decisions.values().distance_arithmetic
                all_levels = confidence_levels(memories, vectors, diagonal, arithmetic)
                for (i, subset), levels in zip(imitators, all_levels, strict=True):
                    yield from orient_rows(levels, self.first + i, cell.episodes, subset.name, self.decisions)


@dataclass(frozen=True, slots=True)
class CompiledBaseline:
    """Blocks of forages of the teacher, or of a random policy; each block counts as a replication."""

    seed: int
    blocks: int
    learner: str
    arena: str
    forages: int
    decisions: Decisions = DEFAULT_DECISIONS
    laboratory: Noise = LABORATORY_NOISE

    @property
    def key(self) -> str:
        """Policy, arena and number of forages."""
        return f"{self.learner} {self.arena} {self.blocks} times {self.forages}"

    def run(self) -> list[Row]:
        """Forage, and return the rows."""
        arena = checked_arena(self.arena, self.decisions)
        limit = baseline_limit(self.learner, self.arena)
        seeds = np.concatenate(
            [
                baseline_seeds(self.seed, block, self.learner, self.arena, self.forages)
                for block in range(self.blocks)
            ]
        )
        policy = TEACHES if self.learner == TEACHER else UNIFORM
        foods = next(cell.foods for cell in THESIS if cell.arena == self.arena)
        policies = np.full(len(seeds), policy)
        played = run_recalls(
            arena,
            None,
            policies,
            seeds,
            foods=foods,
            limit=limit,
            noise=self.laboratory,
            decisions=self.decisions,
        )
        own = {
            "replication": np.repeat(range(self.blocks), self.forages).tolist(),
            "recall": list(range(self.forages)) * self.blocks,
            "seed": seeds.tolist(),
        }
        return list(
            recall_rows(
                played,
                arena,
                own,
                self.decisions,
                episodes=0,
                file_id="-",
                learner=self.learner,
                noise=LABORATORY,
                limit=limit,
                experience_size=0,
            )
        )


def _experience(
    trained: Trained, learner: int, subset: Subset
) -> tuple[NDArray[np.int16], NDArray[np.int16]]:
    """State vectors and behaviours of the training files that a learner uses together."""
    rows = np.concatenate([trained.vectors_of(learner, file - 1) for file in subset.files])
    return rows[:, :5], rows[:, 5]


def recalls_of(
    cell: Cell, trained: Trained, count: int, seeds: NDArray[np.int64], noise: Noise, decisions: Decisions
) -> Episodes:
    """The recalls of one cell in some replications, each with a trained learner: by set of files and recall."""
    experience = _experience_of_cell(cell, trained, count)
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


def _experience_of_cell(
    cell: Cell, trained: Trained, count: int
) -> list[tuple[NDArray[np.int16], NDArray[np.int16]]]:
    return [_experience(trained, i, subset) for i in range(count) for subset in cell.subsets]
