"""How much is done in each replication, and with which random numbers."""

from typing import NamedTuple

import numpy as np

from arena_generalisation.recall_arenas import RecallArena, named_arenas, procedural_arenas


class Size(NamedTuple):
    """How much is done.

    Attributes:
        recalls: Of each learner in each arena.
        levels: Test levels of each difficulty in each replication.
        named: Names of the arenas of the thesis and of the family.
        difficulties: Of procedural arenas.
        steps: Environment steps of each training of a reinforcement learner.
        limit: Steps of a recall at most; by default each arena's own limit.
        queries: To the teacher, in each training of a learner that queries it.
    """

    recalls: int
    levels: int
    named: tuple[str, ...]
    difficulties: tuple[str, ...]
    steps: int
    limit: int | None = None
    queries: int = 1_000

    def arenas(self, replication: int) -> list[RecallArena]:
        """All arenas in which the learners of a replication forage."""
        arenas = named_arenas(self.named)
        for difficulty in self.difficulties:
            arenas += procedural_arenas(difficulty, "test", replication * self.levels, self.levels)
        return arenas if self.limit is None else [arena.limited(self.limit) for arena in arenas]


class Seeds(NamedTuple):
    """Where the random numbers of a replication come from; they are the same for all learners.

    Attributes:
        learning: Seed of learners' random choices.
        recalls: Of the recalls in each arena: places and noise.
        drawing: Of the behaviours that are drawn in recalls.
    """

    learning: int
    recalls: list[int]
    drawing: np.random.SeedSequence


def seeds_of(seed: int, replication: int, size: Size) -> Seeds:
    """The seeds of a replication.

    Args:
        seed: Of the whole run.
        replication: Its number, from 0.
        size: Of the whole run.
    """
    choices, places, drawing = np.random.SeedSequence(seed, spawn_key=(0, replication)).spawn(3)
    learning = int(choices.generate_state(1)[0]) % 2**31
    return Seeds(learning, places.generate_state(size.recalls).tolist(), drawing)
