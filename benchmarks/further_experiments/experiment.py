"""What all experiments have in common: trials, their rows, measures of these, claims, curves and a page."""

import math
import textwrap
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, NamedTuple, TypeVar

import numpy as np

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
from khepera_forage.figures import COLOURS, MARKERS, entry, grid, mark
from khepera_forage.study import Page, Picture
from khepera_forage.task.states import State
from khepera_forage.thesis.claims import Claim, Rule, Unit

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


@dataclass(frozen=True, slots=True)
class TrainingEpisode:
    """One complete training episode, with all the attempts it took.

    Attributes:
        replication: Number of the repetition of the whole experiment.
        condition: Of the experiment.
        amount: Number of learners, generation or delay, where the experiment varies one of these; otherwise 1.
        file: Number of the experience file.
        attempts: Up to the complete one.
        rounds: MultiSteps of the complete attempt.
        all_rounds: MultiSteps of all attempts.
        vectors: Experience vectors recorded in the complete attempt.
        true: Vectors among them whose behaviour the teacher of section 4.4 would have chosen on the same state vector.
        separations: Separations in the complete attempt, of all learners together.
    """

    replication: int
    condition: str
    amount: int
    file: int
    attempts: int
    rounds: int
    all_rounds: int
    vectors: int
    true: int
    separations: int


@dataclass(frozen=True, slots=True)
class RecallEpisode:
    """One recall episode (5.4).

    Attributes:
        replication: Number of the repetition of the whole experiment.
        condition: Of the experiment.
        arena: `corridor` or `rectangle`.
        amount: Training episodes, or the generation or delay; 0 for a policy that learned nothing.
        number: Of the recall.
        seed: Of the episode; the same places for every condition and amount.
        score: Equation 5.1, in percent.
        correct: Steps in which the learner did what the teacher would have done.
        steps: Steps taken.
        foods: Food objects in the arena.
        delivered: Objects brought home, poison not counted.
        avoided: Objects known to be poisonous and not brought home.
        poison_home: Poisonous objects brought home.
        beyond: Distance of the first object from home minus that in training, in pixels.
        vectors: Experience vectors of the learner.
        distinct: Different state vectors among them.
        rounds_by_state: Steps in each of the ten states, as the teacher would classify them.
        wrong_by_state: Steps of each state in which the learner did not do what the teacher would have done.
    """

    replication: int
    condition: str
    arena: str
    amount: int
    number: int
    seed: int
    score: float
    correct: int
    steps: int
    foods: int
    delivered: int
    avoided: int
    poison_home: int
    beyond: float
    vectors: int
    distinct: int
    rounds_by_state: tuple[int, ...]
    wrong_by_state: tuple[int, ...]


Row = TrainingEpisode | RecallEpisode
RowT = TypeVar("RowT", TrainingEpisode, RecallEpisode)
TABLES = {TrainingEpisode: "trainings", RecallEpisode: "recalls"}

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
INTERVALS = "bars: 95 % interval over replications"
EPISODES = "training episodes"

NEARER, ABOUT, FURTHER = "nearer home", "about as in training", "further out"
PLACES = {NEARER: (-math.inf, -5.0), ABOUT: (-5.0, 15.0), FURTHER: (15.0, math.inf)}
"""Where the food lay: pixels beyond the mark of figure 5.1, at least the first number and less than the second."""


class Size(NamedTuple):
    """How much is done.

    Attributes:
        files: Most training episodes of a learner.
        recalls: Recall episodes of each learner in each arena.
        generations: Of a chain.
        attempts: At a training episode, before the experiment gives it up.
        patience: Attempts at a training episode, after which a simulated person gives up. An assumption, not measured.
        steps: Time limit of a recall; by default that of its arena.
        rounds: Time limit of an attempt at a training episode.
    """

    files: int = 10
    recalls: int = 4
    generations: int = 5
    attempts: int = 100
    patience: int = 5
    steps: int | None = None
    rounds: int = 600

    @property
    def amounts(self) -> tuple[int, ...]:
        """Numbers of training episodes after which a learner is tested: the thesis's numbers below `files`, and all."""
        return (*(n for n in (1, 3, 5, 10) if n < self.files), self.files)


class Trial(NamedTuple):
    """One condition in one replication: a unit of work."""

    work: Callable[["Trial"], list[Row]]
    seed: int
    replication: int
    condition: str
    size: Size

    @property
    def key(self) -> str:
        """Replication and condition."""
        return f"{self.replication} {self.condition}"

    def run(self) -> list[Row]:
        """Train, recall, and return the rows."""
        return self.work(self)


@dataclass(frozen=True, slots=True)
class Analysis:
    """All rows of an experiment. Every interval has the same seed, so that it does not depend on the others."""

    trainings: list[TrainingEpisode]
    recalls: list[RecallEpisode]
    seed: int

    @property
    def amounts(self) -> list[int]:
        """The amounts of recall episodes, from 1."""
        return amounts_of(self.recalls)

    @property
    def rng(self) -> np.random.Generator:
        """Draws the resamples of one interval, or of one table."""
        return np.random.default_rng(self.seed)

    def mean(self, rows: Sequence[RowT], measure: Measure[RowT]) -> Estimate:
        """A mean with its interval."""
        return mean(rows, measure, self.rng)

    def difference(self, rows: Sequence[RowT], others: Sequence[RowT], measure: Measure[RowT]) -> Estimate:
        """How much greater a mean is in `rows` than in `others`."""
        return difference(rows, others, measure, self.rng)

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
        note: str,
        groups: Sequence[tuple[str, Sequence[tuple[str, Sequence[RecallEpisode]]]]],
        measures: Sequence[Callable[[State], Measure[RecallEpisode]]],
    ) -> Table:
        """`spent`, `wrong` or both, by arena, state and condition; the groups are the recalls of each arena."""
        lines: list[tuple[Value, ...]] = [
            (arena, state.name, condition, *(self.mean(rows, measure(state)) for measure in measures))
            for arena, conditions in groups
            for state in State
            for condition, rows in conditions
            if state in occurring(rows)
        ]
        columns = [Column("arena"), Column("state"), Column("condition")]
        columns += [Column(measure(State.SEARCH).name, 1, estimate=True) for measure in measures]
        return Table("states", "By state", note, tuple(columns), lines)


class Report(NamedTuple):
    """Claims with their verdicts, the values behind them, and the picture."""

    claims: Sequence[Claim]
    tables: Sequence[Table]
    figure: "Figure"


@dataclass(frozen=True, slots=True)
class Experiment:
    """One item of the thesis's further work.

    Attributes:
        name: For `--only` and file names.
        title: Heading of its page.
        section: Of the thesis, where the question stands.
        question: Under test.
        method: How it is tested.
        conditions: One trial each in every replication.
        run: Does one trial.
        report: Turns all rows into a report.
    """

    name: str
    title: str
    section: str
    question: str
    method: str
    conditions: tuple[str, ...]
    run: Callable[[Trial], list[Row]]
    report: Callable[[Analysis], Report]

    def trials(self, seed: int, replications: int, size: Size) -> list[Trial]:
        """All work, replication by replication."""
        return [
            Trial(self.run, seed, number, condition, size)
            for number in range(replications)
            for condition in self.conditions
        ]

    def page(self, found: Analysis) -> Page:
        """Question, method, picture, claims and tables."""
        report = self.report(found)
        claims = Table(
            "claims",
            "Claims",
            "The rule of each claim was fixed before there were data. A claim is undecided if its interval reaches "
            "across the threshold, or if there are too few replications for an interval.",
            (
                *map(Column, ("claim", "effect")),
                *(Column(name, page=False) for name in ("value", "low", "high")),
                *map(Column, ("rule", "verdict")),
            ),
            [
                (
                    c.name,
                    c.effect,
                    c.estimate.value,
                    c.estimate.low,
                    c.estimate.high,
                    c.rule.words(c.unit),
                    str(c.verdict),
                )
                for c in report.claims
            ],
        )
        question = f"**{self.question}** (section {self.section} of the thesis)"
        picture = Picture(self.name, self.title, report.figure)
        return Page(self.title, [question, self.method, picture, claims, *report.tables])


def claim(name: str, effect: Estimate, rule: Rule, unit: Unit) -> Claim:
    """A claim with the verdict of its rule on the effect."""
    return Claim(name, "", effect, rule, unit)


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
    known = [state for state in State if state != State.UNKNOWN]
    return [state for state in known if any(row.rounds_by_state[state] for row in rows)]


def curves(
    axes: "Axes",
    found: Analysis,
    rows: Sequence[RowT],
    measure: Measure[RowT],
    amount: str,
    title: str = "",
    share: bool = True,
    amounts: Sequence[int] = (),
) -> None:
    """Draw the mean of a measure against the amount, one curve a condition.

    Args:
        axes: Where.
        found: Computes the means.
        rows: All that are shown.
        measure: What is shown.
        amount: Label of the amounts.
        title: Of the panel.
        share: Whether the measure goes from 0 to 100.
        amounts: That are shown, with rows or without; empty for those that occur.
    """
    conditions, amounts = conditions_of(rows), amounts or amounts_of(rows, 0)
    for i, condition in enumerate(conditions):
        colour, marker = COLOURS[i % len(COLOURS)], MARKERS[i % len(MARKERS)]
        shift = 0.12 * (i - (len(conditions) - 1) / 2)
        points = [
            (place + shift, found.mean(cell, measure))
            for place, count in enumerate(amounts)
            if (cell := pick(rows, condition=condition, amount=count))
        ]
        axes.plot([x for x, _ in points], [e.value for _, e in points], color=colour, lw=1)
        entry(axes, condition, colour, marker, "-")
        for x, estimate in points:
            mark(axes, x, estimate.value, estimate, colour, marker=marker)
    axes.set_xticks(range(len(amounts)), [str(count) for count in amounts])
    axes.set_xlim(-0.5, len(amounts) - 0.5)
    axes.set_xlabel(amount)
    axes.set_ylabel(textwrap.fill(measure.name, 30))
    axes.set_title(title, fontsize=10)
    grid(axes)
    if share:
        axes.set_ylim(min(-4.0, axes.get_ylim()[0]), 104)  # scores go down to -20
    else:
        highest = max(1.0, axes.get_ylim()[1])
        axes.set_ylim(-0.03 * highest, highest)  # marks at 0 are shown whole
