"""One replication: training, recalls in all arenas, and the imitator's wrong decisions."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from threadpoolctl import threadpool_limits

from arena_generalisation.attribution import Visits, wrong_decisions
from arena_generalisation.batch_recalls import ArenaBatch, arena_batch, recall_all
from arena_generalisation.decision_table import Decider, DecisionTable
from arena_generalisation.kernel_recalls import recall_memories
from arena_generalisation.learning import QUERYING, fitted, imitating_learners, in_arena, queried
from arena_generalisation.recall_arenas import RecallArena, named_arenas, procedural_arenas
from arena_generalisation.rows import IMITATOR, ArenaRecalls, WrongDecisions
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
from khepera_forage.envs.arguments import checked_arena
from khepera_forage.envs.forager import arena_map_of
from khepera_forage.policies.learners import FromVectors
from khepera_forage.task.decisions import DEFAULT_DECISIONS, Decisions

STRAIGHT, PATH = DEFAULT_DECISIONS, Decisions(distances="along the path")


class Size(NamedTuple):
    """How much is done.

    Attributes:
        recalls: Of each learner in each arena.
        levels: Test levels of each difficulty in each replication.
        named: Names of the arenas of the thesis and of the family.
        difficulties: Of procedural arenas.
        limit: Steps of a recall at most; by default each arena's own limit.
    """

    recalls: int
    levels: int
    named: tuple[str, ...]
    difficulties: tuple[str, ...]
    limit: int | None = None


class Contestant(NamedTuple):
    """A fitted learner.

    Attributes:
        name: Of the learner.
        training: A name of `trainings.TRAININGS`.
        learner: Its settings.
        classifier: Fitted.
        vectors: That it learned from.
    """

    name: str
    training: str
    learner: FromVectors
    classifier: object
    vectors: int


class Replication(NamedTuple):
    """One replication.

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
        choices, places, drawing = np.random.SeedSequence(self.seed, spawn_key=(0, self.number)).spawn(3)
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
        contestants = self._contestants(trained, int(choices.generate_state(1)[0]) % 2**31)
        arenas = self._arenas()
        seeds = places.generate_state(self.size.recalls).tolist()
        batches, table = _begin(arenas, contestants, seeds)
        recall_all(batches, table, np.random.default_rng(drawing))
        rows: list[ArenaRecalls | WrongDecisions] = []
        variants = {name: trained[name] for name in (HALF, MOVED, WHOLE)}
        for arena, batch in zip(arenas, batches, strict=True):
            foods = int(batch.not_poisonous[: len(seeds)].sum())
            rows += self._recalls(arena, batch, contestants)
            rows += recall_memories(arena, variants, seeds, foods, self.number, STRAIGHT, bounds=True)
            rows += recall_memories(arena, by_path, seeds, foods, self.number, PATH, bounds=False)
            for number, contestant in enumerate(contestants):
                if contestant.name == IMITATOR:
                    decider = int(batch.deciders[number * len(seeds)])
                    visits = Visits(arena, *table.visited(decider))
                    name = contestant.training
                    rows += wrong_decisions(visits, trained[name], name, self.number)
        return rows

    def _contestants(self, trained: dict[str, Training], seed: int) -> list[Contestant]:
        """All learners, trained in the corridor and in varied arenas."""
        found = [
            Contestant(name, training, learner, fitted(learner, own, seed), len(own.vectors))
            for training, own in trained.items()
            if training in (CORRIDOR, VARIED)
            for name, learner in imitating_learners().items()
        ]
        for training, (learner, classifier, queries) in queried(
            self.number, seed, self.size.difficulties, STRAIGHT
        ).items():
            found.append(Contestant(QUERYING, training, learner, classifier, queries))
        return found

    def _arenas(self) -> list[RecallArena]:
        arenas, levels = named_arenas(self.size.named), self.size.levels
        for difficulty in self.size.difficulties:
            arenas += procedural_arenas(difficulty, "test", self.number * levels, levels)
        return arenas if self.size.limit is None else [arena.limited(self.size.limit) for arena in arenas]

    def _recalls(
        self, arena: RecallArena, batch: ArenaBatch, contestants: Sequence[Contestant]
    ) -> list[ArenaRecalls]:
        """The rows of all contestants in one arena."""
        rows, count = [], self.size.recalls
        for place, contestant in enumerate(contestants):
            own = slice(place * count, (place + 1) * count)
            rows.append(
                ArenaRecalls(
                    learner=contestant.name,
                    training=contestant.training,
                    distances=STRAIGHT.distances,
                    replication=self.number,
                    group=arena.group,
                    arena=arena.name,
                    vectors=contestant.vectors,
                    recalls=count,
                    foods=int(batch.not_poisonous[own].sum()),
                    delivered=int(batch.delivered[own].sum()),
                    poison_home=int(batch.poison_home[own].sum()),
                    score=float(batch.score[own].mean()),
                    steps=int(batch.steps[own].sum()),
                )
            )
        return rows


def _begin(
    arenas: Sequence[RecallArena], contestants: Sequence[Contestant], seeds: Sequence[int]
) -> tuple[list[ArenaBatch], DecisionTable]:
    """The batches of all arenas, and the table of all deciders.

    A learner that takes the arena's diagonal has a decider in each arena, any other learner one for all arenas.
    """
    deciders: list[Decider] = []
    shared: dict[int, int] = {}
    batches = []
    for arena in arenas:
        diagonal = arena_map_of(checked_arena(arena.arena, STRAIGHT)).diagonal
        numbers = []
        for place, (_, _, learner, classifier, _) in enumerate(contestants):
            number = len(deciders) if learner.diagonal else shared.setdefault(place, len(deciders))
            if number == len(deciders):
                deciders.append(Decider(in_arena(learner, classifier, diagonal), learner.sample))
            numbers.append(number)
        batches.append(arena_batch(arena, numbers, seeds))
    return batches, DecisionTable(deciders)
