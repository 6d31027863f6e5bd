"""Fitted learners, and their recalls in all arenas."""

import copy
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from arena_generalisation.batch_recalls import ArenaBatch, arena_batch, recall_all
from arena_generalisation.decision_table import Decider, DecisionTable
from arena_generalisation.recall_arenas import RecallArena
from arena_generalisation.rows import ArenaRecalls
from khepera_forage.envs.arguments import checked_arena
from khepera_forage.envs.forager import arena_map_of
from khepera_forage.policies.learners import FromVectors
from khepera_forage.task.decisions import DEFAULT_DECISIONS


class Contestant(NamedTuple):
    """A fitted learner.

    Attributes:
        name: Of the learner.
        training: A name of `trainings.TRAININGS`.
        classifier: Fitted.
        sample: As in `Decider`.
        vectors: That it learned from.
        diagonal: Whether it takes the arena's diagonal.
        hold: As in `Decider`.
    """

    name: str
    training: str
    classifier: Any
    sample: bool
    vectors: int = 0
    diagonal: bool = False
    hold: int = 1

    @classmethod
    def imitating(
        cls, name: str, training: str, learner: FromVectors, classifier: Any, vectors: int
    ) -> "Contestant":
        """A learner that was fitted on state vectors and the teacher's behaviours.

        Args:
            name: Of the learner.
            training: A name of `trainings.TRAININGS`.
            learner: Its settings.
            classifier: Fitted.
            vectors: That it learned from.
        """
        return cls(name, training, classifier, learner.sample, vectors, learner.diagonal)

    def decider(self, diagonal: int) -> Decider:
        """The learner in an arena.

        Args:
            diagonal: Of the arena, in pixels.
        """
        classifier = self.classifier
        if self.diagonal:
            classifier = copy.copy(classifier).set_params(diagonal=diagonal)
        return Decider(classifier, self.sample, self.hold)


def recalled(
    arenas: Sequence[RecallArena],
    contestants: Sequence[Contestant],
    seeds: Sequence[int],
    rng: np.random.Generator,
) -> tuple[list[ArenaBatch], DecisionTable]:
    """The batches of all arenas after all recalls, and the table of all deciders.

    A learner that takes the arena's diagonal has a decider in each arena, any other learner one for all arenas.

    Args:
        arenas: Where.
        contestants: Each of them has a recall with each seed in each arena.
        seeds: Of the recalls.
        rng: Draws behaviours.
    """
    deciders: list[Decider] = []
    shared: dict[int, int] = {}
    batches = []
    for arena in arenas:
        diagonal = arena_map_of(checked_arena(arena.arena, DEFAULT_DECISIONS)).diagonal
        numbers = []
        for place, contestant in enumerate(contestants):
            own = contestant.diagonal
            number = len(deciders) if own else shared.setdefault(place, len(deciders))
            if number == len(deciders):
                deciders.append(contestant.decider(diagonal))
            numbers.append(number)
        batches.append(arena_batch(arena, numbers, seeds))
    table = DecisionTable(deciders)
    recall_all(batches, table, rng)
    return batches, table


def recall_rows(
    arena: RecallArena, batch: ArenaBatch, contestants: Sequence[Contestant], replication: int
) -> list[ArenaRecalls]:
    """The rows of all contestants in one arena.

    Args:
        arena: Where.
        batch: Its recalls, from `recalled`.
        contestants: Those of the batch.
        replication: For the rows.
    """
    rows, count = [], len(batch.deciders) // len(contestants)
    for place, contestant in enumerate(contestants):
        own = slice(place * count, (place + 1) * count)
        rows.append(
            ArenaRecalls(
                learner=contestant.name,
                training=contestant.training,
                distances=DEFAULT_DECISIONS.distances,
                replication=replication,
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
