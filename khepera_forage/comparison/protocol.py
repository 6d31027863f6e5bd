"""The protocol `forage-bench-1`: four tracks on which learners of this task are compared, with room above all of them.

Everything that a result depends on is here and in `compiled_learning`: tracks, amounts, places, seeds, budgets. It does
not change; another protocol gets another name. `docs/protocol.md` describes it.
"""

import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import count
from time import perf_counter
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from threadpoolctl import threadpool_limits

from khepera_forage.comparison import PROTOCOL
from khepera_forage.comparison import TRACKS as TRACK_NAMES
from khepera_forage.comparison.compiled_learning import (
    PLACES,
    Budget,
    Foraged,
    Seeds,
    TrainingData,
    demonstrate,
    joined,
    random_marks,
    recalls_after,
    recalls_on_wheels,
    reference_recalls,
    search,
    thesis_teacher,
    thinned,
    varied_arenas,
)
from khepera_forage.comparison.learning import BASELINES, Compared, fingerprint, learn_and_forage, unable
from khepera_forage.envs.training import TrainingEnv
from khepera_forage.estimates import Estimate, Measure, Table, Value, mean, pick, table_of
from khepera_forage.experience import Experience
from khepera_forage.policies.distance import CORRIDOR_DIAGONAL
from khepera_forage.policies.features import wheels_features
from khepera_forage.policies.learner_registry import own_errors
from khepera_forage.policies.learners import LEARNERS, OfflineImitation, ReinforcementLearner
from khepera_forage.rollouts.compiled.training import train_learners
from khepera_forage.rollouts.raw_episodes import RawEpisode, recorded
from khepera_forage.rollouts.recall import recall_wheels_env
from khepera_forage.rollouts.training import IncompleteTrainingError
from khepera_forage.sim.arenas.difficulty import DIFFICULTIES
from khepera_forage.sim.arenas.named import FAMILY
from khepera_forage.sim.arenas.thesis import CORRIDOR, RECTANGLE
from khepera_forage.study import SMOKE_TEST, Arguments, Execute, Job, Page, Rows, collect, finish
from khepera_forage.task.states import NUM_BEHAVIOURS

GROUPS: dict[str, tuple[str, ...]] = {
    CORRIDOR: (CORRIDOR,),
    RECTANGLE: (RECTANGLE,),
    "family": tuple(FAMILY),
    "procedural": tuple(DIFFICULTIES),
}
"""Places of recalls. Those of a group count alike."""
OFFLINE, TEACHING, WHEELS, VOCABULARY = TRACK_NAMES
ROUNDS = 600
"""Of a training episode at most; its rewards have -1/600 a round, and the environment of its dataset this limit."""
THESIS, RANDOM, VARIED, THINNED = "thesis's", "random", "varied arenas", "varied arenas, thinned"
"""Teachers. The last one gives as many experience vectors as the thesis's teacher, drawn from those of the third."""
AS_HEARD, PERMUTED, LATE, SILENT, WRONG = "as heard", "permuted", "3 late", "half silent", "a fifth wrong"
"""Vocabularies: what the experience has in place of the behaviour that the teacher executed."""
TAUGHT = ("imitator", "boosting", "cloning")
"""Learners for which a teacher searches."""
DEMONSTRATIONS, SEARCHES, TESTS = 5, 5, 10
"""In a set that is searched for; searches for each learner; trainings with each set found."""
BUDGETS = {"imitator": Budget(24, 20, 16, 160)}
_BUDGET = Budget(16, 6, 2, 40)
"""Of the other learners, which take tens of times as long to learn and forage."""
TRAINED, ALONE = "training episodes", "the teacher alone"
"""Data of the track on wheels: a learner's, or those of a teacher that forages alone from random places."""


class BenchmarkTrack(NamedTuple):
    """One question.

    Attributes:
        learners: Those of the package that take part.
        amounts: Of learning in each condition: episodes, or steps of reinforcement learning.
        places: Groups of places, with so many recalls in each.
        slow: Replications of learners that take seconds: all but the thesis's imitator and the references.
    """

    question: str
    learners: tuple[str, ...]
    amounts: Mapping[str, tuple[int, ...]]
    places: tuple[str, ...]
    seeds: int
    slow: int
    recalls: int = 20


_VECTORS = tuple(name for name, learner in LEARNERS.items() if isinstance(learner, OfflineImitation))
_ON_WHEELS = ("network", "trees")
"""Offline learners on wheels."""
STEPS = "steps of reward"
TRACKS = {
    OFFLINE: BenchmarkTrack(
        "What is learned from 1, 3, 10 or 30 training episodes in the corridor, and how far does it carry?",
        _VECTORS,
        {THESIS: (1, 3, 10, 30)},
        (CORRIDOR, RECTANGLE, "family", "procedural"),
        50,
        10,
    ),
    TEACHING: BenchmarkTrack(
        "Which demonstrations should a teacher give?",
        TAUGHT,
        dict.fromkeys((THESIS, RANDOM, VARIED, THINNED), (DEMONSTRATIONS, 30)),
        (CORRIDOR,),
        50,
        50,
    ),
    WHEELS: BenchmarkTrack(
        "Can wheels, arm and jaw be learned from raw data?",
        (
            *_ON_WHEELS,
            *(name for name, one in LEARNERS.items() if isinstance(one, ReinforcementLearner) and one.wheels),
        ),
        {TRAINED: (10, 50), ALONE: (10, 50), STEPS: (1_000_000,)},
        (CORRIDOR, RECTANGLE),
        10,
        10,
    ),
    VOCABULARY: BenchmarkTrack(
        "What is learned if the words of the teacher are unknown, late, missing or wrong?",
        _VECTORS,
        dict.fromkeys((AS_HEARD, PERMUTED, LATE, SILENT, WRONG), (10,)),
        (CORRIDOR,),
        50,
        50,
    ),
}


def track_of(name: str, quick: bool) -> BenchmarkTrack:
    """A track; in small with `quick`."""
    track = TRACKS[name]
    if not quick:
        return track
    amounts = {condition: some[:1] for condition, some in track.amounts.items()}
    if STEPS in amounts:
        amounts[STEPS] = (1_000,)
    return track._replace(amounts=amounts, seeds=2, slow=1, recalls=2)


@dataclass(frozen=True, slots=True)
class Tested:
    """Recalls of one learner in one place; fields that are not explained are those of `RecallBatch`.

    Attributes:
        condition: One of the track's, or a learner for which the demonstrations were searched; empty without learning.
        replication: With seeds and training of its own. For demonstrations that were searched for, the search.
        vectors: What was learned from: experience vectors, or rounds.
        seconds: Learning and recalls in all places, wall time.
    """

    track: str
    learner: str
    condition: str
    amount: int
    replication: int
    place: str
    recalls: int
    score: float
    delivered: int
    foods: int
    vectors: int
    seconds: float


@dataclass(frozen=True, slots=True)
class Demonstrations:
    """What a search found; of each demonstration x, y (mm), heading (degrees) of the start, x, y of the food."""

    learner: str
    search: int
    marks: tuple[float, ...]


def find_demonstrations(seed: int, name: str, number: int, budget: Budget) -> list[Demonstrations]:
    """Search for the demonstrations after which a learner delivers most."""
    learner = LEARNERS[name]
    assert isinstance(learner, OfflineImitation)
    rng = np.random.default_rng(_seed(seed, 3, number, TAUGHT.index(name)))
    with threadpool_limits(1):
        marks = search(learner, DEMONSTRATIONS, budget, rng)
    return [Demonstrations(name, number, tuple(marks.ravel().round(2).tolist()))]


class Learning(NamedTuple):
    """A unit of work: one learner learns once, and forages; fields that are not explained are those of `Tested`.

    Attributes:
        learner: None for an offline learner on wheels.
        recalls: In each group of places.
        test: Number of the training with the same demonstrations.
        marks: Of `Demonstrations`.
    """

    seed: int
    track: str
    name: str
    learner: Compared | None
    condition: str
    amount: int
    replication: int
    recalls: int
    test: int = 0
    marks: tuple[float, ...] = ()

    @property
    def key(self) -> str:
        """What it is, in words."""
        return f"{self.track} {self.name} {self.condition} {self.amount} {self.replication} {self.test}"

    def run(self) -> list[Tested]:
        """Learn, and be tested."""
        began = perf_counter()
        with threadpool_limits(1), own_errors(f"learner {self.name}"):
            vectors, done = self._forage()
        seconds = perf_counter() - began
        return [
            Tested(
                *(self.track, self.name, self.condition, self.amount, self.replication, place),
                *(len(own.score), float(np.mean(own.score)), int(own.delivered.sum()), int(own.foods.sum())),
                *(vectors, seconds),
            )
            for place, own in done.items()
        ]

    def _forage(self) -> tuple[int, dict[str, Foraged]]:
        number = self.replication * TESTS + self.test if self.marks else self.replication
        seeds, own = self._seeds(number), _seed(self.seed, 4, number)
        match self.learner:
            case OfflineImitation():
                training = self.training(number)
                return len(training.vectors), recalls_after(
                    self.learner, training, seeds, own % 2**31, CORRIDOR_DIAGONAL
                )
            case ReinforcementLearner():
                rows = learn_and_forage(
                    *(self.seed, self.replication, self.name, self.learner),
                    *((self.amount,), self.recalls, TRACKS[self.track].places),
                )
                found = {
                    row.arena: Foraged(
                        np.full(row.recalls, row.score), np.array([row.delivered]), np.array([row.foods])
                    )
                    for row in rows
                }
                return rows[0].steps, found
            case None:
                episodes = [raw for _, raw in _recorded(self.condition, self.amount, self.seed, number)]
                return sum(len(one.actions) for one in episodes), recalls_on_wheels(
                    wheels_learner(self.name, episodes, own % 2**31), seeds
                )
        if self.track == WHEELS and self.name == "random":
            rng = np.random.default_rng(own)
            return 0, recalls_on_wheels(lambda rows: rng.uniform(-1, 1, (len(rows), 4)), seeds)
        return 0, reference_recalls(self.name == "teacher", seeds)

    def _seeds(self, number: int) -> Seeds:
        found = {}
        for group in (GROUPS[name] for name in TRACKS[self.track].places):
            for place in group[: self.recalls]:
                drawing = np.random.SeedSequence(self.seed, spawn_key=(1, number, _ALL_PLACES.index(place)))
                found[place] = drawing.generate_state(max(1, self.recalls // len(group))).tolist()
        return found

    def training(self, number: int) -> TrainingData:
        """The experience of a replication, or of a training with given demonstrations."""
        key = _seed(self.seed, 2, number)
        if self.marks:
            return demonstrate(np.array(self.marks).reshape(-1, PLACES), key)[0]
        if self.condition == RANDOM:
            return _followed(self.amount, key)
        if self.condition == VARIED:
            return varied_arenas(self.amount, key)
        usual = thesis_teacher(self.amount, key)
        if self.condition == THINNED:
            return thinned(varied_arenas(self.amount, key), len(usual.vectors), key)
        return spoken(usual, self.condition, np.random.default_rng(key))


_ALL_PLACES = tuple(place for group in GROUPS.values() for place in group)


def spoken(training: TrainingData, vocabulary: str, rng: np.random.Generator) -> TrainingData:
    """Experience as if the teacher had spoken in another way; what the robots did does not change.

    `PERMUTED`: each behaviour has the name of another one. `LATE`: words arrive three experience vectors later, and the
    last three of an episode never. `SILENT`: half of the words are not heard. `WRONG`: a fifth of the words are drawn
    from the nine others.
    """
    vectors, heard, episodes = training
    size = len(heard)
    if vocabulary == PERMUTED:
        order = rng.permutation(NUM_BEHAVIOURS)
        names = np.empty(NUM_BEHAVIOURS, np.int64)
        names[order] = np.roll(order, 1)
        return TrainingData(vectors, names[heard], episodes)
    if vocabulary == LATE:
        same = episodes[3:] == episodes[:-3]
        return TrainingData(vectors[3:][same], heard[:-3][same], episodes[3:][same])
    if vocabulary == SILENT:
        kept = rng.random(size) < 0.5
        return TrainingData(vectors[kept], heard[kept], episodes[kept])
    if vocabulary == WRONG:
        wrong = (rng.random(size) < 0.2) * rng.integers(1, NUM_BEHAVIOURS, size)
        return TrainingData(vectors, (heard + wrong) % NUM_BEHAVIOURS, episodes)
    return training


def _followed(amount: int, key: int) -> TrainingData:
    """Random demonstrations that a learner can follow."""
    parts: list[NDArray[Any]] = []
    for number in count():
        try:
            one = demonstrate(random_marks(1, key + number), key + number)[0]
        except IncompleteTrainingError:
            continue
        parts.append(np.column_stack(one[:2]))
        if len(parts) == amount:
            break
    return joined(parts)


def wheels_learner(name: str, episodes: Sequence[RawEpisode], seed: int) -> Callable[[NDArray[Any]], NDArray[Any]]:
    """A regression from rows of `wheels_features` to motors: a `network`, or extremely randomised `trees`."""
    from sklearn.ensemble import ExtraTreesRegressor
    from sklearn.neural_network import MLPRegressor

    shown = [wheels_features({k: v[:-1] for k, v in one.observations.items()}) for one in episodes]
    rows, motors = np.concatenate(shown), np.concatenate([one.actions for one in episodes])
    if name == "trees":
        learner: Any = ExtraTreesRegressor(10, min_samples_leaf=2, random_state=seed)
    else:
        learner = MLPRegressor(hidden_layer_sizes=(64, 64), early_stopping=True, max_iter=300, random_state=seed)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of an end before convergence: the budget is part of the protocol
        learner.fit(rows, motors)
    return lambda rows: np.clip(learner.predict(rows), -1.0, 1.0)


@lru_cache(4)
def _recorded(data: str, amount: int, seed: int, replication: int) -> list[tuple[Experience, RawEpisode]]:
    """The first raw episodes of a replication."""
    keys = np.random.SeedSequence(seed, spawn_key=(5, replication)).spawn(amount)
    return recorded(recall_wheels_env(CORRIDOR) if data == ALONE else TrainingEnv(max_cycles=ROUNDS), keys)


def _seed(seed: int, *purpose: int) -> int:
    return int(np.random.SeedSequence(seed, spawn_key=purpose).generate_state(1)[0])


def searches(learners: Mapping[str, Compared], seed: int, quick: bool, most: int) -> list[Job]:
    """The searches for demonstrations, one for every ten replications; arguments as for `plan`."""
    budgets = {name: Budget(4, 1, 1, 2) if quick else BUDGETS.get(name, _BUDGET) for name in TAUGHT}
    return [
        Job(f"search {name} {number}", find_demonstrations, (seed, name, number, budget))
        for number in range(1 if quick else min(SEARCHES, most // TESTS))
        for name, budget in budgets.items()
        if name in learners
    ]


def plan(
    name: str, learners: Mapping[str, Compared], seed: int, quick: bool, most: int, found: Sequence[Demonstrations] = ()
) -> Iterator[Learning]:
    """The units of a track, in at most so many replications, with the demonstrations that searches found."""
    track = track_of(name, quick)
    own: dict[str, Compared | None] = {
        key: one
        for key, one in learners.items()
        if key in track.learners or (isinstance(one, OfflineImitation) and key not in LEARNERS and name != WHEELS)
    }
    if name == WHEELS:
        own |= dict.fromkeys(_ON_WHEELS)
    for number in range(min(most, track.seeds)):
        for key, reference in BASELINES.items():
            yield Learning(seed, name, key, reference, "", 0, number, track.recalls)
        for key, learner in own.items():
            if number >= track.slow and key != "imitator":
                continue
            for condition, amounts in track.amounts.items():
                if (condition == STEPS) == isinstance(learner, ReinforcementLearner):
                    for amount in amounts:
                        yield Learning(seed, name, key, learner, condition, amount, number, track.recalls)
    if name == TEACHING:
        for one in found:
            for key, learner in own.items():
                for test in range(2 if quick else TESTS):
                    yield Learning(
                        *(seed, name, key, learner, f"best for {one.learner}", DEMONSTRATIONS, one.search),
                        *(track.recalls, test, one.marks),
                    )


FOUND = "searches.jsonl.gz"
"""File of a run's folder with the demonstrations that were searched for."""
SHARE = Measure[Tested]("food delivered (%)", lambda row: 100.0 * row.delivered / row.foods)
"""Every place counts alike."""


def run(given: Arguments, learners: Mapping[str, Compared], execute: Execute) -> int:
    """Do what is missing of the protocol for `khepera-forage compare --protocol`, and write the page.

    Raises:
        ValueError: A learner was asked for that is on none of the tracks.
    """
    given.name = PROTOCOL
    chosen = list(dict.fromkeys(given.track or TRACKS))
    concerned = {name for track in chosen for name in TRACKS[track].learners}
    concerned |= {name for name, one in learners.items() if name not in LEARNERS and isinstance(one, OfflineImitation)}
    for name in learners.keys() - BASELINES.keys() if given.only or given.learner else ():
        if name not in concerned:
            raise ValueError(
                f"--only or --learner is {name!r}; allowed on these tracks: {', '.join(sorted(concerned))}, and your "
                "own ones from experience vectors"
            )
    missing = {name: why for name, one in learners.items() if name in concerned and (why := unable(one))}
    for name, why in missing.items():
        print(f"{name} is left out: {why}")
    able = {name: one for name, one in learners.items() if name not in missing}
    settings = {"protocol": PROTOCOL} | {f"learner {name}": fingerprint(one) for name, one in able.items()}
    most = given.seeds if given.seeds_given else max(track.seeds for track in TRACKS.values())
    found = Rows(())
    if TEACHING in chosen:
        units = searches(able, given.seed, given.quick, most)
        found = collect(given, units, {Demonstrations: "demonstrations"}, execute, settings, True, FOUND)
    tests = [
        unit for track in chosen for unit in plan(track, able, given.seed, given.quick, most, found.of(Demonstrations))
    ]
    rows = collect(given, tests, {Tested: "rows"}, execute, settings, True).of(Tested)
    return finish(given, page(rows, given.seed, given.quick))


def page(rows: Sequence[Tested], seed: int, quick: bool) -> Page:
    """The page of all tracks that have rows; `seed` is that of the resamples."""
    tables = []
    for name, track in TRACKS.items():
        own = pick(rows, track=name)
        if own:
            tables.append(_table(name, track.question, own, seed))
            if name == TEACHING and (transfer := _transfer(own, seed)).rows:
                tables.append(transfer)
    if quick:
        return Page(f"{PROTOCOL}, in small", [SMOKE_TEST, *tables])
    return Page(PROTOCOL, tables)


def _share(rows: Sequence[Tested], seed: int) -> Estimate:
    return mean(rows, SHARE, np.random.default_rng(seed))


def _table(name: str, question: str, rows: Sequence[Tested], seed: int) -> Table:
    """Food delivered by learner, condition and amount, in every group of places."""
    groups = {group: set(GROUPS[group]) for group in TRACKS[name].places}
    lines: list[dict[str, Value]] = []
    for learner, condition, amount in _kinds(rows):
        own = pick(rows, learner=learner, condition=condition, amount=amount)
        lines.append(
            {
                "learner": learner,
                "condition": condition or "-",
                "amount": amount,
                "trainings": len({(row.replication, row.seconds) for row in own}),
                **{f"{g} (%)": _share([row for row in own if row.place in group], seed) for g, group in groups.items()},
                "vectors": Estimate(float(np.mean([row.vectors for row in own]))),
                "seconds": Estimate(float(np.mean([row.seconds for row in own]))),
            }
        )
    note = (
        f"{question} Food delivered that is not poisonous, with 95 % intervals over replications; every place of a "
        "group counts alike. `teacher` is the upper bound and `random` the lower one."
    )
    return table_of(name, f"Track: {name}", note, lines, {"vectors": 0, "seconds": 2})


def _transfer(rows: Sequence[Tested], seed: int) -> Table:
    """How much of the gap to 100 % demonstrations close, by learner and teacher."""
    few = TRACKS[TEACHING].amounts[THESIS][0]
    lines: list[dict[str, Value]] = []
    for learner, condition, amount in _kinds(rows):
        if learner not in BASELINES and amount == few and condition != THESIS:
            share = _share(pick(rows, learner=learner, condition=condition, amount=amount), seed)
            usual = _share(pick(rows, learner=learner, condition=THESIS, amount=amount), seed).value
            lines.append(
                {
                    "learner": learner,
                    "teacher": condition,
                    "thesis's teacher (%)": Estimate(usual),
                    "this teacher (%)": share,
                    "gap closed (%)": Estimate(*(100 * (value - usual) / max(100 - usual, 1e-9) for value in share)),
                }
            )
    note = (
        "Five demonstrations. Gap closed: 0 is the thesis's teacher, 100 is all food. Best for: demonstrations "
        "that were searched for one learner, tested with each. Intervals are over replications, or over searches, "
        "with the mean of the thesis's teacher held."
    )
    return table_of("transfer", "Five demonstrations", note, lines)


def _kinds(rows: Sequence[Tested]) -> list[tuple[str, str, int]]:
    """Learners, conditions and amounts of a track, in the order of the protocol; the references first."""
    track = TRACKS[rows[0].track]
    names = list(dict.fromkeys([*BASELINES, *track.learners, *(row.learner for row in rows)]))
    conditions = list(dict.fromkeys([*track.amounts, *(row.condition for row in rows)]))
    kinds = {(row.learner, row.condition, row.amount) for row in rows}
    return sorted(kinds, key=lambda kind: (names.index(kind[0]), conditions.index(kind[1]), kind[2]))


Made = tuple[str, Sequence[Experience], dict[str, Any]]
"""About a dataset; its experience; further arguments of `to_minari`."""


def datasets(seed: int, episodes: int | None = None) -> dict[str, Callable[[], Made]]:
    """What makes each dataset of the protocol, by Minari's name; of each the first `episodes`, or all.

    Episodes stand replication by replication, as many of each as the largest amount of the track.
    """
    offline, wheels = TRACKS[OFFLINE], TRACKS[WHEELS]

    def heard() -> Made:
        each = max(offline.amounts[THESIS])
        some = list(np.ndindex(offline.seeds, each))[:episodes]
        trained = [
            train_learners(1, CORRIDOR, _seed(seed, 2, i), episodes=each, max_cycles=ROUNDS)
            for i in range(some[-1][0] + 1)
        ]
        parts = [trained[i].experience_of(0, k) for i, k in some]
        about = f"Training episodes in the corridor; {each} of each replication, one replication after the other."
        return about, parts, {"rewards": [trained[i].rewards_of(0, k) for i, k in some], "limit": ROUNDS}

    def raw(data: str) -> Made:
        each = max(wheels.amounts[data])
        number = min(episodes or each * wheels.seeds, each * wheels.seeds)
        made = [_recorded(data, min(each, number), seed, i) for i in range(-(-number // each))]
        pairs = [pair for some in made for pair in some][:number]
        about = f"Raw data and motors of {data}; {each} episodes of each replication, one after the other."
        limit = ROUNDS if data == TRAINED else None
        return about, [one for one, _ in pairs], {"episodes": [one for _, one in pairs], "limit": limit}

    return {
        f"{PROTOCOL}/corridor-v1": heard,
        f"{PROTOCOL}/corridor-wheels-v1": lambda: raw(TRAINED),
        f"{PROTOCOL}/alone-wheels-v1": lambda: raw(ALONE),
    }
