"""How well the teacher forages, and whether both backends agree: pymunk, and compiled worlds.

    python benchmarks/backends.py --help

Four parts, of which `--only` selects some. teacher: the teacher alone in corridor and rectangle with each type of food;
with SEARCH in the place of ORIENT it must deliver nothing. arenas: teacher and imitator in the named and in procedural
arenas, the same seeds on both backends. recalls: independent recalls of both in corridor and rectangle, compared by
two-sample tests. design: the thesis's experiments, training included. Needs numba (the extra `fast`).
"""

import argparse
import math
import sys
from collections.abc import Sequence
from dataclasses import dataclass, replace
from operator import attrgetter
from typing import Any, NamedTuple

import numpy as np
from joblib import Parallel, delayed
from numpy.typing import NDArray
from scipy import stats

from khepera_forage.envs.arena_settings import procedural_settings, settings_of
from khepera_forage.envs.behaviours_env import BehavioursEnv
from khepera_forage.envs.training import TrainingEnv
from khepera_forage.estimates import (
    Column,
    Estimate,
    Measure,
    Table,
    Value,
    difference,
    holm,
    mean,
    percent,
    pick,
    quantiles,
    replications,
    sums_by_replication,
)
from khepera_forage.figures import (
    OURS,
    SMALL,
    THESIS,
    WIDTH,
    entry,
    grid,
    legend,
    levels,
    mark,
    new_figure,
    panels,
)
from khepera_forage.policies import NearestNeighbourImitator, Observation, Teacher
from khepera_forage.policies.memories import memories_of
from khepera_forage.rollouts.compiled import recalls
from khepera_forage.rollouts.recall import recall
from khepera_forage.rollouts.rows import RecallRow
from khepera_forage.rollouts.training import arrays, train
from khepera_forage.sim.arenas.difficulty import DIFFICULTIES
from khepera_forage.sim.arenas.named import FAMILY
from khepera_forage.sim.arenas.thesis import THESIS_ARENAS
from khepera_forage.study import Count, Page, Picture, Rows, Unit, collect, finish, parse
from khepera_forage.task.decisions import DEFAULT_DECISIONS
from khepera_forage.task.food_tracking import is_finished
from khepera_forage.task.states import Behaviour, FoodType
from khepera_forage.thesis.design import THESIS as DESIGN
from khepera_forage.thesis.replication import JobCounts, compiled_jobs, replicate
from khepera_forage.thesis.tables import in_cell

COUNTS = (
    Count("forages", 500, 15, "teacher: random starts of each line", adds_units=True),
    Count("levels", 250, 1, "arenas: test levels of each difficulty", adds_units=True),
    Count("recalls", 100, 1, "arenas: recalls in each named arena", adds_units=True),
    Count("episodes", 3_000, 20, "recalls: with pymunk, of each condition", adds_units=True, least=2),
    Count("experiments", 48, 2, "design: replications with pymunk", adds_units=True, least=2),
)
ONLY_TEACHER, ARENAS, RECALLS, EXPERIMENTS = PARTS = ("teacher", "arenas", "recalls", "design")
PYMUNK, COMPILED = BACKENDS = ("pymunk", "compiled")
TEACHER, NO_ORIENT, IMITATOR = "teacher", "SEARCH for ORIENT", "imitator"
PICKABLE, PUSHABLE, POISONOUS = (
    kind.name for kind in (FoodType.PICKABLE, FoodType.PUSHABLE, FoodType.POISONOUS)
)
ONE_THIRD_EACH = "a third each"
ODDS: dict[str, Any] = {
    PICKABLE: FoodType.PICKABLE,
    PUSHABLE: FoodType.PUSHABLE,
    ONE_THIRD_EACH: {FoodType.PICKABLE: 1.0, FoodType.PUSHABLE: 1.0, FoodType.POISONOUS: 1.0},
}
GOALS = {PICKABLE: 98.0, PUSHABLE: 95.0}
"""Percent of the food that the teacher is to deliver in every arena."""
GROUPS, PROCEDURAL = (*FAMILY, *DIFFICULTIES), "all procedural"
TRAININGS, IMITATORS, QUICK_IMITATORS = 3, 20, 5
"""Training episodes of an imitator; imitators that take turns, the same on both backends."""
COMPILED_FACTOR, DESIGN_FACTOR = 10, 20
"""Compiled recalls, and compiled replications, for each one with pymunk."""
BLOCK, LEVEL = 25, 0.05
CONDITIONS = tuple((policy, arena) for arena in THESIS_ARENAS for policy in (TEACHER, IMITATOR))
QUICK_DESIGN = tuple(replace(cell, subsets=cell.subsets[:2], recalls=1) for cell in DESIGN)
Floats = NDArray[np.float64]
Vectors = tuple[NDArray[np.int64], NDArray[np.int64]]
"""State vectors and behaviours that an imitator learns from."""


@dataclass(frozen=True, slots=True)
class Recall:
    """One recall on one backend.

    Attributes:
        part: A name of `PARTS`.
        policy: `teacher`, `SEARCH for ORIENT` or `imitator`.
        arena: A named arena, or a difficulty.
        level: Of a procedural arena; 0 in named ones.
        food: Type of all food, or `a third each`.
        seed: Of the episode.
        backend: `pymunk` or `compiled`.
        score: Equation 5.1, percent.
        steps: Until all food was delivered or known to be poisonous, or the limit was reached.
        foods: Food objects.
        deliverable: Those that are not poisonous.
        delivered: Those that were brought home.
        poison_home: Poisonous food brought home.
        left: Food known to be poisonous and left where it was; not known of compiled recalls.
        finished: Whether all food was delivered or known to be poisonous within the limit.
    """

    part: str
    policy: str
    arena: str
    level: int
    food: str
    seed: int
    backend: str
    score: float
    steps: int
    foods: int
    deliverable: int
    delivered: int
    poison_home: int
    left: int | None
    finished: bool

    @property
    def replication(self) -> int:
        """Intervals resample procedural arenas; of a single arena, recalls."""
        return self.seed if self.arena in FAMILY else self.level


DELIVERED = Measure[Recall]("delivered (%)", lambda row: 100.0 * row.delivered, lambda row: row.deliverable)


class WithoutOrienting(NamedTuple):
    """The teacher with SEARCH FOR FOOD in the place of ORIENT WITH FOOD."""

    teacher: Teacher

    def act(self, observation: Observation, rng: np.random.Generator | None = None) -> Behaviour:
        """The teacher's behaviour, or SEARCH FOR FOOD for ORIENT WITH FOOD."""
        behaviour = self.teacher.act(observation)
        return Behaviour.SEARCH_FOR_FOOD if behaviour == Behaviour.ORIENT_WITH_FOOD else behaviour


class Block(NamedTuple):
    """Recalls of one policy in one arena, with pymunk, and compiled where `both`. Imitators take turns."""

    part: str
    policy: str
    arena: str
    level: int
    food: str
    first: int
    seeds: tuple[int, ...]
    imitators: tuple[Vectors, ...] = ()
    both: bool = False

    @property
    def key(self) -> str:
        """What is done, and the first and the last seed."""
        return " ".join(map(str, (*self[:6], self.seeds[0], self.seeds[-1])))

    def run(self) -> list[Recall]:
        """Recall with every seed."""
        settings = {**_settings(self.arena, self.level), "food_types": ODDS.get(self.food, self.food)}
        env = BehavioursEnv(**settings)
        teacher = Teacher.of(env)
        policies: dict[int, Any] = {-1: teacher if self.policy != NO_ORIENT else WithoutOrienting(teacher)}
        rows = []
        for number, seed in enumerate(self.seeds, self.first):
            which = number % len(self.imitators) if self.imitators else -1
            if which not in policies:
                policies[which] = NearestNeighbourImitator(env.diagonal).fit(*self.imitators[which])
            row = recall(env, policies[which], seed, learner=self.policy)
            foods = env.forager.tracker.foods
            known = sum(food.known == FoodType.POISONOUS for food in foods)
            rows.append(
                Recall(
                    *(*self[:5], seed, PYMUNK, row.score, row.steps, row.foods),
                    sum(food.type != FoodType.POISONOUS for food in foods),
                    *(row.delivered, row.poison_home, known - row.poison_home),
                    is_finished(env.forager.tracker),
                )
            )
        env.close()
        return rows + (self._compiled(settings, rows) if self.both else [])

    def _compiled(self, settings: dict[str, Any], rows: Sequence[Recall]) -> list[Recall]:
        """The same seeds compiled: the same places and types of the food."""
        policies = np.full(len(rows), 0 if self.imitators else recalls.TEACHER)
        memories = memories_of(self.imitators[:1]) if self.imitators else None
        more = {name: value for name, value in settings.items() if name != "arena"}
        done = recalls.run_recalls(
            settings["arena"], memories, policies, np.array(self.seeds, np.int64), **more
        )
        columns = (done.score, done.steps, done.delivered, done.poison_home, done.penalty == 0)
        return [
            replace(
                row,
                backend=COMPILED,
                score=score,
                steps=steps,
                delivered=delivered,
                poison_home=home,
                left=None,
                finished=finished,
            )
            for row, score, steps, delivered, home, finished in zip(
                rows, *(column.tolist() for column in columns), strict=True
            )
        ]


class Experiment(NamedTuple):
    """One replication of the thesis's design with pymunk: training files, and recalls in every cell."""

    seed: int
    number: int
    quick: bool

    @property
    def key(self) -> str:
        """Number of the replication."""
        return f"design {self.number}"

    def run(self) -> Sequence[RecallRow]:
        """Train, and return the recalls."""
        cells = QUICK_DESIGN if self.quick else DESIGN
        return Rows(replicate(self.seed, self.number, cells=cells)).of(RecallRow)


def _settings(arena: str, level: int) -> dict[str, Any]:
    if arena not in DIFFICULTIES:
        return settings_of(arena)
    settings = procedural_settings(arena, "test", 1, level)
    return {**settings, "arena": settings["arena"][0]}


def _trained(seed: int, imitator: int) -> Vectors:
    """The experience of an imitator, from training with pymunk."""
    env = TrainingEnv()
    seeds = np.random.SeedSequence(seed, spawn_key=(0, imitator)).spawn(TRAININGS)
    files = [train(env, one)[0] for one in seeds]
    env.close()
    return arrays(files)


def blocks(part: str, seed: int, imitators: tuple[Vectors, ...], counts: dict[str, int]) -> list[Block]:
    """All recalls of a part with pymunk."""
    work = []
    if part == ONLY_TEACHER:
        foods = ((PICKABLE, TEACHER), (PUSHABLE, TEACHER), (POISONOUS, TEACHER), (PICKABLE, NO_ORIENT))
        for number, arena in enumerate(THESIS_ARENAS):
            starts = (
                np.random.SeedSequence(seed, spawn_key=(number,)).generate_state(counts["forages"]).tolist()
            )
            for food, policy in foods:
                for i in range(0, len(starts), BLOCK):
                    work.append(Block(part, policy, arena, 0, food, i, tuple(starts[i : i + BLOCK])))
    elif part == RECALLS:
        for number, (policy, arena) in enumerate(CONDITIONS):
            key = np.random.SeedSequence(seed, spawn_key=(1, number))
            seeds, own = key.generate_state(counts["episodes"]).tolist(), imitators * (policy == IMITATOR)
            for i in range(0, len(seeds), BLOCK):
                work.append(Block(part, policy, arena, 0, PICKABLE, i, tuple(seeds[i : i + BLOCK]), own))
    elif part == ARENAS:
        lines = [(TEACHER, food, ()) for food in ODDS] + [(IMITATOR, ONE_THIRD_EACH, imitators[:1])]
        for policy, food, own in lines:
            many = tuple(range(seed, seed + counts["recalls"]))
            work += [Block(part, policy, arena, 0, food, 0, many, own, True) for arena in FAMILY]
            work += [
                Block(part, policy, arena, level, food, 0, (seed + level,), own, True)
                for arena in DIFFICULTIES
                for level in range(counts["levels"])
            ]
    return work


def teacher_parts(rows: Sequence[Recall]) -> list[str | Table | Picture]:
    """Shares and steps of the teacher alone."""
    own: dict[tuple[str, str, str], list[Recall]] = {}
    for row in rows:
        own.setdefault((row.arena, row.food, row.policy), []).append(row)

    def shares(group: Sequence[Recall]) -> tuple[Estimate, Estimate]:
        foods, delivered = sum(row.foods for row in group), sum(row.delivered for row in group)
        return percent(delivered, foods), percent(delivered + sum(row.left or 0 for row in group), foods)

    lines = [
        (
            *(*names, len(group), sum(row.foods for row in group), *shares(group)),
            percent(sum(row.finished for row in group), len(group)),
            sum(row.poison_home for row in group),
            quantiles([row.steps for row in group]),
        )
        for names, group in own.items()
    ]
    note = (
        "pymunk; noise of the laboratory; the thesis's limits of 500 and 700 steps; the same random starts for every "
        "line of an arena. Shares: Wilson's 95 % interval, as if two objects in one arena were independent. Settled: "
        "delivered, or known to be poisonous and left. Finished: all food is settled, or poison was brought home. "
        "Steps: median [5th, 95th percentile]. The lines without ORIENT are a check: they must deliver nothing."
    )
    shown = ("food delivered (%)", "food settled (%)", "forages finished (%)")
    columns = (
        *map(Column, ("arena", "food", "policy", "forages", "food objects")),
        *(Column(name, estimate=True) for name in shown),
        Column("poison brought home"),
        Column("steps", digits=0, estimate=True),
    )
    figure = new_figure(WIDTH, 1.1 + 0.42 * len(own))
    left, right = figure.subplots(1, 2, sharey=True)
    for place, ((_, food, policy), group) in enumerate(reversed(own.items())):
        colour, marker = (THESIS, "s") if policy == NO_ORIENT else (OURS, "o")
        for axes, value in (
            (left, shares(group)[food == POISONOUS]),
            (right, quantiles([row.steps for row in group])),
        ):
            mark(axes, value.value, place, value, colour, level=True, marker=marker)
    left.set_yticks(range(len(own)), [f"{arena}, {food.lower()} food" for arena, food, _ in reversed(own)])
    left.tick_params(labelsize=SMALL)
    left.set_ylim(-0.6, len(own) - 0.4)
    left.set_xlim(-4, 104)
    left.set_xlabel("food delivered, poison left alone (%)\nbars: Wilson's 95 % interval", fontsize=9)
    right.set_xlim(left=0)
    right.set_xlabel("steps of a forage (median)\nbars: 5th to 95th percentile", fontsize=9)
    entry(left, "teacher", OURS, "o")
    entry(left, "teacher that searches in place of orienting", THESIS, "s")
    for axes in (left, right):
        grid(axes, "x")
    legend(figure, left)
    picture = Picture("teacher", "food delivered and steps of a forage", figure)
    return [Table("teacher", "The teacher alone", note, columns, lines), picture]


def arena_parts(rows: Sequence[Recall], rng: np.random.Generator) -> list[str | Table | Picture]:
    """Food delivered in every arena, poison, and recalls that end differently on the two backends."""

    def sides(policy: str, food: str) -> list[tuple[str, list[Recall], list[Recall]]]:
        line = pick(rows, policy=policy, food=food)
        groups = [(group, pick(line, arena=group)) for group in GROUPS]
        groups.append((PROCEDURAL, [row for row in line if row.arena in DIFFICULTIES]))
        return [(group, pick(own, backend=PYMUNK), pick(own, backend=COMPILED)) for group, own in groups]

    delivered: list[tuple[Value, ...]] = []
    for food, goal in GOALS.items():
        for group, *both in sides(TEACHER, food):
            shares = [mean(side, DELIVERED, rng) for side in both]
            medians = [float(np.median([row.steps for row in side])) for side in both]
            met = "yes" if min(share.value for share in shares) >= goal else "no"
            delivered.append((food, group, *shares, goal, met, *medians))
    names = ("deliverable", "delivered", "poisonous", "poison_home")
    poison: list[tuple[Value, ...]] = []
    for group, *both in sides(TEACHER, ONE_THIRD_EACH):
        for backend, side in zip(BACKENDS, both, strict=True):
            foods, deliverable = sum(row.foods for row in side), sum(row.deliverable for row in side)
            delivered_home = sum(row.delivered for row in side)
            home = sum(row.poison_home for row in side)
            poison.append((group, backend, deliverable, delivered_home, foods - deliverable, home))
    tested: list[tuple[Value, ...]] = []
    for food in ODDS:
        for group, *both in sides(TEACHER, food):
            ends = [[row.delivered == row.deliverable for row in side] for side in both]
            pairs = list(zip(*ends, strict=True))
            counts = [
                pairs.count(end) for end in ((True, True), (True, False), (False, True), (False, False))
            ]
            fewer, more = counts[1:3]
            p = float(stats.binomtest(fewer, fewer + more).pvalue) if fewer + more else 1.0
            tested.append((food, group, *counts, p))
    corrected = holm([float(str(line[-1])) for line in tested])
    imitator: list[tuple[Value, ...]] = []
    shown: dict[str, list[Estimate]] = {}
    for group, one, other in sides(IMITATOR, ONE_THIRD_EACH):
        shown[group] = [mean(side, DELIVERED, rng) for side in (one, other)]
        imitator.append((group, *shown[group], difference(other, one, DELIVERED, rng)))
    figure = new_figure(WIDTH, 1.2 + 0.4 * len(shown))
    axes = figure.subplots()
    levels(axes, shown, "food delivered by the imitator (%)", BACKENDS)
    legend(figure, axes)
    two = [Column(f"{backend}: delivered (%)", 2, estimate=True) for backend in BACKENDS]
    ends_of = ("both", "pymunk only", "compiled only", "neither")
    return [
        Table(
            "deliveries",
            "Food that the teacher delivers",
            "Noise of the laboratory in named arenas, that of the difficulty in procedural ones, with one recall in "
            "each; the same seeds on both backends. Brackets: 95 % intervals, over arenas, or over recalls in one.",
            (
                *map(Column, ("food", "arenas")),
                *(*two, Column("goal (%)", 0), Column("met")),
                *(Column(f"{backend}: median steps", 0) for backend in BACKENDS),
            ),
            delivered,
        ),
        Table(
            "poison",
            "Poisonous food",
            "Food objects of all recalls of the teacher, when each is of any type with equal odds.",
            tuple(map(Column, ("arenas", "backend", *names[:3], "poison brought home"))),
            poison,
        ),
        Table(
            "backends",
            "Recalls of the teacher that deliver everything",
            "Noise is drawn independently on the two backends. p: McNemar's exact test, corrected by Holm's rule for "
            f"the {len(tested)} lines; the backends differ below 0.05.",
            (*map(Column, ("food", "arenas", *ends_of)), Column("p", 3), Column("corrected p", 3)),
            [(*line, p) for line, p in zip(tested, corrected, strict=True)],
        ),
        Table(
            "imitator",
            "Food that the imitator delivers",
            f"One imitator of {TRAININGS} training episodes in the corridor, food {ONE_THIRD_EACH}; the same seeds.",
            (Column("arenas"), *two, Column("compiled minus pymunk (points)", 2, estimate=True)),
            imitator,
        ),
        Picture("imitator", "food delivered by the imitator in every arena, on both backends", figure),
    ]


def welch(a: Floats, b: Floats) -> tuple[Estimate, float]:
    """Mean of b minus mean of a with its 95 % interval, and the p-value of Welch's test."""
    value = float(b.mean() - a.mean())
    parts = a.var(ddof=1) / len(a), b.var(ddof=1) / len(b)
    spread = math.sqrt(sum(parts))
    if spread == 0.0:  # all values of a sample are equal
        return Estimate(value, value, value), 1.0 if value == 0.0 else 0.0
    freedom = sum(parts) ** 2 / (parts[0] ** 2 / (len(a) - 1) + parts[1] ** 2 / (len(b) - 1))
    half = float(stats.t.ppf(1 - LEVEL / 2, freedom)) * spread
    return Estimate(value, value - half, value + half), float(2 * stats.t.sf(abs(value) / spread, freedom))


def mean_of(values: Floats) -> Estimate:
    """The mean with its 95 % interval."""
    value, half = float(values.mean()), 1.96 * float(values.std(ddof=1)) / math.sqrt(len(values))
    return Estimate(value, value - half, value + half)


def recall_parts(
    rows: Sequence[Recall], seed: int, imitators: tuple[Vectors, ...], episodes: int
) -> list[str | Table | Picture]:
    """Independent recalls on both backends, and two-sample tests."""
    lines: list[tuple[Value, ...]] = []
    figure, axes = panels(2 * len(CONDITIONS), "Recalls on both backends")
    for number, (policy, arena) in enumerate(CONDITIONS):
        key = np.random.SeedSequence(seed, spawn_key=(2, number, 0)).generate_state(1)
        count = COMPILED_FACTOR * episodes
        which = np.arange(count) % len(imitators) if policy == IMITATOR else np.full(count, recalls.TEACHER)
        memories = memories_of(imitators) if policy == IMITATOR else None
        settings = settings_of(arena)
        more = {name: value for name, value in settings.items() if name != "arena"}
        done = recalls.run_recalls(arena, memories, which, int(key[0]), **more)
        own = pick(rows, policy=policy, arena=arena)
        for measure in ("score", "steps", "delivered"):
            a = np.array([getattr(row, measure) for row in own], np.float64)
            b = getattr(done, measure).astype(np.float64)
            change, p = welch(a, b)
            same = float(stats.ks_2samp(a, b, method="asymp").pvalue)
            lines.append((policy, arena, measure, mean_of(a), mean_of(b), change, p, same))
            if measure != "delivered":
                panel = axes[2 * number + (measure == "score")]
                for values, backend, colour in ((a, PYMUNK, THESIS), (b, COMPILED, OURS)):
                    panel.ecdf(values, color=colour, lw=1.2, label=backend)
                panel.set_title(f"{policy} in the {arena}", fontsize=10)
                panel.set_xlabel("score (%)" if measure == "score" else "steps of a recall", fontsize=9)
                panel.set_ylabel("share of recalls\nup to the value", fontsize=9)
                grid(panel, "both")
    legend(figure, axes[0])
    return [
        _tested("agreement", "Corridor and rectangle", lines, 3, _RECALLS),
        Picture("agreement", "", figure),
    ]


_RECALLS = (
    "Noise of the laboratory, the thesis's food and limits, independent random starts; ten times as many recalls "
    f"compiled. Imitators of {TRAININGS} training episodes take turns, the same on both backends. Distributions: "
    "Kolmogorov-Smirnov test, whose p-value is too large for counts with many ties, never too small."
)
_DESIGN = (
    "Replications of the thesis's design, each with training files of its own backend; twenty times as many compiled. "
    "Score, food and steps: per recall. Vectors: in the imitator's experience. Intervals are over replications."
)


def _tested(stem: str, title: str, lines: Sequence[tuple[Value, ...]], names: int, note: str) -> Table:
    """Means on both backends, with p-values corrected by Holm's rule for all tests of the table."""
    tests = len(lines[0]) - names - 3
    ps = holm([float(str(p)) for line in lines for p in line[-tests:]])
    rows = [(*line, *ps[tests * i : tests * (i + 1)]) for i, line in enumerate(lines)]
    found = [
        " ".join(map(str, row[:names])) for row in rows if min(map(float, map(str, row[-tests:]))) < LEVEL
    ]
    verdict = f"Differences: {', '.join(found)}." if found else "No test detects a difference."
    of = ("means", "distributions")[:tests]
    columns = (
        *map(
            Column,
            ("policy", "arena", "measure") if names == 3 and tests == 2 else ("arena", "episodes", "measure"),
        ),
        *(Column(name, 2, estimate=True) for name in (*BACKENDS, "difference")),
        *(Column(f"p of {name}" if tests == 2 else "p", 3) for name in of),
        *(Column(f"corrected: {name}" if tests == 2 else "corrected p", 3) for name in of),
    )
    text = f"{note} Brackets: 95 % intervals. Means: Welch's test. {len(ps)} tests. {verdict}"
    return Table(stem, title, text, columns, rows)


def design_table(pymunk: Sequence[RecallRow], seed: int, experiments: int) -> Table:
    """The thesis's experiments on both backends."""
    jobs = compiled_jobs(seed, JobCounts(DESIGN_FACTOR * experiments), DEFAULT_DECISIONS)
    compiled = Rows(row for job in jobs for row in job.run()).of(RecallRow)
    measures = {"score (%)": "score", "food": "delivered", "steps": "steps", "vectors": "experience_size"}
    lines: list[tuple[Value, ...]] = []
    for cell in DESIGN:
        for name, field in measures.items():
            means = []
            for rows in (in_cell(pymunk, cell), in_cell(compiled, cell)):
                sums = sums_by_replication(rows, replications(rows), attrgetter(field), lambda _: 1.0)
                means.append(sums[:, 0] / sums[:, 1])
            lines.append((cell.arena, cell.episodes, name, *map(mean_of, means), *welch(*means)))
    return _tested("experiments", "The thesis's experiments", lines, 3, _DESIGN)


def _add_arguments(parser: argparse.ArgumentParser) -> None:
    text = "one part; may be given several times (all)"
    parser.add_argument("--only", action="append", choices=PARTS, help=text)


def main() -> int:
    """Run the benchmark."""
    given = parse("backends", __doc__, *COUNTS, add=_add_arguments)
    chosen, seed = [part for part in PARTS if part in (given.only or PARTS)], given.seed
    imitators: tuple[Vectors, ...] = ()
    if {ARENAS, RECALLS} & set(chosen):
        numbers = range(QUICK_IMITATORS if given.quick else IMITATORS)
        imitators = tuple(Parallel(n_jobs=given.jobs)(delayed(_trained)(seed, number) for number in numbers))
    units: list[Unit] = [unit for part in chosen for unit in blocks(part, seed, imitators, given.counts)]
    if EXPERIMENTS in chosen:
        units += [Experiment(seed, number, given.quick) for number in range(given.experiments)]
    rows = collect(given, units, {Recall: "recalls", RecallRow: "experiments"})
    parts: list[str | Table | Picture] = []
    for part in chosen:
        own = pick(rows.of(Recall), part=part)
        if part == ONLY_TEACHER:
            parts += teacher_parts(own)
        elif part == ARENAS:
            parts += arena_parts(own, np.random.default_rng(seed))
        elif part == RECALLS:
            parts += recall_parts(own, seed, imitators, given.episodes)
        else:
            parts.append(design_table(rows.of(RecallRow), seed, given.experiments))
    return finish(given, Page("The teacher, and the two backends", parts))


if __name__ == "__main__":
    sys.exit(main())
