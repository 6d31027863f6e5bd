"""What the experiments' reports are made of: measures, means, differences, claims and tables."""

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from typing import TypeVar

import numpy as np

from further_experiments.rows import RecallEpisode, TrainingEpisode
from khepera_forage.estimates import (
    Column,
    Estimate,
    Measure,
    Table,
    Value,
    difference,
    mean,
    means_table,
    pick,
)
from khepera_forage.task.states import State
from khepera_forage.thesis.claims.claim import Claim, Rule, Unit, judged

RowT = TypeVar("RowT", TrainingEpisode, RecallEpisode)

SCORE = Measure[RecallEpisode]("score (%)", lambda row: row.score)
AGREEMENT = Measure[RecallEpisode]("steps as the teacher (%)", lambda row: 100 * row.correct / row.steps)
DELIVERED = Measure[RecallEpisode](
    "food delivered (%)", lambda row: 100 * row.delivered, lambda row: float(row.foods)
)
SETTLED = Measure[RecallEpisode](
    "food settled (%)", lambda row: 100 * (row.delivered + row.avoided), lambda row: float(row.foods)
)
POISON_HOME = Measure[RecallEpisode](
    "poison brought home (%)", lambda row: 100 * row.poison_home, lambda row: float(row.foods)
)
STEPS = Measure[RecallEpisode]("steps", lambda row: float(row.steps), digits=0)
VECTORS = Measure[RecallEpisode]("experience vectors", lambda row: float(row.vectors), digits=0)
DISTINCT = Measure[RecallEpisode]("different experience vectors", lambda row: float(row.distinct), digits=0)
ATTEMPTS = Measure[TrainingEpisode]("attempts an episode", lambda row: float(row.attempts), digits=2)
ROUNDS = Measure[TrainingEpisode]("rounds of a complete episode", lambda row: float(row.rounds))
WAITED = Measure[TrainingEpisode]("rounds spent waiting", lambda row: float(row.rounds - row.vectors))
SEPARATIONS = Measure[TrainingEpisode](
    "separations a learner", lambda row: row.separations / row.amount, digits=2
)
TRUE = Measure[TrainingEpisode](
    "vectors with the teacher's behaviour (%)", lambda row: 100.0 * row.true, lambda row: row.vectors
)
PERCENT = Unit("%", ".1f")
FOOD_POINTS = Unit("points of food delivered", "+.1f")

NEARER, ABOUT, FURTHER = "nearer home", "about as in training", "further out"
PLACES = {NEARER: (-math.inf, -5.0), ABOUT: (-5.0, 15.0), FURTHER: (15.0, math.inf)}
"""Where the food lay: pixels beyond the mark of figure 5.1, at least the first number and less than the second."""
STATES = tuple(state for state in State if state != State.UNKNOWN)


@dataclass(frozen=True, slots=True)
class Analysis:
    """All rows of an experiment, with the generator that draws resamples."""

    trainings: list[TrainingEpisode]
    recalls: list[RecallEpisode]
    rng: np.random.Generator

    @property
    def amounts(self) -> list[int]:
        """The amounts of recall episodes, from 1."""
        return amounts_of(self.recalls)

    def mean(self, rows: Sequence[RowT], measure: Measure[RowT]) -> Estimate:
        """A mean with its interval."""
        return mean(rows, measure, self.rng)

    def difference(self, rows: Sequence[RowT], others: Sequence[RowT], measure: Measure[RowT]) -> Estimate:
        """How much greater a mean is in `rows` than in `others`."""
        return difference(rows, others, measure, self.rng)

    def percent(self, rows: Sequence[RowT], measure: Measure[RowT] = DELIVERED) -> str:  # type: ignore[assignment]
        """A mean in text."""
        return PERCENT(self.mean(rows, measure).value)

    def recall_table(
        self, note: str, measures: Sequence[Measure[RecallEpisode]], amount: str = "episodes"
    ) -> Table:
        """Means by condition, arena and amount."""
        by = {"condition": "condition", "arena": "arena", "amount": amount}
        return means_table("recalls", "Recall", note, by, self.recalls, measures, self.rng)

    def training_table(
        self, note: str, measures: Sequence[Measure[TrainingEpisode]], amount: str = "files"
    ) -> Table:
        """Means by condition and amount."""
        by = {"condition": "condition", "amount": amount}
        return means_table("trainings", "Training", note, by, self.trainings, measures, self.rng)

    def places_table(self, amount: int) -> Table:
        """Score and food delivered of every condition after some number of episodes, by where the food lay."""
        shown = [
            replace(row, condition=f"{condition}; food {place}")
            for condition in conditions_of(self.recalls)
            for place in PLACES
            for row in at(pick(self.recalls, condition=condition, amount=amount), place)
        ]
        note = (
            "Recall in the corridor by how far from home the food lay: more than 5 pixels of 5 mm nearer than the mark "
            "of figure 5.1, at least 15 pixels further out, or between."
        )
        by = {"condition": "condition", "arena": "arena", "amount": "episodes"}
        return means_table("places", "By place of the food", note, by, shown, (SCORE, DELIVERED), self.rng)

    def states_table(
        self,
        title: str,
        note: str,
        groups: Sequence[tuple[str, Sequence[tuple[str, Sequence[RecallEpisode]]]]],
        measures: Sequence[Callable[[State], Measure[RecallEpisode]]],
    ) -> Table:
        """Shares of steps, state by state.

        Args:
            title: Heading.
            note: What the table shows.
            groups: For each arena, the recalls there by the name of their condition.
            measures: `spent`, `wrong`, or both.
        """
        lines: list[tuple[Value, ...]] = []
        for arena, conditions in groups:
            for state in STATES:
                for condition, rows in conditions:
                    if state in occurring(rows):
                        shares = (self.mean(rows, measure(state)) for measure in measures)
                        lines.append((arena, state.name, condition, *shares))
        columns = [Column("arena"), Column("state"), Column("condition")]
        columns += [Column(measure(State.SEARCH).name, 1, estimate=True) for measure in measures]
        return Table("states", title, note, tuple(columns), lines)


def claim(name: str, section: str, effect: Estimate, rule: Rule, unit: Unit, sentence: str) -> Claim:
    """A claim with the verdict of its rule on the effect."""
    return judged(name, section, effect, rule, unit, "", sentence)


def conditions_of(rows: Iterable[RowT]) -> list[str]:
    """The conditions that occur, in order."""
    return list(dict.fromkeys(row.condition for row in rows))


def amounts_of(rows: Iterable[RowT], least: int = 1) -> list[int]:
    """The amounts that occur, from `least`."""
    return sorted({row.amount for row in rows if row.amount >= least})


def at(rows: Sequence[RecallEpisode], place: str) -> list[RecallEpisode]:
    """The recalls in the corridor whose food lay at one of `PLACES`."""
    low, high = PLACES[place]
    return [row for row in rows if row.arena == "corridor" and low <= row.beyond < high]


def spent(state: State) -> Measure[RecallEpisode]:
    """Steps in a state, as a share of all steps."""
    return Measure("steps (%)", lambda row: 100.0 * row.rounds_by_state[state], lambda row: float(row.steps))


def wrong(state: State) -> Measure[RecallEpisode]:
    """Steps in a state in which the teacher would have acted differently, as a share of all steps in the state."""
    return Measure(
        "wrong (%)",
        lambda row: 100.0 * row.wrong_by_state[state],
        lambda row: float(row.rounds_by_state[state]),
    )


def occurring(rows: Sequence[RecallEpisode]) -> list[State]:
    """The states that occur in these recalls."""
    return [state for state in STATES if any(row.rounds_by_state[state] for row in rows)]
