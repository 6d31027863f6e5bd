"""How well the teacher forages, and whether both backends agree: pymunk, and compiled worlds.

    python benchmarks/backends.py --help

Four parts, of which `--only` selects some. teacher: the teacher in corridor and rectangle with each type of food; with
SEARCH in the place of ORIENT it must deliver nothing. arenas: teacher and imitator in the named and in procedural
arenas. Both have the same seeds on both backends. recalls: independent recalls in corridor and rectangle, compared by
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
    Table,
    Value,
    holm,
    percent,
    pick,
    quantiles,
    replications,
    sums_by_replication,
)
from khepera_forage.figures import OURS, THESIS, WIDTH, grid, legend, levels, new_figure, panels
from khepera_forage.policies import NearestNeighbourImitator, Observation, Teacher
from khepera_forage.policies.memories import memories_of
from khepera_forage.rollouts.compiled import recalls
from khepera_forage.rollouts.recall import recall
from khepera_forage.rollouts.rows import RecallRow
from khepera_forage.rollouts.training import arrays, train
from khepera_forage.sim.arenas.difficulty import DIFFICULTIES
from khepera_forage.sim.arenas.named import FAMILY
from khepera_forage.sim.arenas.thesis import THESIS_ARENAS
from khepera_forage.study import Count, Page, Picture, Rows, WorkUnit, collect, finish, parse
from khepera_forage.task.decisions import DEFAULT_DECISIONS
from khepera_forage.task.states import Behaviour, FoodType
from khepera_forage.thesis.design import THESIS as DESIGN
from khepera_forage.thesis.replication import JobCounts, jobs, replicate
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
KERNELS = {TEACHER: recalls.TEACHER, NO_ORIENT: recalls.WITHOUT_ORIENTING}
"""Policies in the kernel that are not imitators."""
PICKABLE, PUSHABLE, POISONOUS = "PICKABLE", "PUSHABLE", "POISONOUS"
ONE_THIRD_EACH = "a third each"
ODDS: dict[str, Any] = {ONE_THIRD_EACH: {PICKABLE: 1.0, PUSHABLE: 1.0, POISONOUS: 1.0}}
GOALS = {PICKABLE: 98.0, PUSHABLE: 95.0}
"""Percent of the food that the teacher is to deliver in every arena."""
PROCEDURAL = "all procedural"
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
    """One recall on one backend, and how many of its food objects became what."""

    part: str  # of `PARTS`
    policy: str
    arena: str  # or a difficulty
    level: int  # of a procedural arena
    food: str  # type of all food, or `a third each`
    seed: int
    backend: str
    score: float  # equation 5.1, percent
    steps: int
    foods: int
    deliverable: int
    delivered: int
    poison_home: int


class WithoutOrienting(NamedTuple):
    """The teacher with SEARCH FOR FOOD in the place of ORIENT WITH FOOD."""

    teacher: Teacher

    def act(self, observation: Observation, rng: np.random.Generator | None = None) -> Behaviour:
        """The teacher's behaviour, or SEARCH FOR FOOD for ORIENT WITH FOOD."""
        behaviour = self.teacher.act(observation)
        return Behaviour.SEARCH_FOR_FOOD if behaviour == Behaviour.ORIENT_WITH_FOOD else behaviour


class Block(NamedTuple):
    """Recalls of one policy in one arena, with pymunk, and compiled but for `RECALLS`. Imitators take turns."""

    part: str
    policy: str
    arena: str
    level: int
    food: str
    first: int
    seeds: tuple[int, ...]
    imitators: tuple[Vectors, ...] = ()

    @property
    def key(self) -> str:
        """What is done, and the first and the last seed."""
        return " ".join(map(str, (*self[:6], self.seeds[0], self.seeds[-1])))

    def run(self) -> list[Recall]:
        """Recall with every seed."""
        settings = settings_of(self.arena) if self.arena not in DIFFICULTIES else {}
        if not settings:
            settings = procedural_settings(self.arena, "test", 1, self.level)
            settings["arena"] = settings["arena"][0]
        settings["food_types"] = ODDS.get(self.food, self.food)
        env = BehavioursEnv(**settings)
        teacher = Teacher.of(env)
        policies: list[Any] = [NearestNeighbourImitator(env.diagonal).fit(*own) for own in self.imitators]
        policies = policies or [WithoutOrienting(teacher) if self.policy == NO_ORIENT else teacher]
        rows = []
        for number, seed in enumerate(self.seeds, self.first):
            row = recall(env, policies[number % len(policies)], seed, learner=self.policy)
            deliverable = sum(food.type != FoodType.POISONOUS for food in env.forager.food.objects)
            counts = row.steps, row.foods, deliverable, row.delivered, row.poison_home
            rows.append(Recall(*self[:5], seed, PYMUNK, row.score, *counts))
        env.close()
        return rows if self.part == RECALLS else [*rows, *self._compiled(settings, rows)]

    def _compiled(self, settings: dict[str, Any], rows: Sequence[Recall]) -> list[Recall]:
        """The same seeds compiled: the same places and types of the food."""
        which = np.full(len(rows), KERNELS.get(self.policy, 0))
        memories = memories_of(self.imitators) if self.imitators else None
        done = recalls.run_recalls(settings.pop("arena"), memories, which, np.array(self.seeds, np.int64), **settings)
        names = ("score", "steps", "delivered", "poison_home")
        columns = [getattr(done, name).tolist() for name in names]
        return [
            replace(row, backend=COMPILED, **dict(zip(names, values, strict=True)))
            for row, *values in zip(rows, *columns, strict=True)
        ]


class PymunkReplication(NamedTuple):
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
        return Rows(replicate(self.seed, self.number, 1, cells=cells)).of(RecallRow)


def _trained(seed: int, imitator: int) -> Vectors:
    """The experience of an imitator, from training with pymunk."""
    env = TrainingEnv()
    seeds = np.random.SeedSequence(seed, spawn_key=(0, imitator)).spawn(TRAININGS)
    files = [train(env, one)[0] for one in seeds]
    env.close()
    return arrays(files)


def blocks(part: str, seed: int, imitators: tuple[Vectors, ...], counts: dict[str, int]) -> list[Block]:
    """All recalls of a part."""
    if part == ARENAS:
        lines: list[tuple[str, str, tuple[Vectors, ...]]]
        lines = [(TEACHER, food, ()) for food in (*GOALS, ONE_THIRD_EACH)]
        lines += [(IMITATOR, ONE_THIRD_EACH, imitators[:1])]
        many = tuple(range(seed, seed + counts["recalls"]))
        places = [(arena, 0, many) for arena in FAMILY]
        places += [(arena, i, (seed + i,)) for arena in DIFFICULTIES for i in range(counts["levels"])]
        return [
            Block(part, policy, arena, level, food, 0, seeds, own)
            for policy, food, own in lines
            for arena, level, seeds in places
        ]
    work, of_teacher = [], part == ONLY_TEACHER
    lines_of = [(TEACHER, PICKABLE), (TEACHER, PUSHABLE), (TEACHER, POISONOUS), (NO_ORIENT, PICKABLE)]
    for number, arena in enumerate(THESIS_ARENAS):
        for line, (policy, food) in enumerate(lines_of if of_teacher else [(p, PICKABLE) for p in (TEACHER, IMITATOR)]):
            key = (number,) if of_teacher else (1, 2 * number + line)
            count = counts["forages" if of_teacher else "episodes"]
            seeds = np.random.SeedSequence(seed, spawn_key=key).generate_state(count).tolist()
            own = imitators * (policy == IMITATOR)
            work += [
                Block(part, policy, arena, 0, food, i, tuple(seeds[i : i + BLOCK]), own) for i in range(0, count, BLOCK)
            ]
    return work


def paired_parts(rows: Sequence[Recall]) -> list[str | Table | Picture]:
    """Recalls with the same seeds on both backends: what is delivered, and which end differently."""
    groups: dict[tuple[str, str, str], list[Recall]] = {}
    for row in rows:
        groups.setdefault((row.policy, row.food, row.arena), []).append(row)
    for row in rows:
        if row.arena in DIFFICULTIES:
            groups.setdefault((row.policy, row.food, PROCEDURAL), []).append(row)
    delivered: list[tuple[Value, ...]] = []
    tested: list[tuple[Value, ...]] = []
    shown: dict[str, list[Estimate]] = {}
    for (policy, food, arena), own in groups.items():
        sides = [pick(own, backend=backend) for backend in BACKENDS]
        shares = [percent(sum(r.delivered for r in side), sum(r.deliverable for r in side)) for side in sides]
        goal = GOALS.get(food, math.nan) if policy == TEACHER else math.nan
        met = "" if math.isnan(goal) else "yes" if min(share.value for share in shares) >= goal else "no"
        poison = [sum(r.foods - r.deliverable for r in sides[0]), *(sum(r.poison_home for r in s) for s in sides)]
        steps = [quantiles([row.steps for row in side]) for side in sides]
        delivered.append((policy, food, arena, len(sides[0]), *shares, goal, met, *steps, *poison))
        if food != POISONOUS and (policy == IMITATOR or arena in THESIS_ARENAS):
            shown[f"{policy}: {food.lower()}, {arena}"] = shares
        ends = list(zip(*([r.delivered == r.deliverable for r in side] for side in sides), strict=True))
        counts = [ends.count(end) for end in ((True, True), (True, False), (False, True), (False, False))]
        fewer, more = counts[1:3]
        p = float(stats.binomtest(fewer, fewer + more).pvalue) if fewer + more else 1.0
        tested.append((policy, food, arena, *counts, p))
    corrected = holm([float(str(line[-1])) for line in tested])
    figure = new_figure(WIDTH, 1.2 + 0.4 * len(shown))
    axes = figure.subplots()
    levels(axes, shown, "food delivered (%); bars: Wilson's 95 % interval", BACKENDS)
    legend(figure, axes)
    names = tuple(map(Column, ("policy", "food", "arenas")))
    shares_of = (Column(f"{backend}: delivered (%)", 2, estimate=True) for backend in BACKENDS)
    steps_of = (Column(f"{backend}: steps", 0, estimate=True) for backend in BACKENDS)
    home = (Column(f"{backend}: poison brought home") for backend in BACKENDS)
    ends_of = map(Column, ("both", "pymunk only", "compiled only", "neither"))
    return [
        Table(
            "deliveries",
            "Food that is delivered",
            "Noise of the laboratory in named arenas, that of the difficulty in procedural ones, with one recall each; "
            "the same seeds on both backends, and for all lines of an arena. Limits are 500 and 700 steps in corridor "
            "and rectangle. Shares: Wilson's 95 % interval, as if objects of one recall were independent. "
            "Steps: median [5th, 95th percentile]. With SEARCH in the place of ORIENT nothing must be delivered. The "
            f"imitator has {TRAININGS} training episodes in the corridor.",
            (
                *(*names, Column("recalls"), *shares_of, Column("goal (%)", 0), Column("met"), *steps_of),
                *(Column("poisonous objects"), *home),
            ),
            delivered,
        ),
        Picture("deliveries", "food delivered on both backends", figure),
        Table(
            "backends",
            "Recalls that deliver everything",
            "Noise is drawn independently on the two backends. p: McNemar's exact test, corrected by Holm's rule for "
            f"the {len(tested)} lines; the backends differ below 0.05.",
            (*names, *ends_of, Column("p", 3), Column("corrected p", 3)),
            [(*line, p) for line, p in zip(tested, corrected, strict=True)],
        ),
    ]


def compared(a: Floats, b: Floats) -> tuple[Value, ...]:
    """Means with 95 % intervals, their difference, and p of Welch's and of the Kolmogorov-Smirnov test."""

    def around(value: float, half: float) -> Estimate:
        return Estimate(value, value - half, value + half)

    means = [around(float(x.mean()), 1.96 * float(x.std(ddof=1)) / math.sqrt(len(x))) for x in (a, b)]
    value = float(b.mean() - a.mean())
    change, p = around(value, 0.0), float(value == 0.0)
    parts = a.var(ddof=1) / len(a), b.var(ddof=1) / len(b)
    if spread := math.sqrt(sum(parts)):  # otherwise all values of a sample are equal
        freedom = sum(parts) ** 2 / (parts[0] ** 2 / (len(a) - 1) + parts[1] ** 2 / (len(b) - 1))
        change = around(value, float(stats.t.ppf(1 - LEVEL / 2, freedom)) * spread)
        p = float(2 * stats.t.sf(abs(value) / spread, freedom))
    same = float(stats.ks_2samp(a, b, method="asymp").pvalue)
    return *means, change, p, same


def tested_table(stem: str, title: str, lines: Sequence[tuple[Value, ...]], note: str) -> Table:
    """Policy, arena, measure and what `compared` returns, with p-values corrected for all tests of the table."""
    corrected = np.reshape(holm([float(str(p)) for line in lines for p in line[-2:]]), (-1, 2)).tolist()
    rows = [(*line, *ps) for line, ps in zip(lines, corrected, strict=True)]
    found = [" ".join(map(str, row[:3])) for row in rows if min(map(float, map(str, row[-2:]))) < LEVEL]
    verdict = f"Differences: {', '.join(found)}." if found else "No test detects a difference."
    columns = (
        *map(Column, ("policy", "arena", "measure")),
        *(Column(name, 2, estimate=True) for name in (*BACKENDS, "difference")),
        *(Column(name, 3) for name in ("p of means", "p of distributions")),
        *(Column(f"corrected: {name}", 3) for name in ("means", "distributions")),
    )
    text = (
        f"{note} Brackets: 95 % intervals. Means: Welch's test. Distributions: Kolmogorov-Smirnov test, whose p-value "
        f"is too large for counts with many ties, never too small. {2 * len(rows)} tests. {verdict}"
    )
    return Table(stem, title, text, columns, rows)


def recall_parts(
    rows: Sequence[Recall], seed: int, imitators: tuple[Vectors, ...], episodes: int
) -> list[str | Table | Picture]:
    """Independent recalls on both backends, and two-sample tests."""
    lines: list[tuple[Value, ...]] = []
    figure, axes = panels(2 * len(CONDITIONS), "Recalls on both backends")
    count = COMPILED_FACTOR * episodes
    for number, (policy, arena) in enumerate(CONDITIONS):
        key = np.random.SeedSequence(seed, spawn_key=(2, number, 0)).generate_state(1)
        which = np.arange(count) % len(imitators) if policy == IMITATOR else np.full(count, recalls.TEACHER)
        memories = memories_of(imitators) if policy == IMITATOR else None
        done = recalls.run_recalls(memories=memories, memory_of_episode=which, seed=int(key[0]), **settings_of(arena))
        for place, measure in enumerate(("score", "steps", "delivered")):
            a = np.array([getattr(row, measure) for row in pick(rows, policy=policy, arena=arena)], np.float64)
            b = getattr(done, measure).astype(np.float64)
            lines.append((policy, arena, measure, *compared(a, b)))
            if measure != "delivered":
                panel = axes[2 * number + place]
                for values, backend, colour in ((a, PYMUNK, THESIS), (b, COMPILED, OURS)):
                    panel.ecdf(values, color=colour, lw=1.2, label=backend)
                panel.set_title(f"{policy} in the {arena}", fontsize=10)
                panel.set_xlabel("score (%)" if measure == "score" else "steps of a recall", fontsize=9)
                panel.set_ylabel("share of recalls\nup to the value", fontsize=9)
                grid(panel, "both")
    legend(figure, axes[0])
    note = (
        "Noise of the laboratory, the thesis's food and limits, independent random starts; ten times as many recalls "
        f"compiled. Imitators of {TRAININGS} training episodes take turns, the same on both backends."
    )
    return [tested_table("agreement", "Corridor and rectangle", lines, note), Picture("agreement", "", figure)]


def design_table(pymunk: Sequence[RecallRow], seed: int, experiments: int) -> Table:
    """The thesis's experiments on both backends."""
    made = jobs(seed, JobCounts(DESIGN_FACTOR * experiments), DEFAULT_DECISIONS, COMPILED)
    compiled = Rows(row for job in made for row in job.run()).of(RecallRow)
    measures = {"score (%)": "score", "food": "delivered", "steps": "steps", "vectors": "experience_size"}
    lines: list[tuple[Value, ...]] = []
    for cell in DESIGN:
        for name, field in measures.items():
            means = []
            for rows in (in_cell(pymunk, cell), in_cell(compiled, cell)):
                sums = sums_by_replication(rows, replications(rows), attrgetter(field), lambda _: 1.0)
                means.append(sums[:, 0] / sums[:, 1])
            lines.append((f"imitator, {cell.episodes} episodes", cell.arena, name, *compared(*means)))
    note = (
        "Replications of the thesis's design, each with training files of its own backend; twenty times as many "
        "compiled. Score, food and steps: per recall. Vectors: in the imitator's experience. Intervals are over "
        "replications."
    )
    return tested_table("experiments", "The thesis's experiments", lines, note)


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
    units: list[WorkUnit] = [
        unit for part in chosen if part != EXPERIMENTS for unit in blocks(part, seed, imitators, given.counts)
    ]
    if EXPERIMENTS in chosen:
        units += [PymunkReplication(seed, number, given.quick) for number in range(given.experiments)]
    rows = collect(given, units, {Recall: "recalls", RecallRow: "experiments"})
    parts: list[str | Table | Picture] = []
    if {ONLY_TEACHER, ARENAS} & set(chosen):
        parts += paired_parts([row for row in rows.of(Recall) if row.part != RECALLS])
    if RECALLS in chosen:
        parts += recall_parts(pick(rows.of(Recall), part=RECALLS), seed, imitators, given.episodes)
    if EXPERIMENTS in chosen:
        parts.append(design_table(rows.of(RecallRow), seed, given.experiments))
    return finish(given, Page("The teacher, and the two backends", parts))


if __name__ == "__main__":
    sys.exit(main())
