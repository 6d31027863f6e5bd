"""What a learner takes from one arena, or from varied ones, to arenas that are new to it, and where its decisions fail.

    python benchmarks/varied_arenas.py --help

Offline imitators learn from training episodes in the corridor, or in procedural arenas of every difficulty, one episode
in each, and forage in the family and in procedural test arenas. Wrong decisions of the thesis's imitator are those that
it would draw along its own recalls, with all attributes of the state vector and without each of them.
"""

import sys
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from itertools import groupby, product
from operator import itemgetter
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray
from threadpoolctl import threadpool_limits

from khepera_forage.comparison.compiled_learning import (
    TrainingData,
    recalls_after,
    settings_at,
    thesis_teacher,
    thinned,
    varied_arenas,
)
from khepera_forage.envs.compiled.vector_env import BehavioursVectorEnv
from khepera_forage.estimates import Estimate, Measure, Value, mean, percent, pick, table_of
from khepera_forage.figures import WIDTH, legend, levels, new_figure, padded
from khepera_forage.policies import NearestNeighbourImitator
from khepera_forage.policies.distance import CORRIDOR_DIAGONAL
from khepera_forage.policies.imitator import WeightedImitator
from khepera_forage.policies.learners import LEARNERS, OfflineImitation
from khepera_forage.sim.arenas.difficulty import DIFFICULTIES
from khepera_forage.sim.arenas.named import FAMILY
from khepera_forage.study import Count, Job, Page, Picture, collect, finish, parse
from khepera_forage.task.decisions import DEFAULT_DECISIONS, Decisions
from khepera_forage.task.states import NUM_BEHAVIOURS, FoodType, StateVector

if TYPE_CHECKING:
    from matplotlib.figure import Figure

COUNTS = (
    Count("replications", 10, 1, "repetitions, each with training episodes and places of its own", adds_units=True),
    Count("recalls", 6, 1, "recalls of each learner in each arena or difficulty"),
    Count("episodes", 10, 2, "training episodes of each learner"),
)
TRAININGS = CORRIDOR, VARIED, THINNED = ("corridor", "varied arenas", "varied arenas, as many vectors")
"""Of the last, as many vectors were drawn as the corridor gave."""
GROUPS = {"family": tuple(FAMILY), "procedural": tuple(DIFFICULTIES)}
IMITATOR, OTHERS = "imitator", ("tree", "boosting", "cloning")
ALONG_PATH = "imitator, distances along the path"
"""Those of the state vector, in training, too."""
JUDGES = ("as it is", *(f"without {attribute}" for attribute in StateVector._fields))


@dataclass(frozen=True, slots=True)
class Recalls:
    """Recalls of one learner in one arena or difficulty.

    Attributes:
        foods: Objects that are not poisonous.
        steps: Of all recalls; 0 for a learner whose decisions are not counted.
        wrong: Steps in which it would draw another behaviour than the teacher's, on average over draws, by `JUDGES`.
        beyond: Of the first of these, those at a distance from home or food greater than all in its experience.
    """

    replication: int
    training: str
    learner: str
    place: str
    delivered: int
    foods: int
    steps: int = 0
    wrong: tuple[float, ...] = ()
    beyond: float = 0.0


def replicate(seed: int, number: int, recalls: int, episodes: int, quick: bool) -> list[Recalls]:
    """All learners after each training, in all places."""
    states = np.random.SeedSequence(seed, spawn_key=(number,))
    key = int(states.generate_state(1)[0]) % 2**31
    places = ("t_maze", "easy") if quick else [place for group in GROUPS.values() for place in group]
    seeds = {place: own.generate_state(recalls).tolist() for place, own in zip(places, states.spawn(10), strict=False)}
    rows = []
    with threadpool_limits(1):
        for name, decisions in ((IMITATOR, DEFAULT_DECISIONS), (ALONG_PATH, Decisions(distances="along the path"))):
            for training, data in _trained(episodes, key, decisions).items():
                rows += [
                    Recalls(number, training, name, place, *_imitate(place, own, data, decisions, key))
                    for place, own in seeds.items()
                ]
        for training, data in _trained(episodes, key).items():
            for name in OTHERS[:1] if quick else OTHERS:
                learner = LEARNERS[name]
                assert isinstance(learner, OfflineImitation)
                for place, done in recalls_after(learner, data, seeds, key, CORRIDOR_DIAGONAL).items():
                    rows.append(
                        Recalls(number, training, name, place, int(done.delivered.sum()), int(done.foods.sum()))
                    )
    return rows


def _trained(episodes: int, key: int, decisions: Decisions = DEFAULT_DECISIONS) -> dict[str, TrainingData]:
    """What is learned from; in the corridor, distances along the path are straight."""
    corridor, varied = thesis_teacher(episodes, key), varied_arenas(episodes, key, decisions)
    return {CORRIDOR: corridor, VARIED: varied, THINNED: thinned(varied, len(corridor.vectors), key)}


def _imitate(
    place: str, seeds: Sequence[int], data: TrainingData, decisions: Decisions, key: int
) -> tuple[int, int, int, tuple[float, ...], float]:
    """The last fields of `Recalls` for the thesis's imitator."""
    vectors, behaviours, _ = data
    judges: list[Any] = [NearestNeighbourImitator().fit(vectors, behaviours)]
    for left_out in range(len(StateVector._fields) if decisions == DEFAULT_DECISIONS else 0):
        weights = [int(attribute != left_out) for attribute in range(len(StateVector._fields))]
        judges.append(WeightedImitator(weights=weights).fit(vectors, behaviours))
    known: dict[tuple[int, ...], NDArray[np.float64]] = {}

    def chances(rows: NDArray[np.int64]) -> list[NDArray[np.float64]]:
        """Of each behaviour, by judge: for each row, the diagonal of an arena and a state vector."""
        keys = list(map(tuple, rows.tolist()))
        for diagonal, group in groupby(sorted(set(keys).difference(known)), key=itemgetter(0)):
            new = list(group)
            found = np.zeros((len(new), len(judges), NUM_BEHAVIOURS))
            for k, judge in enumerate(judges):
                judge.diagonal = diagonal
                found[:, k, judge.classes_] = judge.predict_proba(np.array(new)[:, 1:])
            known.update(zip(new, found, strict=True))
        return [known[key] for key in keys]

    env = BehavioursVectorEnv(len(seeds), **settings_at(place), decisions=decisions)
    shown, infos = env.reset(seed=list(seeds))
    foods = int((env.batch.worlds.objects["type"] != FoodType.POISONOUS).sum())
    furthest, rng = vectors.max(axis=0), np.random.default_rng(key)
    running, delivered, steps, wrong, beyond = np.ones(len(seeds), np.bool_), 0, 0, np.zeros(len(judges)), 0.0
    while running.any():
        seen = np.column_stack([np.ravel(shown[name]) for name in StateVector._fields]).astype(np.int64)
        seen = np.column_stack((env.get_attr("diagonal"), seen))
        actions = np.zeros(len(seeds), np.int64)
        for world, found in zip(np.flatnonzero(running), chances(seen[running]), strict=True):
            actions[world] = rng.choice(NUM_BEHAVIOURS, p=found[0])
            mistaken = 1.0 - found[:, infos["correct_behaviour"][world]]
            far = seen[world, 1:] > furthest
            steps, wrong, beyond = steps + 1, wrong + mistaken, beyond + mistaken[0] * bool(far[1] or far[4])
        shown, _, terminated, truncated, infos = env.step(actions)
        ended = running & (terminated | truncated)
        delivered += int(infos["delivered"][ended].sum())
        running &= ~ended
    return delivered, foods, steps, tuple(wrong.tolist()), beyond


FOOD = Measure[Recalls]("food delivered (%)", lambda row: 100.0 * row.delivered / row.foods)
"""Every arena or difficulty counts alike."""
MOST = "80 % or more in the family (% of trainings)"
BEYOND = Measure[Recalls]("beyond (%)", lambda row: 100.0 * row.beyond, lambda row: row.wrong[0])


def page(rows: Sequence[Recalls], seed: int) -> Page:
    """Food delivered by learner and training, and the imitator's wrong decisions by attribute."""
    foods: list[dict[str, Value]] = []
    wrong: list[dict[str, Value]] = []
    for name, training in product(dict.fromkeys(row.learner for row in rows), TRAININGS):
        own = pick(rows, learner=name, training=training)
        line: dict[str, Value] = {"learner": name, "trained in": training}
        places = {group: [row for row in own if row.place in among] for group, among in GROUPS.items()}
        means = {f"{g} (%)": mean(some, FOOD, np.random.default_rng(seed)) for g, some in places.items()}
        foods.append(line | means | {MOST: _trainings_with_most(places["family"])})
        if name == IMITATOR:
            for k, judge in enumerate(JUDGES):
                share = Measure[Recalls](judge, partial(_share, k), lambda row: row.steps)
                line[f"{judge} (%)"] = mean(own, share, np.random.default_rng(seed))
            wrong.append(line | {BEYOND.name: mean(own, BEYOND, np.random.default_rng(seed))})
    method = "95 % intervals over replications; noise of the laboratory, times 0.5 to 1.5 in procedural arenas."
    return Page(
        "Learned in one arena, or in varied ones",
        [
            Picture("varied_arenas", "food delivered after each training", picture(foods)),
            table_of("food", "Food delivered", f"Every arena or difficulty counts alike. {method}", foods),
            table_of(
                "wrong",
                "Wrong decisions of the imitator",
                "Of all steps of its own recalls, as it is and with one attribute left out; beyond: of those as it is, "
                f"the share at a distance that is greater than all in its experience. {method}",
                wrong,
            ),
        ],
    )


def _trainings_with_most(rows: Sequence[Recalls]) -> Estimate:
    """The share of the trainings after which at least 80 % of the food of these rows is delivered."""
    food = {row.replication: [FOOD.value(one) for one in pick(rows, replication=row.replication)] for row in rows}
    return percent(sum(float(np.mean(each)) >= 80.0 for each in food.values()), len(food))


def _share(judge: int, row: Recalls) -> float:
    return 100.0 * row.wrong[judge]


def picture(lines: Sequence[dict[str, Any]]) -> "Figure":
    """A panel for each group of places."""
    names = dict.fromkeys(line["learner"] for line in lines)
    figure = new_figure(WIDTH, 1.6 + 0.4 * len(names))
    panels = figure.subplots(1, len(GROUPS), sharey=True)
    for axes, group in zip(panels, GROUPS, strict=True):
        shown = {name: [line[f"{group} (%)"] for line in lines if line["learner"] == name] for name in names}
        levels(axes, shown, f"food delivered, {group} (%)", TRAININGS)
        axes.set_xlim(*padded(0, 100))
    legend(figure, panels[0], "trained in; bars: 95 % interval")
    return figure


def main() -> int:
    """Run the benchmark."""
    given = parse("varied_arenas", __doc__, *COUNTS)
    units = [
        Job(f"replication {i}", replicate, (given.seed, i, given.recalls, given.episodes, given.quick))
        for i in range(given.replications)
    ]
    rows = collect(given, units, {Recalls: "recalls"}).of(Recalls)
    return finish(given, page(rows, given.seed))


if __name__ == "__main__":
    sys.exit(main())
