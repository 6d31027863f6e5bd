"""One replication: all imitators and DAgger's tree are trained and forage in all arenas.

The imitator's wrong decisions are counted.
"""

from typing import NamedTuple

import numpy as np
from threadpoolctl import threadpool_limits

from arena_generalisation.attribution import Visits, wrong_decisions
from arena_generalisation.contestants import Contestant, recall_rows, recalled
from arena_generalisation.kernel_recalls import recall_memories
from arena_generalisation.learning import fitted, imitating_learners, queried, querying_learners
from arena_generalisation.rows import IMITATOR, ArenaRecalls, WrongDecisions
from arena_generalisation.size import Size, seeds_of
from arena_generalisation.trainings import (
    CORRIDOR,
    HALF,
    MOVED,
    VARIED,
    WHOLE,
    Training,
    corridor_trainings,
    varied_trainings,
)
from khepera_forage.task.decisions import DEFAULT_DECISIONS, Decisions

STRAIGHT, PATH = DEFAULT_DECISIONS, Decisions(distances="along the path")
QUERYING = "dagger_tree"
"""The learner that queries the teacher here; any other one has `LearnerReplication`."""


class Replication(NamedTuple):
    """One replication of all imitators.

    Attributes:
        seed: Of the whole run.
        number: From 0.
        size: Of the whole run.
    """

    seed: int
    number: int
    size: Size

    @property
    def key(self) -> str:
        """Number of the replication."""
        return f"replication {self.number}"

    def run(self) -> list[ArenaRecalls | WrongDecisions]:
        """Train and recall.

        Linear algebra runs on one thread, because sums depend on the number of threads.
        """
        with threadpool_limits(1):
            return self._run()

    def _run(self) -> list[ArenaRecalls | WrongDecisions]:
        seeds = seeds_of(self.seed, self.number, self.size)
        trained = corridor_trainings(self.seed, self.number)
        straight, along_path = (
            varied_trainings(
                self.seed,
                self.number,
                len(trained[CORRIDOR].vectors),
                self.size.difficulties,
                decisions,
            )
            for decisions in (STRAIGHT, PATH)
        )
        trained |= straight
        by_path = {CORRIDOR: trained[CORRIDOR], **along_path}
        contestants = self._contestants(trained, seeds.learning)
        arenas = self.size.arenas(self.number)
        rng = np.random.default_rng(seeds.drawing)
        batches, table = recalled(arenas, contestants, seeds.recalls, rng)
        rows: list[ArenaRecalls | WrongDecisions] = []
        variants = {name: trained[name] for name in (HALF, MOVED, WHOLE)}
        for arena, batch in zip(arenas, batches, strict=True):
            foods = int(batch.not_poisonous[: self.size.recalls].sum())
            rows += recall_rows(arena, batch, contestants, self.number)
            rows += recall_memories(arena, variants, seeds.recalls, foods, self.number, STRAIGHT, bounds=True)
            rows += recall_memories(arena, by_path, seeds.recalls, foods, self.number, PATH, bounds=False)
            for number, contestant in enumerate(contestants):
                if contestant.name == IMITATOR:
                    decider = int(batch.deciders[number * self.size.recalls])
                    visits = Visits(arena, *table.visited(decider))
                    name = contestant.training
                    rows += wrong_decisions(visits, trained[name], name, self.number)
        return rows

    def _contestants(self, trained: dict[str, Training], seed: int) -> list[Contestant]:
        """All learners, trained in the corridor and in varied arenas."""
        found = [
            Contestant.imitating(name, training, learner, fitted(learner, own, seed), len(own.vectors))
            for training, own in trained.items()
            if training in (CORRIDOR, VARIED)
            for name, learner in imitating_learners().items()
        ]
        return found + queried(QUERYING, querying_learners()[QUERYING], self.number, seed, self.size)
