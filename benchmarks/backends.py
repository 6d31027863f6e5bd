"""How well the teacher forages, and whether both backends agree: pymunk, and compiled worlds.

    python benchmarks/backends.py --help

Four parts, of which `--only` selects some. teacher: the teacher in corridor and rectangle with each type of food; with
SEARCH in the place of ORIENT it must deliver nothing. arenas: teacher and imitator in the named and in procedural
arenas. imitators: twenty imitators in corridor and rectangle. trainings: attempts at a training episode. All have the
same seeds on both backends, and so the same random numbers. Needs numba (the extra `fast`).
"""

import math
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from joblib import Parallel, delayed
from numpy.typing import NDArray
from scipy import stats

from khepera_forage.envs.arena_settings import procedural_settings, settings_of
from khepera_forage.envs.behaviours_env import BehavioursEnv
from khepera_forage.envs.training import TrainingEnv
from khepera_forage.estimates import Estimate, Table, Value, holm, percent, pick, quantiles, table_of
from khepera_forage.figures import WIDTH, legend, levels, new_figure
from khepera_forage.policies import NearestNeighbourImitator, Observation, Teacher
from khepera_forage.rollouts.recall import recall
from khepera_forage.rollouts.training import Attempt, arrays, attempt, train
from khepera_forage.sim.arenas.difficulty import DIFFICULTIES
from khepera_forage.sim.arenas.named import FAMILY
from khepera_forage.sim.arenas.thesis import THESIS_ARENAS
from khepera_forage.study import Count, Job, Page, Picture, collect, finish, parse
from khepera_forage.task.states import Behaviour, FoodType, StateVector

COUNTS = (
    Count("forages", 500, 2, "teacher: random starts of each line", adds_units=True),
    Count("levels", 250, 1, "arenas: test levels of each difficulty", adds_units=True),
    Count("recalls", 100, 1, "arenas: recalls in each named arena", adds_units=True),
    Count("episodes", 1_000, 4, "imitators: recalls in each arena", adds_units=True),
    Count("attempts", 1_000, 2, "trainings: attempts in each arena", adds_units=True),
)
ONLY_TEACHER, ARENAS, IMITATORS, TRAININGS = PARTS = ("teacher", "arenas", "imitators", "trainings")
PYMUNK, COMPILED = BACKENDS = ("pymunk", "compiled")
TEACHER, NO_ORIENT, IMITATOR = "teacher", "SEARCH for ORIENT", "imitator"
PICKABLE, PUSHABLE, POISONOUS = "PICKABLE", "PUSHABLE", "POISONOUS"
ONE_THIRD_EACH = "a third each"
ODDS: dict[str, Any] = {ONE_THIRD_EACH: {PICKABLE: 1.0, PUSHABLE: 1.0, POISONOUS: 1.0}}
GOALS = {PICKABLE: 98.0, PUSHABLE: 95.0}
"""Percent of the food that the teacher is to deliver in every arena."""
PROCEDURAL = "all procedural"
EPISODES, SEVERAL, QUICK_SEVERAL = 3, 20, 2
"""Training episodes of an imitator; imitators that take turns, the same on both backends."""
BLOCK = 25
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
    same: bool  # on the other backend: score, steps, food, and rounds and mistakes in each state
    score: float  # equation 5.1, percent
    steps: int
    foods: int
    deliverable: int
    delivered: int
    poison_home: int


@dataclass(frozen=True, slots=True)
class ComparedTraining:
    """One attempt at a training episode on one backend."""

    arena: str
    seed: int
    backend: str
    same: bool  # on the other backend: rounds, separations, and every experience vector
    complete: bool
    rounds: int


class WithoutOrienting(NamedTuple):
    """The teacher with SEARCH FOR FOOD in the place of ORIENT WITH FOOD."""

    teacher: Teacher

    def act(self, observation: Observation, rng: np.random.Generator | None = None) -> Behaviour:
        """The teacher's behaviour, or SEARCH FOR FOOD for ORIENT WITH FOOD."""
        behaviour = self.teacher.act(observation)
        return Behaviour.SEARCH_FOR_FOOD if behaviour == Behaviour.ORIENT_WITH_FOOD else behaviour


def compared_recalls(
    part: str,
    policy: str,
    arena: str,
    level: int,
    food: str,
    first: int,
    seeds: tuple[int, ...],
    imitators: tuple[Vectors, ...] = (),
) -> list[Recall]:
    """Recalls of one policy in one arena with every seed, on both backends. Imitators take turns."""
    if arena in DIFFICULTIES:
        settings = procedural_settings(arena, "test", 1, level)
        settings["arena"] = settings["arena"][0]
    else:
        settings = settings_of(arena)
    settings["food_types"] = ODDS.get(food, food)
    envs = {backend: BehavioursEnv(**settings, backend=backend) for backend in BACKENDS}
    teacher = Teacher.of(envs[PYMUNK])
    policies: list[Any] = [NearestNeighbourImitator(envs[PYMUNK].diagonal).fit(*own) for own in imitators]
    policies = policies or [WithoutOrienting(teacher) if policy == NO_ORIENT else teacher]
    rows = []
    for number, seed in enumerate(seeds, first):
        done = [recall(env, policies[number % len(policies)], seed) for env in envs.values()]
        types = [food.type for food in envs[PYMUNK].forager.food.objects]
        deliverable = len(types) - types.count(FoodType.POISONOUS)
        for backend, row in zip(BACKENDS, done, strict=True):
            about = (part, policy, arena, level, food, seed, backend, done[0] == done[1], row.score)
            rows.append(Recall(*about, row.steps, row.foods, deliverable, row.delivered, row.poison_home))
    for env in envs.values():
        env.close()
    return rows


def compared_trainings(arena: str, seeds: tuple[int, ...]) -> list[ComparedTraining]:
    """Attempts at a training episode with every seed, on both backends."""
    envs = {backend: TrainingEnv(arena=arena, backend=backend) for backend in BACKENDS}
    rows = []
    for seed in seeds:
        done = {backend: _attempted(env, seed) for backend, env in envs.items()}
        same = done[PYMUNK] == done[COMPILED]
        rows += [ComparedTraining(arena, seed, b, same, own.complete, own.rounds) for b, (own, _) in done.items()]
    for env in envs.values():
        env.close()
    return rows


def _attempted(env: TrainingEnv, seed: int) -> tuple[Attempt, list[tuple[StateVector, Behaviour]]]:
    """An attempt, and the learner's experience."""
    experience: list[tuple[StateVector, Behaviour]] = []
    return attempt(env, seed, lambda *heard: experience.append(heard)), experience


def _trained(seed: int, imitator: int) -> Vectors:
    """The experience of an imitator, from training with pymunk."""
    env = TrainingEnv()
    seeds = np.random.SeedSequence(seed, spawn_key=(0, imitator)).spawn(EPISODES)
    files = [train(env, one)[0] for one in seeds]
    env.close()
    return arrays(files)


def work_of(part: str, seed: int, imitators: tuple[Vectors, ...], counts: dict[str, int], quick: bool) -> list[Job]:
    """All units of a part; a quick run has the imitator in three arenas, as it seldom ends before the limit."""

    def recalls(
        policy: str, arena: str, level: int, food: str, first: int, seeds: tuple[int, ...], *own: tuple[Vectors, ...]
    ) -> Job:
        about = (part, policy, arena, level, food, first)
        key = " ".join(map(str, (*about, seeds[0], seeds[-1])))
        return Job(key, compared_recalls, (*about, seeds, *own))

    if part == ARENAS:
        lines = [*((TEACHER, food, ()) for food in (*GOALS, ONE_THIRD_EACH)), (IMITATOR, ONE_THIRD_EACH, imitators[:1])]
        many = tuple(range(seed, seed + counts["recalls"]))
        places = [(arena, 0, many) for arena in FAMILY]
        places += [(arena, i, (seed + i,)) for arena in DIFFICULTIES for i in range(counts["levels"])]
        return [
            recalls(policy, arena, level, food, 0, seeds, own)
            for policy, food, own in lines
            for arena, level, seeds in (places[:3] if quick and policy == IMITATOR else places)
        ]
    work: list[Job] = []
    count = counts[{ONLY_TEACHER: "forages", IMITATORS: "episodes", TRAININGS: "attempts"}[part]]
    for number, arena in enumerate(THESIS_ARENAS):
        drawing = np.random.SeedSequence(seed, spawn_key=(PARTS.index(part), number))
        seeds = drawing.generate_state(count).tolist()
        some = [(i, tuple(seeds[i : i + BLOCK])) for i in range(0, count, BLOCK)]
        if part == TRAININGS:
            work += [Job(f"{part} {arena} {own[0]} {own[-1]}", compared_trainings, (arena, own)) for _, own in some]
        elif part == IMITATORS:
            work += [recalls(IMITATOR, arena, 0, PICKABLE, i, own, imitators) for i, own in some]
        else:
            foods = [(TEACHER, PICKABLE), (TEACHER, PUSHABLE), (TEACHER, POISONOUS), (NO_ORIENT, PICKABLE)]
            work += [recalls(policy, arena, 0, food, i, own) for policy, food in foods for i, own in some]
    return work


def recall_parts(rows: Sequence[Recall]) -> list[str | Table | Picture]:
    """What is delivered on both backends, and which recalls are the same or end differently."""
    groups: dict[tuple[str, str, str], list[Recall]] = {}
    for row in rows:
        groups.setdefault((row.policy, row.food, row.arena), []).append(row)
    for row in rows:
        if row.arena in DIFFICULTIES:
            groups.setdefault((row.policy, row.food, PROCEDURAL), []).append(row)
    delivered: list[dict[str, Value]] = []
    compared: list[dict[str, Value]] = []
    shown: dict[str, list[Estimate]] = {}
    for (policy, food, arena), own in groups.items():
        sides = {backend: pick(own, backend=backend) for backend in BACKENDS}
        shares = {
            b: percent(sum(r.delivered for r in side), sum(r.deliverable for r in side)) for b, side in sides.items()
        }
        goal = GOALS.get(food, math.nan) if policy == TEACHER else math.nan
        met = "" if math.isnan(goal) else "yes" if min(share.value for share in shares.values()) >= goal else "no"
        line: dict[str, Value] = {"policy": policy, "food": food, "arenas": arena}
        delivered.append(
            line
            | {"recalls": len(sides[PYMUNK])}
            | {f"{backend}: delivered (%)": share for backend, share in shares.items()}
            | {"goal (%)": goal, "met": met}
            | {f"{backend}: steps": quantiles([row.steps for row in side]) for backend, side in sides.items()}
            | {"poisonous objects": sum(row.foods - row.deliverable for row in sides[PYMUNK])}
            | {
                f"{backend}: poison brought home": sum(row.poison_home for row in side)
                for backend, side in sides.items()
            }
        )
        if food != POISONOUS and (policy == IMITATOR or arena in THESIS_ARENAS):
            shown[f"{policy}: {food.lower()}, {arena}"] = list(shares.values())
        ends = [[row.delivered == row.deliverable for row in side] for side in sides.values()]
        compared.append(line | agreement([row.same for row in sides[PYMUNK]], *ends))
    figure = new_figure(WIDTH, 1.2 + 0.4 * len(shown))
    axes = figure.subplots()
    levels(axes, shown, "food delivered (%); bars: Wilson's 95 % interval", BACKENDS)
    legend(figure, axes)
    return [
        table_of(
            "deliveries",
            "Food that is delivered",
            "Noise of the laboratory in named arenas, that of the difficulty in procedural ones, with one recall each; "
            "the same seeds on both backends, and for all lines of an arena. Limits are 500 and 700 steps in corridor "
            "and rectangle. Shares: Wilson's 95 % interval, as if objects of one recall were independent. "
            "Steps: median [5th, 95th percentile]. With SEARCH in the place of ORIENT nothing must be delivered. "
            f"Imitators have {EPISODES} training episodes in the corridor.",
            delivered,
            {f"{b}: delivered (%)": 2 for b in BACKENDS} | {f"{b}: steps": 0 for b in BACKENDS} | {"goal (%)": 0},
        ),
        Picture("deliveries", "food delivered on both backends", figure),
        agreement_table("backends", "Recalls that are the same, and that deliver everything", compared),
    ]


def agreement(same: Sequence[bool], *ends: Sequence[bool]) -> dict[str, Value]:
    """How many episodes are the same, and how many succeed on both backends, on one of them, or on none."""
    pairs = list(zip(*ends, strict=True))
    both, fewer, more, neither = (
        pairs.count(end) for end in ((True, True), (True, False), (False, True), (False,) * 2)
    )
    return {
        "episodes": len(pairs),
        "the same (%)": percent(sum(same), len(same)),
        "both": both,
        "pymunk only": fewer,
        "compiled only": more,
        "neither": neither,
        "p": float(stats.binomtest(fewer, fewer + more).pvalue) if fewer + more else 1.0,
    }


def agreement_table(stem: str, title: str, lines: Sequence[dict[str, Value]]) -> Table:
    """A table of `agreement`, with p-values corrected for its lines."""
    corrected = holm([float(str(line["p"])) for line in lines])
    return table_of(
        stem,
        title,
        "The same: every count of the episode is equal on both backends, in trainings every experience vector too. "
        f"p: McNemar's exact test, corrected by Holm's rule for {len(lines)} lines; the backends differ below 0.05.",
        [{**line, "corrected p": p} for line, p in zip(lines, corrected, strict=True)],
        {"p": 3, "corrected p": 3},
    )


def training_table(rows: Sequence[ComparedTraining]) -> Table:
    """Which attempts at a training episode are the same, and which are complete."""
    lines = []
    for arena in dict.fromkeys(row.arena for row in rows):
        sides = [pick(rows, arena=arena, backend=backend) for backend in BACKENDS]
        complete = [[row.complete for row in side] for side in sides]
        lines.append({"arena": arena} | agreement([row.same for row in sides[0]], *complete))
    return agreement_table("trainings", "Attempts at a training episode that are the same, and complete", lines)


def main() -> int:
    """Run the benchmark."""
    given = parse("backends", __doc__, *COUNTS, parts=PARTS)
    chosen, seed = given.parts, given.seed
    imitators: tuple[Vectors, ...] = ()
    if {ARENAS, IMITATORS} & set(chosen):
        numbers = range(QUICK_SEVERAL if given.quick else SEVERAL)
        imitators = tuple(Parallel(n_jobs=given.jobs)(delayed(_trained)(seed, number) for number in numbers))
    work = [unit for part in chosen for unit in work_of(part, seed, imitators, given.counts, given.quick)]
    rows = collect(given, work, {Recall: "recalls", ComparedTraining: "trainings"})
    parts = recall_parts(rows.of(Recall)) if chosen != [TRAININGS] else []
    if TRAININGS in chosen:
        parts.append(training_table(rows.of(ComparedTraining)))
    return finish(given, Page("The teacher, and the two backends", parts))


if __name__ == "__main__":
    sys.exit(main())
