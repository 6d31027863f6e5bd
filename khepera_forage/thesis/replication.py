"""One replication of the thesis's design on pymunk: training files, recalls and their rows (5.4)."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from khepera_forage.envs.arguments import checked_arena
from khepera_forage.envs.layouts import arena_map_of
from khepera_forage.envs.training import TrainingEnv
from khepera_forage.experience import Experience
from khepera_forage.noise import Noise
from khepera_forage.policies import Policy, Teacher
from khepera_forage.policies.policy import UniformPolicy
from khepera_forage.rollouts.recall import recall, recall_env
from khepera_forage.rollouts.rows import RANDOM, TEACHER, RecallRow, TrainingRow
from khepera_forage.rollouts.training import arrays, train
from khepera_forage.sim.arenas.thesis import CORRIDOR
from khepera_forage.task.decisions import DEFAULT_DECISIONS, Decisions
from khepera_forage.thesis.design import (
    LABORATORY,
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
    """The seeds of training and recalls in one replication.

    Args:
        seed: Of the whole reproduction.
        number: Of the replication.
        noise: Name of the noise condition.
    """
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
        noise: Name of the noise condition, in training and recall.
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
    """A block of forages of the teacher, or of a random policy, under the laboratory's noise.

    Attributes:
        seed: Of the whole reproduction.
        number: Of the block, which counts as a replication.
        learner: `teacher` or `random`.
        arena: `corridor` or `rectangle`.
        forages: Number of forages.
        decisions: Of the forages.
    """

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
