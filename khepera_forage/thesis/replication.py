"""The thesis' whole design, replicated: work that can be done in any order, on any number of cores (5.4)."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from khepera_forage.envs.forager import site_of
from khepera_forage.envs.training import TrainingEnv
from khepera_forage.experience import Experience
from khepera_forage.noise import Noise
from khepera_forage.policies import NearestNeighbourImitator, Policy, Teacher
from khepera_forage.policies.uniform import UniformPolicy
from khepera_forage.rollouts.recall import recall, recall_env
from khepera_forage.rollouts.rows import RANDOM, TEACHER, RecallRow, TrainingRow
from khepera_forage.rollouts.training import arrays, train
from khepera_forage.sim.arena import CORRIDOR
from khepera_forage.thesis.design import (
    FILES,
    LABORATORY,
    NO_LOSSES,
    THESIS,
    Cell,
    Subset,
    noise_conditions,
)
from khepera_forage.thesis.orient_analysis import VoteRow, arrivals, levels_of, votes
from khepera_forage.vision.scene import MM_PER_PIXEL

TRAINING_DISTANCE = round(math.dist(CORRIDOR.foods[0], CORRIDOR.home) / MM_PER_PIXEL)
"""Pixels between food and home in training."""
TEACHER_LIMIT_FACTOR = 3
"""The teacher is given this many times the thesis' limits, to see whether those are enough."""


def replication_seeds(seed: int, number: int, noise: str) -> np.random.SeedSequence:
    """Of training and recalls in one replication.

    Args:
        seed: Of the whole reproduction.
        number: Of the replication.
        noise: Name of the noise condition.
    """
    return np.random.SeedSequence(seed, spawn_key=(number, list(noise_conditions()).index(noise)))


def baseline_seeds(seed: int, block: int, learner: str, arena: str, forages: int) -> NDArray[np.int64]:
    """Of the forages of one block of `Baseline`."""
    key = (block, 1000 + (learner == RANDOM), len(arena))
    return np.random.SeedSequence(seed, spawn_key=key).generate_state(forages).astype(np.int64)


def baseline_limit(learner: str, arena: str) -> int:
    """Steps that the teacher or a random policy is given."""
    limit = next(cell.limit for cell in THESIS if cell.arena == arena)
    return limit * TEACHER_LIMIT_FACTOR if learner == TEACHER else limit


@dataclass(frozen=True, slots=True)
class Outcome:
    """Rows of one piece of work."""

    recalls: tuple[RecallRow, ...] = ()
    trainings: tuple[TrainingRow, ...] = ()
    votes: tuple[VoteRow, ...] = ()


@dataclass(frozen=True, slots=True)
class Replication:
    """Ten new training files, and the recalls of some cells with them.

    Attributes:
        seed: Of the whole reproduction.
        number: Of the replication.
        noise: Name of the noise condition, in training and recall.
        cells: Which tables of appendix A.
    """

    seed: int
    number: int
    noise: str = LABORATORY
    cells: tuple[Cell, ...] = THESIS

    def run(self) -> Outcome:
        """Train, recall, and return the rows."""
        noise = noise_conditions()[self.noise]
        training, recalling = replication_seeds(self.seed, self.number, self.noise).spawn(2)
        files, trainings = self._train(noise, training)
        recalls = tuple(self._recalls(noise, files, recalling))
        return Outcome(
            recalls, tuple(trainings), tuple(self._votes(files)) if self.noise == LABORATORY else ()
        )

    def _train(
        self, noise: Noise, seeds: np.random.SeedSequence
    ) -> tuple[list[Experience], list[TrainingRow]]:
        env = TrainingEnv(noise=noise)
        files, rows = [], []
        needed = max((f for cell in self.cells for s in cell.subsets for f in s.files), default=FILES)
        for file, seed in enumerate(seeds.spawn(needed), 1):
            experience, attempts = train(env, seed, self.noise, self.number, file)
            files.append(experience)
            rows += attempts
        env.close()
        return files, rows

    def _recalls(
        self, noise: Noise, files: Sequence[Experience], seeds: np.random.SeedSequence
    ) -> Iterator[RecallRow]:
        for cell, cell_seeds in zip(self.cells, seeds.spawn(len(self.cells)), strict=True):
            env = recall_env(cell.arena, noise)
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

    def _votes(self, files: Sequence[Experience]) -> Iterator[VoteRow]:
        for cell in self.cells:
            if cell.arena == CORRIDOR.name:
                for subset in cell.subsets:
                    imitator, _ = self._imitator(subset, files, site_of(CORRIDOR).diagonal)
                    levels = levels_of(imitator, arrivals(TRAINING_DISTANCE))
                    yield from votes(levels, self.number, cell.episodes, subset.name)

    @staticmethod
    def _imitator(
        subset: Subset, files: Sequence[Experience], diagonal: int
    ) -> tuple[NearestNeighbourImitator, int]:
        vectors, behaviours = arrays([files[f - 1] for f in subset.files])
        return NearestNeighbourImitator(diagonal=diagonal).fit(vectors, behaviours), len(behaviours)


@dataclass(frozen=True, slots=True)
class Baseline:
    """The teacher alone, or a policy that draws its behaviours: a block of forages under the laboratory's noise.

    Attributes:
        seed: Of the whole reproduction.
        number: Of the block; it stands for a replication.
        learner: `teacher` or `random`.
        arena: `corridor` or `rectangle`.
        forages: How many.
    """

    seed: int
    number: int
    learner: str
    arena: str
    forages: int

    def run(self) -> Outcome:
        """Forage, and return the rows."""
        env = recall_env(self.arena, limit=baseline_limit(self.learner, self.arena))
        policy: Policy = Teacher(env.home_radius) if self.learner == TEACHER else UniformPolicy()
        seeds = baseline_seeds(self.seed, self.number, self.learner, self.arena, self.forages)
        rows = tuple(
            recall(env, policy, seed, learner=self.learner, replication=self.number, number=i)
            for i, seed in enumerate(seeds.tolist())
        )
        env.close()
        return Outcome(rows)


@dataclass(frozen=True, slots=True)
class Attempts:
    """Ten training files under another noise condition, for their attempts alone (5.3.1)."""

    seed: int
    number: int
    noise: str = NO_LOSSES

    def run(self) -> Outcome:
        """Train, and return the rows."""
        return Outcome(trainings=Replication(self.seed, self.number, self.noise, ()).run().trainings)
