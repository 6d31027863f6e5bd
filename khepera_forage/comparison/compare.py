"""The comparison of learners: who takes part, where the work is done, and what is written; and of settings."""

from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import replace
from importlib.util import find_spec
from typing import Any

import numpy as np
from joblib import effective_n_jobs

from khepera_forage.comparison.learning import (
    ALL_ARENAS,
    ARENAS,
    Compared,
    RecallBatch,
    all_learners,
    check_form,
    fingerprint,
    learn_and_forage,
    settings_text,
    unable,
)
from khepera_forage.comparison.page import other_arenas, page
from khepera_forage.comparison.results import (
    DELIVERED,
    Curve,
    Results,
    as_json,
    curves,
    described,
    merged,
    read_results,
)
from khepera_forage.estimates import UNKNOWN, Estimate, Table, difference, pick, table_of
from khepera_forage.files import replacing
from khepera_forage.policies.learner_registry import installed_learners, learner_at
from khepera_forage.policies.learners import LEARNERS, InteractiveImitation, Learner, OfflineImitation, Supervision
from khepera_forage.study import (
    DIED,
    UNITS,
    Arguments,
    Done,
    Execute,
    Job,
    Page,
    WorkUnit,
    collect,
    command_line,
    done,
    finish,
    in_processes,
    machine,
    write_text,
)

TUNING = "tuning"
"""The folder in `--out` that `--tune` writes to."""
RESULTS = "results.json"
BASELINES = ("teacher", "imitator")
"""What a learner of `--learner` is compared with, without `--only`."""
EPISODES, QUICK_EPISODES = (1, 2, 3, 5, 10), (1, 2)
QUERIES, QUICK_QUERIES = (100, 200, 300, 500, 1_000), (100, 200)
HALF_DECADES = (1_000, 3_000, 10_000, 30_000, 100_000, 300_000)
"""Amounts of learning after which learners are tested: training episodes, queries, and steps up to `--steps`."""


@contextmanager
def workers(backend: str, jobs: int, address: str | None) -> Iterator[Execute]:
    """What does units with a backend; with Dask on the cluster at an address, or on a temporary one here.

    The workers of a cluster need `khepera_forage` installed, and the packages of all learners.
    """
    number, title = effective_n_jobs(jobs), "processes of this machine"
    with ExitStack() as stack:
        run = in_processes(jobs)
        if backend == "dask":
            from distributed import Client, KilledWorker, LocalCluster, as_completed
            from distributed.protocol.pickle import dumps, loads

            here: dict[str, Any] = {"n_workers": number, "threads_per_worker": 1, "dashboard_address": "127.0.0.1:0"}
            cluster = address or stack.enter_context(LocalCluster(**here))
            client = stack.enter_context(Client(cluster))
            threads = list(client.nthreads().values())
            if max(threads, default=1) > 1:  # they would share global random numbers
                raise ValueError(f"a worker of Dask has {max(threads)} threads; allowed: 1 (dask worker --nthreads 1)")
            number, title = len(threads), "workers of Dask"

            def run(units: Sequence[WorkUnit]) -> Iterator[Done]:
                try:  # Dask itself waits for ever if a worker cannot load its work
                    for on in (client.run_on_scheduler, client.run):
                        on(loads, dumps(units))
                except ImportError as error:
                    allowed = "allowed: what its scheduler and its workers have installed, or on PYTHONPATH"
                    raise ImportError(f"Dask cluster: {error}; {allowed}") from error
                try:  # not by joblib, which waits for ever for what a dead worker did
                    for _, result in as_completed(client.map(done, units, pure=False), with_results=True):
                        yield result
                except KilledWorker as error:
                    raise ChildProcessError(DIED) from error

        def execute(units: Sequence[WorkUnit]) -> Iterator[Done]:
            print(f"{len(units)} units for {number} {title}", flush=True)
            return run(units)

        yield execute


def unavailable(backend: str, address: str | None) -> str:
    """Why a backend cannot be used with this address; empty if it can."""
    if backend == "loky":
        return "" if address is None else f"--address is {address!r}; allowed: with --backend dask"
    if find_spec("distributed") is None:
        return f"--backend {backend} needs the extra {backend}: pip install 'khepera-forage[{backend}]'"
    return ""


def known_learners() -> str:
    """All learners that are known here, one a line: name, title, what it learns from, and settings; and broken ones."""
    lines = [
        (name, learner.title, learner.needs.value if learner.needs else "-", settings_text(learner))
        for name, learner in all_learners().items()
    ]
    widths = [max(len(line[i]) for line in lines) for i in range(3)]
    table = ["  ".join([*map(str.ljust, line, widths), line[-1]]) for line in lines]
    return "\n".join([*table, *(f"{name} is left out: {why}" for name, why in installed_learners().broken.items())])


def compare(given: Arguments) -> int:
    """Compare learners as the arguments of `khepera-forage compare` say.

    Raises:
        ValueError: A learner that is unknown or cannot be used, or a file that holds no results.
    """
    against = read_results(given.against) if given.against else None
    own = _own_learners(given.learner or [])
    known, installed = all_learners() | own, installed_learners()
    for name in given.only or ():
        if name not in known:
            raise ValueError(f"--only is {name!r}{installed.why_not(name)}; allowed: {', '.join(known)}")
    chosen = [*(given.only or (BASELINES if own else known)), *own]
    missing = {}
    if not given.protocol:  # which says itself who cannot take part
        missing = {name: why for name in chosen if (why := unable(known[name], given.arenas or ARENAS))}
    learners = {name: learner for name, learner in known.items() if name in chosen and name not in missing}
    missing |= {} if given.only or own else installed.broken
    for name, reason in missing.items():
        print(f"{name} is left out: {reason}")
    if given.protocol:
        from khepera_forage.comparison.protocol import run  # needs numba

        with workers(given.backend, given.jobs, given.address) as execute:
            return run(given, learners, execute)
    if not learners:
        raise ValueError("no learner is left")
    rows = _rows(learners, known, range(given.seeds), _amounts(given), given)
    found = curves(rows, given.seed)
    shown = described({curve.learner: known[curve.learner] for curve in found})
    results = Results(f"{machine()} {command_line()}", shown, found)
    elsewhere = other_arenas(rows, shown, given.seed)
    tuned = (given.out / TUNING).exists()
    written = page(*merged(found, shown, against), missing, tuned, given.quick, elsewhere)
    with replacing(given.out / RESULTS) as path:
        write_text(path, as_json(results))
    return finish(given, written, shown=1)


def _own_learners(places: list[str]) -> dict[str, Compared]:
    """The learners of `--learner`, by name."""
    found: dict[str, Compared] = {}
    for place in places:
        try:
            name, learner = learner_at(place)
            check_form(place, learner)
        except ValueError as error:
            raise ValueError(f"--{error}") from None
        if name in all_learners() or name in found:
            raise ValueError(f"--learner is {place!r}, a name that another learner has; allowed: a new name")
        found[name] = learner
    return found


def _amounts(given: Arguments) -> dict[Supervision | None, tuple[int, ...]]:
    """The amounts of learning after which learners are tested, by what they learn from."""
    return {
        None: (0,),
        Supervision.VECTORS: QUICK_EPISODES if given.quick else EPISODES,
        Supervision.QUERIES: QUICK_QUERIES if given.quick else QUERIES,
        Supervision.STEPS: (*(amount for amount in HALF_DECADES if amount < given.steps), given.steps),
    }


def _rows(
    learners: Mapping[str, Compared],
    known: Mapping[str, Compared],
    replications: range,
    amounts: Mapping[Supervision | None, tuple[int, ...]],
    given: Arguments,
) -> list[RecallBatch]:
    """All rows of the folder, of any known learner, after the missing ones of some learners have been made."""
    arenas = tuple(dict.fromkeys(given.arenas or ARENAS))
    # Replication by replication, so that a run that is killed has rows of every learner.
    units = [
        Job(
            f"{name} {number}",
            learn_and_forage,
            (given.seed, number, name, learner, amounts[learner.needs], given.recalls, arenas),
        )
        for number in replications
        for name, learner in learners.items()
    ]
    settings = {f"learner {name}": fingerprint(learner) for name, learner in learners.items()}
    settings["arenas"] = " ".join(arenas)
    with workers(given.backend, given.jobs, given.address) as execute:
        rows = collect(given, units, {RecallBatch: "rows"}, execute, settings, others=True)
    found = rows.of(RecallBatch)
    for row in found:
        if row.learner not in known:
            raise ValueError(f"{given.out / UNITS}: learner is {row.learner!r}; allowed: {', '.join(known)}")
    place = {name: i for i, name in enumerate(known)}
    return sorted(found, key=lambda row: (place[row.learner], row.replication, row.amount, ALL_ARENAS.index(row.arena)))


FIRST_REPLICATION = 1_000
"""Replications from this number on are for tuning, those before it for the comparison of learners."""
CANDIDATES: dict[str, tuple[Mapping[str, Any], ...]] = {
    "k_nearest": ({"k": 3}, {"k": 9}, {"k": 15}),
    "distance_weighted": ({"k": 3}, {"k": 9}, {"k": 15}),
    "attribute_weights": ({"choices": (1, 2)}, {"choices": (0, 1, 2, 4, 8)}, {"search_size": 300}),
    "growing_memory": ({"reach": 0.01}, {"reach": 0.05}, {"habituation": 0.1}),
    "tree": ({"min_samples_leaf": 3}, {"min_samples_leaf": 10}, {"max_depth": 6}),
    "boosting": ({"n_estimators": 100}, {"max_depth": 2}, {"learning_rate": 0.03}),
    "cloning": ({"hidden_layer_sizes": (64, 64)}, {"alpha": 0.01}, {"alpha": 0.1}),
    "dagger": ({"queries_a_round": 25}, {"queries_a_round": 50}, {"queries_a_round": 200}),
    "dagger_tree": ({"queries_a_round": 25}, {"queries_a_round": 50}, {"queries_a_round": 200}),
}
"""Changes to the settings of each learner. The thesis's imitator has none."""


def candidates() -> dict[str, Compared]:
    """Every learner that is tuned: as it is, with each other setting, and with its most probable behaviour."""
    found: dict[str, Compared] = {}
    for name, changes in CANDIDATES.items():
        learner = found[name] = LEARNERS[name]
        for number, change in enumerate(changes, 1):
            found[f"{name}.{number}"] = replace(learner, settings={**learner.settings, **change})
        if isinstance(learner, InteractiveImitation):
            most_probable: Learner = replace(learner, learner=replace(learner.learner, sample=False))
        else:
            assert isinstance(learner, OfflineImitation)
            most_probable = replace(learner, sample=False)
        found[f"{name}.{len(changes) + 1}"] = most_probable
    return found


def differences(rows: Sequence[RecallBatch], seed: int) -> dict[str, Estimate]:
    """Points of the food that each other setting delivers more than the registry's, over the same replications."""
    own: dict[str, list[RecallBatch]] = {}
    for row in pick(rows, arena=ARENAS[0]):
        own.setdefault(row.learner, []).append(row)
    return {
        name: difference(theirs, own[_base(name)], DELIVERED, np.random.default_rng(seed))
        for name, theirs in own.items()
        if name != _base(name)
    }


def tune(given: Arguments) -> int:
    """Compare settings with those of the registry, in replications of their own, after the largest amount of learning.

    Raises:
        ValueError: No learner of `--only` has other settings.
    """
    known = candidates()
    wanted = given.only or list(known)
    learners = {name: learner for name, learner in known.items() if _base(name) in wanted}
    if not learners:
        raise ValueError(f"--only is {', '.join(wanted)}; allowed with --tune: {', '.join(CANDIDATES)}")
    given.out /= TUNING
    given.name = TUNING
    amounts = {needs: own[-1:] for needs, own in _amounts(given).items()}
    replications = range(FIRST_REPLICATION, FIRST_REPLICATION + given.seeds)
    rows = _rows(learners, known, replications, amounts, given)
    written = Page("Settings of the learners", [_tuning_table(rows, known, given.seed)])
    return finish(given, written)


def _tuning_table(rows: Sequence[RecallBatch], learners: Mapping[str, Compared], seed: int) -> Table:
    """All candidates in the corridor, the best of each learner marked."""
    gains = differences(rows, seed)
    own = [curve for curve in curves(rows, seed) if curve.arena == ARENAS[0]]
    best: dict[str, Curve] = {}
    for curve in own:
        if _success(curve) > _success(best.setdefault(_base(curve.learner), curve)):
            best[_base(curve.learner)] = curve
    return table_of(
        "tuning",
        "Settings compared",
        "In the corridor, after the largest amount of learning, with 95 % intervals over replications that the "
        "comparison of learners does not use. The first line of each learner has the settings of the registry. More: "
        "points of the food delivered more than with those. Best: most food, then score. Without any true difference, "
        "one setting in forty would be clearly better by chance.",
        [
            {
                "learner": learners[curve.learner].title,
                "settings": settings_text(learners[curve.learner]),
                "food delivered (%)": curve.end.delivered,
                "more (points)": gains.get(curve.learner, UNKNOWN),
                "score (%)": curve.end.score,
                "best": "best" if best[_base(curve.learner)] is curve else "",
            }
            for curve in own
        ],
    )


def _base(name: str) -> str:
    return name.split(".")[0]


def _success(curve: Curve) -> tuple[float, float]:
    return curve.end.delivered.value, curve.end.score.value
