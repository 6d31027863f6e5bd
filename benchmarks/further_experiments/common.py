"""What all experiments have in common: training and recall with the rows that they leave, measures, claims, pages."""

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from copy import copy
from dataclasses import dataclass, replace
from itertools import product, repeat
from textwrap import fill
from typing import TYPE_CHECKING, Any, NamedTuple, TypeVar

import numpy as np

from khepera_forage.envs.arguments import COMPILED
from khepera_forage.envs.behaviours_env import BehavioursEnv
from khepera_forage.envs.training import TrainingEnv
from khepera_forage.estimates import Estimate, Measure, Table, Value, difference, mean, pick, table_of
from khepera_forage.experience import Experience
from khepera_forage.figures import COLOURS, MARKERS, entry, grid, legend, levels, mark, panels
from khepera_forage.policies import NearestNeighbourImitator, Policy
from khepera_forage.rollouts.recall import recall, recall_env
from khepera_forage.rollouts.rows import STATES
from khepera_forage.rollouts.training import IncompleteTrainingError, arrays, train
from khepera_forage.study import Job, Page, Picture
from khepera_forage.task.decisions import DEFAULT_DECISIONS
from khepera_forage.task.states import FoodType, State, behaviour_for, classify
from khepera_forage.thesis.claims import Claim, Rule, Unit, above, points
from khepera_forage.thesis.design import training_distance

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

ARENAS = ("corridor", "rectangle")
MOST_CURVES = 6
"""Conditions in a picture of curves; more have a line each."""
Files = Sequence[Experience]


@dataclass(frozen=True, slots=True)
class EpisodeRow:
    """One complete training episode, with all the attempts it took.

    Attributes:
        replication: Number of the repetition of the whole experiment.
        amount: Number of learners, generation or delay, where the experiment varies one of these; otherwise 1.
        attempts: Up to the complete one.
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
    """One recall episode (5.4); fields that are not explained are those of `RecallRow`.

    Attributes:
        replication: Number of the repetition of the whole experiment.
        amount: Training episodes, or the generation or delay; 0 for a policy that learned nothing.
        seed: Of the episode; the same places for every condition and amount.
        avoided: Objects known to be poisonous and not brought home.
        beyond: Distance of the first object from home minus that in training, in pixels.
        distinct: Different state vectors among them.
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


AS_IN_RECALL_ROW = (
    *("arena", "seed", "score", "correct", "steps", "foods", "delivered", "poison_home"),
    *("rounds_by_state", "wrong_by_state"),
)
Row = EpisodeRow | RecallEpisode
RowT = TypeVar("RowT", bound=EpisodeRow | RecallEpisode)
TABLES = {EpisodeRow: "trainings", RecallEpisode: "recalls"}


def of_food(name: str, number: Callable[[RecallEpisode], int]) -> Measure[RecallEpisode]:
    """Food objects of some kind, as a share of all."""
    return Measure(name, lambda row: 100 * number(row), lambda row: row.foods)


SCORE = Measure[RecallEpisode]("score (%)", lambda row: row.score)
AGREEMENT = Measure[RecallEpisode]("steps as the teacher (%)", lambda row: 100 * row.correct / row.steps)
DELIVERED = of_food("food delivered (%)", lambda row: row.delivered)
SETTLED = of_food("food settled (%)", lambda row: row.delivered + row.avoided)
POISON_HOME = of_food("poison brought home (%)", lambda row: row.poison_home)
STEPS = Measure[RecallEpisode]("steps", lambda row: row.steps, digits=0)
VECTORS = Measure[RecallEpisode]("experience vectors", lambda row: row.vectors, digits=0)
DISTINCT = Measure[RecallEpisode]("different experience vectors", lambda row: row.distinct, digits=0)
ATTEMPTS = Measure[EpisodeRow]("attempts an episode", lambda row: row.attempts, digits=2)
ROUNDS = Measure[EpisodeRow]("rounds of a complete episode", lambda row: row.rounds)
WAITED = Measure[EpisodeRow]("rounds spent waiting", lambda row: row.rounds - row.vectors)
SEPARATIONS = Measure[EpisodeRow]("separations a learner", lambda row: row.separations / row.amount, digits=2)
TRUE = Measure[EpisodeRow](
    "vectors with the teacher's behaviour (%)", lambda row: 100.0 * row.true, lambda row: row.vectors
)
PERCENT = Unit("%", ".1f")
FOOD_POINTS = Unit("points of food delivered", "+.1f")
POSITIVE = above(0.0)

NEARER, ABOUT, FURTHER = "nearer home", "about as in training", "further out"
PLACES = {NEARER: (-math.inf, -5.0), ABOUT: (-5.0, 15.0), FURTHER: (15.0, math.inf)}
"""Where the food lay: pixels beyond the mark of figure 5.1, at least the first number and less than the second."""


def spent(state: State) -> Measure[RecallEpisode]:
    """Steps in a state, as a share of all steps."""
    return Measure("steps (%)", lambda row: 100.0 * row.rounds_by_state[state], lambda row: row.steps)


def wrong(state: State) -> Measure[RecallEpisode]:
    """Steps in a state in which the teacher would have acted differently, as a share of all steps in the state."""
    return Measure("wrong (%)", lambda row: 100.0 * row.wrong_by_state[state], lambda row: row.rounds_by_state[state])


def at(rows: Sequence[RecallEpisode], place: str) -> list[RecallEpisode]:
    """The recalls in the corridor whose food lay at one of `PLACES`."""
    low, high = PLACES[place]
    return [row for row in rows if row.arena == "corridor" and low <= row.beyond < high]


def amounts_of(rows: Iterable[RowT], least: int = 1) -> list[int]:
    """The amounts that occur, from `least`."""
    return sorted({row.amount for row in rows if row.amount >= least})


def by_condition(rows: Sequence[RowT]) -> dict[str, list[RowT]]:
    """The rows of each condition."""
    return {name: pick(rows, condition=name) for name in dict.fromkeys(row.condition for row in rows)}


class ExperimentSize(NamedTuple):
    """How much is done.

    Attributes:
        files: Most training episodes of a learner.
        recalls: Recall episodes of each learner in each arena.
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
    """One condition in one replication."""

    seed: int
    replication: int
    condition: str
    size: ExperimentSize

    def seeds(self, number: int) -> list[np.random.SeedSequence]:
        """Seeds of a replication's first training episodes; the same under every condition."""
        return np.random.SeedSequence(self.seed, spawn_key=(self.replication, 0)).spawn(number)

    def env(self, backend: str = COMPILED, **kwargs: Any) -> TrainingEnv:
        """The paired corridors with the size's time limit."""
        return TrainingEnv(max_cycles=self.size.rounds, backend=backend, **kwargs)

    def alone(self, arena: str, backend: str = COMPILED, **kwargs: Any) -> BehavioursEnv:
        """An arena for recalls with the size's time limit."""
        return recall_env(arena, limit=self.size.steps, backend=backend, **kwargs)

    def by_amount(self, files: Files) -> dict[int, Files]:
        """No files, and the first ones of these, for each of the size's amounts that there are."""
        return {amount: files[:amount] for amount in (0, *self.size.amounts) if amount <= len(files)}


def train_files(
    trial: Trial,
    env: TrainingEnv | None = None,
    seeds: Sequence[np.random.SeedSequence] = (),
    amount: int = 1,
    setups: Iterable[Mapping[str, Any] | None] = repeat(None),
    may_fail: bool = False,
    **how: Any,
) -> tuple[list[Experience], list[EpisodeRow]]:
    """Training episodes, by default as many as the size says, of the teacher of section 4.4, as in figure 5.1.

    An episode that fails in as many attempts as the size allows is an error, or the end, if it `may_fail`. The amount
    is for the rows; `setups` are options of the environment's resets, and `how` are further arguments of `train`.
    """
    env, seeds = env or trial.env(), seeds or trial.seeds(trial.size.files)
    files: list[Experience] = []
    rows: list[EpisodeRow] = []
    for file, (seed, options) in enumerate(zip(seeds, setups, strict=False), 1):
        try:
            experience, attempts = train(env, seed, options=options, attempts=trial.size.attempts, **how)
        except IncompleteTrainingError:
            if may_fail:
                break
            raise
        states = [classify(vector, env.home_radius, env.decisions.values()) for vector in experience.vectors]
        row = EpisodeRow(
            replication=trial.replication,
            condition=trial.condition,
            amount=amount,
            file=file,
            attempts=len(attempts),
            rounds=attempts[-1].rounds,
            all_rounds=sum(row.rounds for row in attempts),
            vectors=len(experience),
            true=sum(behaviour_for(state) == heard for state, (_, heard) in zip(states, experience, strict=True)),
            separations=attempts[-1].separations,
        )
        files.append(experience)
        rows.append(row)
    return files, rows


def imitator(files: Files, diagonal: int, threshold: float = 0.0) -> NearestNeighbourImitator:
    """The thesis's learner with the experience of these files."""
    # A threshold needs exact arithmetic.
    arithmetic = "exact" if threshold else DEFAULT_DECISIONS.distance_arithmetic
    return NearestNeighbourImitator(diagonal, threshold, arithmetic).fit(*arrays(list(files)))


def recall_all(
    env: BehavioursEnv, policy: Policy, trial: Trial, amount: int = 0, files: Files = (), condition: str = ""
) -> list[RecallEpisode]:
    """A replication's recalls in one arena; their places are the same under every condition and for every amount.

    The policy's experience in `files` and the condition, by default the trial's, are for the rows. Every recall has a
    copy of the policy, because some remember what they do.
    """
    vectors = arrays(list(files))[0] if files else np.zeros((0, 5), np.int64)
    distinct = len(np.unique(vectors, axis=0))
    key = (trial.replication, 1, ARENAS.index(env.arena.name))
    seeds = np.random.SeedSequence(trial.seed, spawn_key=key).generate_state(trial.size.recalls).tolist()
    rows = []
    for number, seed in enumerate(seeds):
        row = recall(env, copy(policy), seed)
        poisonous = sum(food.known == FoodType.POISONOUS for food in env.forager.food.objects)
        rows.append(
            RecallEpisode(
                replication=trial.replication,
                condition=condition or trial.condition,
                amount=amount,
                number=number,
                avoided=poisonous - row.poison_home,
                beyond=row.food_home_distances[0] - training_distance(env.decisions),
                vectors=len(vectors),
                distinct=distinct,
                **{name: getattr(row, name) for name in AS_IN_RECALL_ROW},
            )
        )
    return rows


Learner = tuple[str, Policy, Files]
"""Condition (by default the trial's), policy, and the experience that it has."""
Learners = Callable[[BehavioursEnv, Files], Iterable[Learner]]
"""The learners in an arena with some training files, or without any."""


def imitators(env: BehavioursEnv, files: Files, untrained: Policy | None = None) -> Iterator[Learner]:
    """The thesis's learner; without files another policy, if there is one."""
    if files:
        yield "", imitator(files, env.diagonal), files
    elif untrained:
        yield "", untrained, files


def recall_learners(
    trial: Trial,
    experience: Mapping[int, Files],
    learners: Learners = imitators,
    alone: Callable[[str], BehavioursEnv] | None = None,
) -> list[RecallEpisode]:
    """Recalls in both arenas with each amount of experience; `alone` makes the environment of an arena."""
    return [
        row
        for env in map(alone or trial.alone, ARENAS)
        for amount, files in experience.items()
        for condition, policy, own in learners(env, files)
        for row in recall_all(env, policy, trial, amount, own, condition)
    ]


def train_and_recall(
    trial: Trial, learners: Learners = imitators, alone: Callable[[str], BehavioursEnv] | None = None, **training: Any
) -> list[Row]:
    """Train as `train_files`, and recall after each of the size's numbers of training episodes."""
    files, trainings = train_files(trial, **training)
    return [*trainings, *recall_learners(trial, trial.by_amount(files), learners, alone)]


@dataclass(frozen=True, slots=True)
class Analysis:
    """All rows of an experiment. Every interval has the same seed, so that it does not depend on the others."""

    trainings: list[EpisodeRow]
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

    def compared(
        self,
        name: str,
        rows: Sequence[RowT],
        others: Sequence[RowT],
        measure: Measure[RowT],
        rule: Rule = POSITIVE,
        unit: Unit | None = None,
    ) -> Claim:
        """A claim on how much greater a mean is in `rows` than in `others`; by default, that it is greater."""
        usual = FOOD_POINTS if measure == DELIVERED else points
        return Claim(name, "", self.difference(rows, others, measure), rule, unit or usual)

    def means(
        self, stem: str, title: str, means: "Means", rows: Sequence[RowT], by: tuple[str, ...], amount: str
    ) -> Table:
        """A table for every combination of the fields `by`, in the order of the rows, and of the amounts."""
        (note, measures), rng, lines = means, self.rng, list[dict[str, Value]]()
        known = [dict.fromkeys(getattr(row, name) for row in rows) for name in by]
        for *names, count in product(*known, amounts_of(rows, 0)):
            about = dict(zip(by, names, strict=True))
            if own := pick(rows, **about, amount=count):
                values = {measure.name: mean(own, measure, rng) for measure in measures}
                lines.append({**about, amount: count, "rows": len(own), **values})
        return table_of(stem, title, note, lines, {measure.name: measure.digits for measure in measures})

    def places(self) -> list[RecallEpisode]:
        """The recalls in the corridor after most episodes, with the place of the food in their condition."""
        recalls = by_condition(pick(self.recalls, amount=self.amounts[-1]))
        return [
            replace(row, condition=f"{condition}; food {place}")
            for condition, rows in recalls.items()
            for place in PLACES
            for row in at(rows, place)
        ]

    def states_table(
        self,
        note: str,
        groups: Mapping[str, Mapping[str, Sequence[RecallEpisode]]],
        measures: Sequence[Callable[[State], Measure[RecallEpisode]]],
    ) -> Table:
        """`spent`, `wrong` or both, by arena, state and condition; the groups are the recalls of each arena."""
        lines = [
            {"arena": arena, "state": state.name, "condition": condition}
            | {one.name: self.mean(rows, one) for one in (measure(state) for measure in measures)}
            for arena, conditions in groups.items()
            for state in list(State)[:STATES]
            for condition, rows in conditions.items()
            if any(row.rounds_by_state[state] for row in rows)
        ]
        return table_of("states", "By state", note, lines)


Means = tuple[str, Sequence[Measure[Any]]]
"""Note and columns of a table of means."""
BY_PLACE = (
    "Recall in the corridor by how far from home the food lay: more than 5 pixels of 5 mm nearer than the mark of "
    "figure 5.1, at least 15 pixels further out, or between."
)


class Experiment(NamedTuple):
    """One item of the thesis's further work, and how its page is made.

    Attributes:
        section: Of the thesis, where the question stands.
        conditions: One trial each in every replication.
        claims: Each with its verdict.
        picture: Measures that are drawn against the amount, of the recalls in both arenas, if there are any.
        recalls: Means by condition, arena and amount.
        trainings: Means by condition and amount.
        amount: What the amount is, where it is no number of training episodes.
        places: Whether there is a table by place of the food.
        states: The table by state.
    """

    name: str
    title: str
    section: str
    question: str
    method: str
    conditions: tuple[str, ...]
    run: Callable[[Trial], list[Row]]
    claims: Callable[[Analysis], Iterable[Claim]]
    picture: Sequence[Measure[Any]]
    recalls: Means | None = None
    trainings: Means | None = None
    amount: str = ""
    places: bool = False
    states: Callable[[Analysis], Table] | None = None

    def jobs(self, seed: int, replications: int, size: ExperimentSize) -> list[Job]:
        """All work, replication by replication."""
        return [
            Job(f"{number} {condition}", self.run, (Trial(seed, number, condition, size),))
            for number in range(replications)
            for condition in self.conditions
        ]

    def page(self, found: Analysis) -> Page:
        """Question, method, picture, claims and tables."""
        question = f"**{self.question}** (section {self.section} of the thesis)"
        picture = Picture(self.name, self.title, self._figure(found))
        return Page(self.title, [question, self.method, picture, *self._tables(found)])

    def _tables(self, found: Analysis) -> Iterator[Table]:
        lines = [
            {
                "claim": c.name,
                "effect": c.effect,
                **c.estimate._asdict(),
                "rule": c.rule.words(c.unit),
                "verdict": str(c.verdict),
            }
            for c in self.claims(found)
        ]
        note = (
            "The rule of each claim was fixed before there were data. A claim is undecided if its interval reaches "
            "across the threshold, or if there are too few replications for an interval."
        )
        yield table_of("claims", "Claims", note, lines, hidden=Estimate._fields)
        by = ("condition", "arena")
        if self.recalls:
            yield found.means("recalls", "Recall", self.recalls, found.recalls, by, self.amount or "episodes")
        if self.trainings:
            amount = self.amount or "files"
            yield found.means("trainings", "Training", self.trainings, found.trainings, ("condition",), amount)
        if self.places:
            means = BY_PLACE, (SCORE, DELIVERED)
            yield found.means("places", "By place of the food", means, found.places(), by, "episodes")
        if self.states:
            yield self.states(found)

    def _figure(self, found: Analysis) -> "Figure":
        rows: dict[str, Sequence[Row]] = {"": found.trainings}
        if found.recalls:
            rows = {arena: pick(found.recalls, arena=arena) for arena in ARENAS}
        shown = list(product(self.picture, rows))
        figure, axes = panels(len(shown), self.title)
        amount = self.amount or "training episodes"
        conditions = {row.condition for own in rows.values() for row in own}
        for panel, (measure, heading) in zip(axes, shown, strict=True):
            panel.set_title(heading, fontsize=10)
            if len(conditions) > MOST_CURVES:
                draw_levels(panel, found, rows[heading], measure, amount)
                continue
            draw_curves(panel, found, rows[heading], measure)
            panel.set_xlabel(amount)
        columns = min(4, 130 // (max(map(len, conditions)) + 7))  # about as many letters fit in a line
        legend(figure, axes[0], "bars: 95 % interval over replications", columns)
        return figure


def draw_levels(axes: "Axes", found: Analysis, rows: Sequence[Row], measure: Measure[Any], amount: str) -> None:
    """Draw the means of a measure, one line a condition, with marks for none, the least and most of the amount."""
    amounts = [number for number in amounts_of(rows, 0) if number in (0, found.amounts[0], found.amounts[-1])]
    lines = {
        condition: [found.mean(pick(own, amount=number), measure) for number in amounts]
        for condition, own in by_condition(rows).items()
    }
    levels(axes, lines, measure.name, [f"{number} {amount}" for number in amounts])


def draw_curves(axes: "Axes", found: Analysis, rows: Sequence[Row], measure: Measure[Any]) -> None:
    """Draw the mean of a measure against the amount, one curve a condition."""
    conditions, amounts = by_condition(rows), amounts_of(rows, 0)
    for i, (condition, own) in enumerate(conditions.items()):
        # More conditions than colours have other pairs of colour and marker.
        colour, marker = COLOURS[i % len(COLOURS)], MARKERS[(i + i // len(COLOURS)) % len(MARKERS)]
        shift = 0.7 * ((i + 0.5) / len(conditions) - 0.5)
        cells = [(place + shift, pick(own, amount=amount)) for place, amount in enumerate(amounts)]
        means = [(x, found.mean(cell, measure)) for x, cell in cells if cell]
        axes.plot([x for x, _ in means], [estimate.value for _, estimate in means], color=colour, lw=1)
        entry(axes, condition, colour, marker, "-")
        for x, estimate in means:
            mark(axes, x, estimate.value, estimate, colour, marker=marker)
    axes.set_xticks(range(len(amounts)), [str(amount) for amount in amounts])
    axes.set_xlim(-0.5, len(amounts) - 0.5)
    axes.set_ylabel(fill(measure.name, 30))
    grid(axes)
    if measure.name.endswith("(%)"):
        axes.set_ylim(min(-4.0, axes.get_ylim()[0]), 104)  # scores go down to -20
    else:
        highest = max(1.0, axes.get_ylim()[1])
        axes.set_ylim(-0.03 * highest, highest)  # marks at 0 are shown whole
