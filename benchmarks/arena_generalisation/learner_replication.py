"""One learner in one replication, apart from all others: rows of an earlier run without it stay in use."""

from typing import NamedTuple

import numpy as np
from threadpoolctl import threadpool_limits

from arena_generalisation.contestants import Contestant, recall_rows, recalled
from arena_generalisation.learning import queried, querying_learners
from arena_generalisation.reinforcement import reinforced, reinforcement_learners
from arena_generalisation.replication import QUERYING
from arena_generalisation.rows import ArenaRecalls
from arena_generalisation.size import Size, seeds_of
from khepera_forage.policies.learners import FromQueries, FromSteps


def single_learners() -> dict[str, FromQueries | FromSteps]:
    """All learners that act with behaviours and are not in `Replication`, by name."""
    querying = {name: learner for name, learner in querying_learners().items() if name != QUERYING}
    return {**querying, **reinforcement_learners()}


class LearnerReplication(NamedTuple):
    """One learner in one replication.

    Attributes:
        seed: Of the whole run.
        number: Of the replication, from 0.
        size: Of the whole run.
        name: Of the learner.
        learner: From `single_learners`.
    """

    seed: int
    number: int
    size: Size
    name: str
    learner: FromQueries | FromSteps

    @property
    def key(self) -> str:
        """Learner and number of the replication."""
        return f"{self.name} {self.number}"

    def run(self) -> list[ArenaRecalls]:
        """Train and recall, with the arenas and places of all other learners.

        Linear algebra runs on one thread, because sums depend on the number of threads.
        """
        with threadpool_limits(1):
            seeds, arenas = seeds_of(self.seed, self.number, self.size), self.size.arenas(self.number)
            contestants = self._contestants(seeds.learning)
            rng = np.random.default_rng(seeds.drawing)
            batches, _ = recalled(arenas, contestants, seeds.recalls, rng)
            return [
                row
                for arena, batch in zip(arenas, batches, strict=True)
                for row in recall_rows(arena, batch, contestants, self.number)
            ]

    def _contestants(self, seed: int) -> list[Contestant]:
        """The learner, trained in the corridor and in varied arenas."""
        if isinstance(self.learner, FromQueries):
            return queried(self.name, self.learner, self.number, seed, self.size)
        return reinforced(self.name, self.learner, self.number, self.seed, seed, self.size)
