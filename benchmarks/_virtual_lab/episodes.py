"""The same trainings and recalls twice: in the virtual laboratory, and in pymunk alone under its simulated camera."""

from contextlib import closing
from dataclasses import dataclass

import numpy as np

from khepera_forage.envs.training import TrainingEnv
from khepera_forage.experience import Experience
from khepera_forage.lab.operator import OperatorGaveUp
from khepera_forage.lab.virtual_laboratory import VirtualLaboratory
from khepera_forage.noise import Noise
from khepera_forage.policies import NearestNeighbourImitator, Policy, Teacher
from khepera_forage.robots.khepera import RobotLost
from khepera_forage.rollouts.recall import RecallInterruptedError, recall, recall_env
from khepera_forage.rollouts.rows import IMITATOR, TEACHER, RecallRow, TrainingRow
from khepera_forage.rollouts.training import arrays, train
from khepera_forage.sim.world import World

PYMUNK, VIRTUAL = "pymunk", "virtual"
WORLDS = (PYMUNK, VIRTUAL)
ARENAS = ("corridor", "rectangle")
LEARNERS = (TEACHER, IMITATOR)


@dataclass(frozen=True, slots=True)
class Outcome:
    """Rows of one replication in one world.

    Attributes:
        world: `pymunk` or `virtual`.
        trainings: One an attempt.
        recalls: One an episode.
        repeated: Recalls that were done again, as a robot was lost although its line was undisturbed. Not to be
            expected: more than a few are a fault of the chain, or a computer on which threads wait for seconds.
        unplaced: Arena and seed of recalls that could not begin: the camera never saw the robot where it was put.
    """

    world: str
    trainings: list[TrainingRow]
    recalls: list[RecallRow]
    repeated: int
    unplaced: frozenset[tuple[str, int]]


@dataclass(frozen=True, slots=True)
class Replication:
    """Train some files in a world, then have the teacher and the imitator of all these files forage alone there.

    In both worlds a replication has the same seeds: the same marks in training, the same random places in recall. What
    an operator's hand, wheels and camera make of them differs.

    Attributes:
        world: `pymunk` or `virtual`.
        number: Of the replication, from 0.
        files: Training files, a complete episode each.
        recalls: In each arena, of the teacher and of the imitator, from the same places.
        seed: Of the whole benchmark.
    """

    world: str
    number: int
    files: int
    recalls: int
    seed: int

    def run(self) -> Outcome:
        """Do all of it, with the laboratory's troubles."""
        training, *recalling = np.random.SeedSequence(self.seed, spawn_key=(self.number,)).spawn(
            1 + len(ARENAS)
        )
        experiences, trainings = self._train(training)
        recalls: list[RecallRow] = []
        repeated = 0
        unplaced: set[tuple[str, int]] = set()
        for arena, seed in zip(ARENAS, recalling, strict=True):
            rows, again, not_begun = self._recall(
                arena, experiences, seed.generate_state(self.recalls).tolist()
            )
            recalls += rows
            repeated += again
            unplaced |= not_begun
        return Outcome(self.world, trainings, recalls, repeated, frozenset(unplaced))

    def _train(self, seeds: np.random.SeedSequence) -> tuple[list[Experience], list[TrainingRow]]:
        world = self._world("corridor", 2)
        # In the virtual laboratory the operator's hand makes the errors of placement.
        noise = None if world is None else Noise.none()
        experiences, rows = [], []
        with closing(TrainingEnv(noise=noise, world=world)) as env:
            for file, seed in enumerate(seeds.spawn(self.files), start=1):
                experience, attempts = train(env, seed, replication=self.number, file=file)
                experiences.append(experience)
                rows += attempts
        return experiences, rows

    def _recall(
        self, arena: str, files: list[Experience], seeds: list[int]
    ) -> tuple[list[RecallRow], int, set[tuple[str, int]]]:
        """All recalls in an arena, how many were done again, and those that could not begin."""
        vectors, behaviours = arrays(files)
        rows: list[RecallRow] = []
        repeated, unplaced = 0, set()
        with closing(recall_env(arena, world=self._world(arena, 1))) as env:
            imitator = NearestNeighbourImitator(diagonal=env.diagonal).fit(vectors, behaviours)
            policies: dict[str, Policy] = {TEACHER: Teacher(env.home_radius), IMITATOR: imitator}
            work = [(learner, number) for learner in LEARNERS for number in range(len(seeds))]
            while work:
                learner, number = work[0]
                taught = learner == IMITATOR
                try:
                    row = recall(
                        env,
                        policies[learner],
                        seeds[number],
                        learner=learner,
                        replication=self.number,
                        episodes=self.files if taught else 0,
                        file_id=f"g1-{self.files}" if taught else "-",
                        number=number,
                        experience_size=len(behaviours) if taught else 0,
                    )
                except (RecallInterruptedError, RobotLost):
                    repeated += 1
                    if repeated > len(seeds):
                        raise
                    continue
                except OperatorGaveUp:
                    unplaced.add((arena, seeds[number]))
                else:
                    rows.append(row)
                del work[0]
        return rows, repeated, unplaced

    def _world(self, arena: str, robots: int) -> World | None:
        return VirtualLaboratory.from_arena(arena, robots) if self.world == VIRTUAL else None


def replications(count: int, files: int, recalls: int, seed: int) -> list[Replication]:
    """All of them, in both worlds."""
    return [Replication(world, i, files, recalls, seed) for i in range(count) for world in WORLDS]
