"""What all experiments have in common: training and recall with the rows that they leave, measures, claims, pages."""

import math
import textwrap
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from copy import copy
from dataclasses import dataclass, replace
from itertools import product, repeat
from typing import TYPE_CHECKING, Any, NamedTuple, TypeVar

import numpy as np

from khepera_forage.envs.arguments import COMPILED, PYMUNK
from khepera_forage.envs.behaviours_env import BehavioursEnv
from khepera_forage.envs.training import TrainingEnv
from khepera_forage.estimates import Estimate, Measure, Table, Value, difference, mean, pick, table_of
from khepera_forage.experience import Experience
from khepera_forage.figures import COLOURS, MARKERS, entry, grid, legend, mark, panels
from khepera_forage.policies import NearestNeighbourImitator, Policy
from khepera_forage.rollouts.recall import recall, recall_env
from khepera_forage.rollouts.training import arrays, train
from khepera_forage.study import Job, Page, Picture
from khepera_forage.task.decisions import DEFAULT_DECISIONS
from khepera_forage.task.states import FoodType, State, behaviour_for, classify
from khepera_forage.thesis.claims import Claim, Rule, Unit, above, points
from khepera_forage.thesis.design import training_distance

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

ARENAS = ("corridor", "rectangle")
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
RowT = TypeVar("RowT", EpisodeRow, RecallEpisode)
TABLES = {EpisodeRow: "trainings", RecallEpisode: "recalls"}

SCORE = Measure[RecallEpisode]("score (%)", lambda row: row.score)
AGREEMENT = Measure[RecallEpisode]("steps as the teacher (%)", lambda row: 100 * row.correct / row.steps)
DELIVERED = Measure[RecallEpisode]("food delivered (%)", lambda row: 100 * row.delivered, lambda row: row.foods)
SETTLED = Measure[RecallEpisode](
    "food settled (%)", lambda row: 100 * (row.delivered + row.avoided), lambda row: row.foods
)
POISON_HOME = Measure[RecallEpisode](
    "poison brought home (%)", lambda row: 100 * row.poison_home, lambda row: row.foods
)
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
UNITS = {DELIVERED.name: FOOD_POINTS}
"""Of differences; points by default."""
INTERVALS = "bars: 95 % interval over replications"
EPISODES = "training episodes"

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


def occurring(rows: Sequence[RecallEpisode]) -> list[State]:
    """The states that occur in these recalls."""
    known = [state for state in State if state != State.UNKNOWN]
    return [state for state in known if any(row.rounds_by_state[state] for row in rows)]


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

    def env(self, **kwargs: Any) -> TrainingEnv:
        """The paired corridors with the size's time limit."""
        backend = PYMUNK if "world" in kwargs else COMPILED
        return TrainingEnv(max_cycles=self.size.rounds, backend=backend, **kwargs)

    def alone(self, arena: str, **kwargs: Any) -> BehavioursEnv:
        """An arena for recalls with the size's time limit."""
        backend = PYMUNK if "world" in kwargs else COMPILED
        return recall_env(arena, limit=self.size.steps, backend=backend, **kwargs)


def train_files(
    env: TrainingEnv,
    trial: Trial,
    seeds: Sequence[np.random.SeedSequence],
    amount: int = 1,
    teacher: Policy | None = None,
    setups: Iterable[Mapping[str, Any] | None] = repeat(None),
    callback: Callable[[], object] | None = None,
) -> Iterator[tuple[Experience, EpisodeRow]]:
    """Training episodes, one a seed; by default of the teacher of section 4.4, in the set-up of figure 5.1.

    Raises:
        IncompleteTrainingError: One episode failed in as many attempts as the size allows.
    """
    radius, decisions = env.home_radius, env.decisions.values()
    for file, (seed, options) in enumerate(zip(seeds, setups, strict=False), 1):
        experience, attempts = train(
            env, seed, teacher=teacher, options=options, attempts=trial.size.attempts, callback=callback
        )
        chosen = [behaviour_for(classify(vector, radius, decisions)) for vector, _ in experience]
        yield (
            experience,
            EpisodeRow(
                replication=trial.replication,
                condition=trial.condition,
                amount=amount,
                file=file,
                attempts=len(attempts),
                rounds=attempts[-1].rounds,
                all_rounds=sum(row.rounds for row in attempts),
                vectors=len(experience),
                true=sum(own == heard for own, (_, heard) in zip(chosen, experience, strict=True)),
                separations=attempts[-1].separations,
            ),
        )


def all_files(
    trial: Trial, env: TrainingEnv | None = None, seeds: Sequence[np.random.SeedSequence] = (), **how: Any
) -> tuple[list[Experience], list[EpisodeRow]]:
    """All episodes of `train_files`; by default as many as the size says."""
    trained = list(train_files(env or trial.env(), trial, seeds or trial.seeds(trial.size.files), **how))
    return [experience for experience, _ in trained], [row for _, row in trained]


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


def recall_imitators(env: BehavioursEnv, trial: Trial, files: Files) -> list[RecallEpisode]:
    """Recalls of the thesis's learner after every number of training episodes for which there are files."""
    return [
        row
        for amount in trial.size.amounts
        if amount <= len(files)
        for row in recall_all(env, imitator(files[:amount], env.diagonal), trial, amount, files[:amount])
    ]


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
        rule: Rule = above(0.0),  # noqa: B008 (never changed)
        unit: Unit | None = None,
    ) -> Claim:
        """A claim on how much greater a mean is in `rows` than in `others`; by default, that it is greater."""
        effect = self.difference(rows, others, measure)
        return Claim(name, "", effect, rule, unit or UNITS.get(measure.name, points))

    def recall_table(self, note: str, measures: Sequence[Measure[RecallEpisode]], amount: str = "episodes") -> Table:
        """Means by condition, arena and amount."""
        return self._means_table("recalls", "Recall", note, self.recalls, measures, ("condition", "arena"), amount)

    def training_table(self, note: str, measures: Sequence[Measure[EpisodeRow]], amount: str = "files") -> Table:
        """Means by condition and amount."""
        return self._means_table("trainings", "Training", note, self.trainings, measures, ("condition",), amount)

    def places_table(self, amount: int) -> Table:
        """Score and food delivered of every condition after some number of episodes, by where the food lay."""
        shown = [
            replace(row, condition=f"{condition}; food {place}")
            for condition in dict.fromkeys(row.condition for row in self.recalls)
            for place in PLACES
            for row in at(pick(self.recalls, condition=condition, amount=amount), place)
        ]
        note = (
            "Recall in the corridor by how far from home the food lay: more than 5 pixels of 5 mm nearer than the mark "
            "of figure 5.1, at least 15 pixels further out, or between."
        )
        by, measures = ("condition", "arena"), (SCORE, DELIVERED)
        return self._means_table("places", "By place of the food", note, shown, measures, by, "episodes")

    def _means_table(
        self,
        stem: str,
        title: str,
        note: str,
        rows: Sequence[RowT],
        measures: Sequence[Measure[RowT]],
        by: tuple[str, ...],
        amount: str,
    ) -> Table:
        """Means for every combination of the fields `by`, in the order of the rows, and of the amounts."""
        rng, lines = self.rng, list[dict[str, Value]]()
        known = [dict.fromkeys(getattr(row, name) for row in rows) for name in by]
        for *names, count in product(*known, amounts_of(rows, 0)):
            about = dict(zip(by, names, strict=True))
            if own := pick(rows, **about, amount=count):
                means = {measure.name: mean(own, measure, rng) for measure in measures}
                lines.append({**about, amount: count, "rows": len(own), **means})
        return table_of(stem, title, note, lines, {measure.name: measure.digits for measure in measures})

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
            for state in State
            for condition, rows in conditions.items()
            if state in occurring(rows)
        ]
        return table_of("states", "By state", note, lines)


Report = tuple[Sequence[Claim], Sequence[Table], "Figure"]
"""Claims with their verdicts, the values behind them, and the picture."""


class Experiment(NamedTuple):
    """One item of the thesis's further work.

    Attributes:
        section: Of the thesis, where the question stands.
        conditions: One trial each in every replication.
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

    def jobs(self, seed: int, replications: int, size: ExperimentSize) -> list[Job]:
        """All work, replication by replication."""
        return [
            Job(f"{number} {condition}", self.run, (Trial(seed, number, condition, size),))
            for number in range(replications)
            for condition in self.conditions
        ]

    def page(self, found: Analysis) -> Page:
        """Question, method, picture, claims and tables."""
        claims, tables, figure = self.report(found)
        table = table_of(
            "claims",
            "Claims",
            "The rule of each claim was fixed before there were data. A claim is undecided if its interval reaches "
            "across the threshold, or if there are too few replications for an interval.",
            [
                {
                    "claim": c.name,
                    "effect": c.effect,
                    **c.estimate._asdict(),
                    "rule": c.rule.words(c.unit),
                    "verdict": str(c.verdict),
                }
                for c in claims
            ],
            hidden=Estimate._fields,
        )
        question = f"**{self.question}** (section {self.section} of the thesis)"
        picture = Picture(self.name, self.title, figure)
        return Page(self.title, [question, self.method, picture, table, *tables])


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

    `amount` is the label of the amounts. `share` says whether the measure goes from 0 to 100. `amounts` are shown with
    rows or without; by default those that occur.
    """
    conditions = list(dict.fromkeys(row.condition for row in rows))
    amounts = amounts or amounts_of(rows, 0)
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


def score_and_food(found: Analysis, title: str, second: Measure[RecallEpisode] = DELIVERED) -> "Figure":
    """Score and another measure in each arena, against the number of training episodes."""
    figure, axes = panels(4, title)
    for i, arena in enumerate(ARENAS):
        own = pick(found.recalls, arena=arena)
        curves(axes[2 * i], found, [row for row in own if row.amount], SCORE, EPISODES, arena)
        curves(axes[2 * i + 1], found, own, second, EPISODES, arena)
    legend(figure, axes[0], INTERVALS)
    return figure
