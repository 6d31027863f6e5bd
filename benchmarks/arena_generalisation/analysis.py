"""Estimates from the rows."""

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np

from arena_generalisation.learning import imitating_learners, querying_learners
from arena_generalisation.recall_arenas import NAMED, THESIS
from arena_generalisation.reinforcement import reinforcement_learners
from arena_generalisation.rows import AS_IT_IS, RANDOM, TEACHER, UNTRAINED, ArenaRecalls, WrongDecisions
from arena_generalisation.trainings import CORRIDOR
from khepera_forage.comparison.units import all_learners
from khepera_forage.experiments.measures import Measure, combined, mean, pick
from khepera_forage.experiments.statistics import Estimate
from khepera_forage.policies.learners import LEARNERS
from khepera_forage.sim.arenas.difficulty import DIFFICULTIES
from khepera_forage.task.decisions import DEFAULT_DECISIONS

STRAIGHT = DEFAULT_DECISIONS.distances
DELIVERED: Measure[ArenaRecalls] = Measure(
    "food delivered (%)", lambda row: 100.0 * row.delivered, lambda row: row.foods
)
SCORE: Measure[ArenaRecalls] = Measure(
    "score (%)", lambda row: row.score * row.recalls, lambda row: row.recalls
)
POISON: Measure[ArenaRecalls] = Measure(
    "poison brought home per recall", lambda row: row.poison_home, lambda row: row.recalls, 2
)
VECTORS: Measure[ArenaRecalls] = Measure("vectors", lambda row: row.vectors)
WRONG: Measure[WrongDecisions] = Measure(
    "wrong decisions (%)", lambda row: 100.0 * row.still_wrong, lambda row: row.decisions
)
CORRECTED: Measure[WrongDecisions] = Measure(
    "corrected (%)", lambda row: 100.0 * row.corrected, lambda row: row.wrong
)
BEYOND: Measure[WrongDecisions] = Measure(
    "beyond the training (%)", lambda row: 100.0 * row.beyond, lambda row: row.wrong
)
_ARENA_TITLES = {"t_maze": "T-maze", "l_room": "L-shaped room"}


class Analysis:
    """The rows, and estimates from them.

    Args:
        recalls: All recalls.
        wrong: The imitator's wrong decisions.
        rng: Draws resamples.
    """

    def __init__(
        self, recalls: Sequence[ArenaRecalls], wrong: Sequence[WrongDecisions], rng: np.random.Generator
    ) -> None:
        self.recalls, self.wrong, self.rng = recalls, wrong, rng
        known = {row.learner for row in recalls}
        self.reinforced = [name for name in reinforcement_learners() if name in known]
        self.querying = [name for name in querying_learners() if name in known]
        imitating = [name for name in imitating_learners() if name in known]
        self.learners = imitating + self.querying + self.reinforced
        self.arenas = self._names(THESIS) + self._names(NAMED)
        groups = {row.group for row in recalls}
        self.difficulties = [name for name in DIFFICULTIES if name in groups]

    @property
    def bounded(self) -> list[str]:
        """All learners, with the teacher before and random behaviours behind them."""
        return [TEACHER, *self.learners, RANDOM]

    @property
    def named(self) -> list[str]:
        """The arenas of the family that learners foraged in."""
        return self._names(NAMED)

    def rows(
        self, learner: str, training: str = CORRIDOR, distances: str = STRAIGHT, **fields: object
    ) -> list[ArenaRecalls]:
        """The recalls of a learner; a bound has the same ones whatever the training."""
        training = UNTRAINED if learner in (TEACHER, RANDOM) else training
        return pick(self.recalls, learner=learner, training=training, distances=distances, **fields)

    def estimate(self, rows: Sequence[ArenaRecalls], measure: Measure[ArenaRecalls] = DELIVERED) -> Estimate:
        """A measure; every arena of the family counts as much as any other."""
        arenas = {row.arena for row in rows if row.group == NAMED}
        if len(arenas) < 2:
            return mean(rows, measure, self.rng)
        groups = [(1 / len(arenas), pick(rows, arena=name)) for name in sorted(arenas)]
        return combined(groups, measure, self.rng)

    def delivered(self, learner: str, training: str, distances: str = STRAIGHT, **fields: Any) -> Estimate:
        """Share of the food that a learner delivers, percent."""
        return self.estimate(self.rows(learner, training, distances, **fields))

    def wrong_rows(self, training: str, change: str = AS_IT_IS, **fields: object) -> list[WrongDecisions]:
        """The imitator's decisions with one change to its distance."""
        return pick(self.wrong, training=training, change=change, **fields)

    def gain(
        self, learner: str, ours: tuple[str, str], others: tuple[str, str] = (CORRIDOR, STRAIGHT)
    ) -> Estimate:
        """How much more of the family's food a learner delivers, points.

        Args:
            learner: Its name.
            ours: Training and distances.
            others: Those that it is compared with.
        """
        groups = [
            (sign / len(self.named), self.rows(learner, *condition, arena=name))
            for sign, condition in ((1.0, ours), (-1.0, others))
            for name in self.named
        ]
        return combined(groups, DELIVERED, self.rng)

    def _names(self, group: str) -> list[str]:
        return list(dict.fromkeys(row.arena for row in self.recalls if row.group == group))


def title(learner: str) -> str:
    """A learner's name for tables and figures."""
    known = LEARNERS.get(learner) or all_learners()[learner]
    return known.title


def titles(learners: Iterable[str]) -> str:
    """Learners' names in a list; some of the names have a comma."""
    return "; ".join(title(learner) for learner in learners) or "none"


def arena_title(arena: str) -> str:
    """An arena's name for tables and figures."""
    return _ARENA_TITLES.get(arena, arena.replace("_", " "))
