"""The thesis' design in a hundred replications at a time: training and recalls wholly in compiled kernels (5.4).

The same design, files, subsets and rows as `replication`; what differs is where the worlds are simulated. Needs numba
(extra `fast`).
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from khepera_forage.envs.arguments import the_arena
from khepera_forage.envs.forager import site_of
from khepera_forage.noise import Noise
from khepera_forage.policies.ballot_box import memories_of
from khepera_forage.rollouts.compiled.confidence import confidence_levels
from khepera_forage.rollouts.compiled.recall_rows import recall_rows
from khepera_forage.rollouts.compiled.recalls import TEACHER as TEACHES
from khepera_forage.rollouts.compiled.recalls import UNIFORM, run_recalls
from khepera_forage.rollouts.compiled.training import train_learners
from khepera_forage.rollouts.compiled.training_results import Trained
from khepera_forage.rollouts.rows import IMITATOR, TEACHER, RecallRow, TrainingRow
from khepera_forage.sim.arena import CORRIDOR
from khepera_forage.thesis.design import FILES, LABORATORY, THESIS, Cell, Subset, noise_conditions
from khepera_forage.thesis.orient_analysis import VoteRow, arrivals, votes
from khepera_forage.thesis.replication import (
    TRAINING_DISTANCE,
    Outcome,
    baseline_limit,
    baseline_seeds,
    replication_seeds,
)

SIZE = 100
"""Replications that run together: enough to keep all worlds busy."""


@dataclass(frozen=True, slots=True)
class ReplicationBatch:
    """Replications `first` to `first + count - 1`, each with ten new training files and the recalls of some cells.

    Attributes:
        seed: Of the whole reproduction.
        first: A multiple of `SIZE`, so that a replication is the same however many there are.
        count: At most `SIZE`.
        noise: Name of the noise condition, in training and recall.
        cells: Which tables of appendix A; none is training alone.
    """

    seed: int
    first: int
    count: int
    noise: str = LABORATORY
    cells: tuple[Cell, ...] = THESIS

    def run(self) -> Outcome:
        """Train, recall, and return the rows."""
        noise = noise_conditions()[self.noise]
        (training, _), *_ = seeds = [
            replication_seeds(self.seed, number, self.noise).spawn(2) for number in self._numbers
        ]
        training_seed = int(training.generate_state(1)[0])
        needed = max((f for cell in self.cells for s in cell.subsets for f in s.files), default=FILES)
        trained = train_learners(self.count, seed=training_seed, noise=noise, episodes=needed)
        recalling = [parts.spawn(len(self.cells)) for _, parts in seeds]
        recalls: list[RecallRow] = []
        for i, cell in enumerate(self.cells):
            states = [cells[i].generate_state(cell.size) for cells in recalling]
            recalls += self._recalls(cell, noise, trained, np.concatenate(states).astype(np.int64))
        voting = self._votes(trained) if self.noise == LABORATORY else ()
        return Outcome(tuple(recalls), tuple(self._trainings(trained)), tuple(voting))

    @property
    def _numbers(self) -> range:
        return range(self.first, self.first + self.count)

    def _trainings(self, trained: Trained) -> Iterator[TrainingRow]:
        attempts = trained.attempts
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
            )

    def _recalls(
        self, cell: Cell, noise: Noise, trained: Trained, seeds: NDArray[np.int64]
    ) -> list[RecallRow]:
        arena = the_arena(cell.arena)
        experience = [_experience(trained, i, s) for i in range(self.count) for s in cell.subsets]
        imitators = np.repeat(np.arange(len(experience)), cell.recalls)
        played = run_recalls(
            arena, memories_of(experience), imitators, seeds, foods=cell.foods, limit=cell.limit, noise=noise
        )
        own = {
            "replication": np.repeat(self._numbers, cell.size).tolist(),
            "file_id": [s.name for s in cell.subsets for _ in range(cell.recalls)] * self.count,
            "recall": list(range(cell.recalls)) * len(experience),
            "seed": seeds.tolist(),
            "experience_size": np.repeat([len(heard) for _, heard in experience], cell.recalls).tolist(),
        }
        return recall_rows(
            played,
            arena,
            own,
            episodes=cell.episodes,
            learner=IMITATOR,
            noise=self.noise,
            limit=cell.limit,
        )

    def _votes(self, trained: Trained) -> Iterator[VoteRow]:
        for cell in self.cells:
            if cell.arena == CORRIDOR.name:
                asked = [(i, s) for i in range(self.count) for s in cell.subsets]
                memories = memories_of([_experience(trained, i, s) for i, s in asked])
                diagonal = site_of(CORRIDOR).diagonal
                levels = confidence_levels(memories, arrivals(TRAINING_DISTANCE), diagonal)
                for (i, subset), own in zip(asked, levels, strict=True):
                    yield from votes(own, self.first + i, cell.episodes, subset.name)


@dataclass(frozen=True, slots=True)
class BaselineBatch:
    """The teacher alone, or a policy that draws its behaviours, under the laboratory's noise.

    Attributes:
        seed: Of the whole reproduction.
        blocks: How many; each stands for a replication.
        learner: `teacher` or `random`.
        arena: `corridor` or `rectangle`.
        forages: In each block.
    """

    seed: int
    blocks: int
    learner: str
    arena: str
    forages: int

    def run(self) -> Outcome:
        """Forage, and return the rows."""
        arena, limit = the_arena(self.arena), baseline_limit(self.learner, self.arena)
        seeds = np.concatenate(
            [
                baseline_seeds(self.seed, block, self.learner, self.arena, self.forages)
                for block in range(self.blocks)
            ]
        )
        policy = TEACHES if self.learner == TEACHER else UNIFORM
        foods = next(cell.foods for cell in THESIS if cell.arena == self.arena)
        played = run_recalls(arena, None, np.full(len(seeds), policy), seeds, foods=foods, limit=limit)
        own = {
            "replication": np.repeat(range(self.blocks), self.forages).tolist(),
            "recall": list(range(self.forages)) * self.blocks,
            "seed": seeds.tolist(),
        }
        return Outcome(
            tuple(
                recall_rows(
                    played,
                    arena,
                    own,
                    episodes=0,
                    file_id="-",
                    learner=self.learner,
                    noise=LABORATORY,
                    limit=limit,
                    experience_size=0,
                )
            )
        )


def _experience(
    trained: Trained, learner: int, subset: Subset
) -> tuple[NDArray[np.int16], NDArray[np.int16]]:
    """State vectors and behaviours of the files that a learner is given together."""
    rows = np.concatenate([trained.vectors_of(learner, file - 1) for file in subset.files])
    return rows[:, :5], rows[:, 5]
