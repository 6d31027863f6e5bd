"""The same trainings and recalls in the virtual laboratory and in pymunk alone, with its simulated camera."""

from contextlib import closing
from dataclasses import asdict, dataclass
from typing import NamedTuple

import numpy as np

from khepera_forage.envs.laboratories import virtual_laboratory
from khepera_forage.envs.training import TrainingEnv
from khepera_forage.experience import Experience
from khepera_forage.lab.operator import OperatorGaveUp
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
REPEATED, UNPLACED = "repeated", "unplaced"


@dataclass(frozen=True, slots=True)
class LabRecall(RecallRow):
    """A recall in one of `WORLDS`."""

    world: str = ""


@dataclass(frozen=True, slots=True)
class LabTraining(TrainingRow):
    """An attempt at a training episode in one of `WORLDS`."""

    world: str = ""


@dataclass(frozen=True, slots=True)
class Exclusion:
    """A recall that does not count.

    Attributes:
        world: One of `WORLDS`.
        replication: Of the recall.
        number: Of the exclusion in this replication, from 0.
        arena: Of the recall.
        seed: Of the recall.
        reason: `REPEATED`: a robot was lost on an undisturbed line, and the recall was done again. More than a few of
            these are a fault of the programs, or of a computer on which threads wait for seconds. `UNPLACED`: the
            recall could not begin, because the camera never found the robot where it was placed.
    """

    world: str
    replication: int
    number: int
    arena: str
    seed: int
    reason: str


LabRow = LabRecall | LabTraining | Exclusion


class Size(NamedTuple):
    """How much is done in a replication.

    Attributes:
        files: Training files, a complete episode each.
        recalls: In each arena, of the teacher and of the imitator, from the same places.
        rounds: Time limit of an attempt at a training episode.
        steps: Time limit of a recall; by default that of its arena.
    """

    files: int = 5
    recalls: int = 4
    rounds: int = 600
    steps: int | None = None


class Replication(NamedTuple):
    """Training files in one world, then recalls of the teacher and of the imitator of all these files there.

    A replication has the same seeds in both worlds: the same marks in training, the same random places in recall. The
    noise of the operator's hand, the wheels and the camera differs.

    Attributes:
        world: One of `WORLDS`.
        number: Of the replication, from 0.
        size: How much is done.
        seed: Of the whole benchmark.
    """

    world: str
    number: int
    size: Size
    seed: int

    @property
    def key(self) -> str:
        """World and number."""
        return f"{self.world} {self.number}"

    def run(self) -> list[LabRow]:
        """Train and recall, in the laboratory's noise."""
        seeds = np.random.SeedSequence(self.seed, spawn_key=(self.number,))
        training, *recalling = seeds.spawn(1 + len(ARENAS))
        files, rows = self._train(training)
        for arena, seed in zip(ARENAS, recalling, strict=True):
            self._recall(arena, files, seed.generate_state(self.size.recalls).tolist(), rows)
        return rows

    def _train(self, seeds: np.random.SeedSequence) -> tuple[list[Experience], list[LabRow]]:
        world = self._world("corridor", 2)
        # In the virtual laboratory, the operator's hand makes the errors of placement.
        noise = None if world is None else Noise.none()
        files: list[Experience] = []
        rows: list[LabRow] = []
        with closing(TrainingEnv(noise=noise, max_cycles=self.size.rounds, world=world)) as env:
            for file, seed in enumerate(seeds.spawn(self.size.files), start=1):
                experience, attempts = train(env, seed, replication=self.number, file=file)
                files.append(experience)
                rows += [LabTraining(**asdict(row), world=self.world) for row in attempts]
        return files, rows

    def _recall(self, arena: str, files: list[Experience], seeds: list[int], rows: list[LabRow]) -> None:
        """Add the rows of all recalls in an arena."""
        vectors, behaviours = arrays(files)
        excluded = sum(isinstance(row, Exclusion) for row in rows)
        repeated = 0
        with closing(recall_env(arena, limit=self.size.steps, world=self._world(arena, 1))) as env:
            imitator = NearestNeighbourImitator(diagonal=env.diagonal).fit(vectors, behaviours)
            policies: dict[str, Policy] = {TEACHER: Teacher.of(env), IMITATOR: imitator}
            work = [(learner, number) for learner in LEARNERS for number in range(len(seeds))]
            while work:
                learner, number = work[0]
                taught = learner == IMITATOR
                reason = ""
                try:
                    row = recall(
                        env,
                        policies[learner],
                        seeds[number],
                        learner=learner,
                        replication=self.number,
                        episodes=self.size.files if taught else 0,
                        file_id=f"g1-{self.size.files}" if taught else "-",
                        number=number,
                        experience_size=len(behaviours) if taught else 0,
                    )
                    rows.append(LabRecall(**asdict(row), world=self.world))
                except (RecallInterruptedError, RobotLost):
                    reason = REPEATED
                    repeated += 1
                    if repeated > len(seeds):
                        raise
                except OperatorGaveUp:
                    reason = UNPLACED
                if reason:
                    rows.append(Exclusion(self.world, self.number, excluded, arena, seeds[number], reason))
                    excluded += 1
                if reason != REPEATED:
                    del work[0]

    def _world(self, arena: str, robots: int) -> World | None:
        return virtual_laboratory(arena, robots) if self.world == VIRTUAL else None


def replications(count: int, size: Size, seed: int) -> list[Replication]:
    """All replications, in both worlds."""
    return [Replication(world, i, size, seed) for i in range(count) for world in WORLDS]
