"""Settings beside those of the registry, the same few for every learner, and which of them forage best.

The choice is made over seeds of its own, in the corridor, after the largest amount of learning.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from _learners.curves import Curve, difference
from _learners.lessons import Compared
from _learners.rows import ARENAS, Batch
from _learners.units import told
from khepera_forage.policies.learners import LEARNERS, FromQueries, FromVectors, Learner
from khepera_forage.thesis.statistics import UNKNOWN, Estimate
from khepera_forage.thesis.tables import Column, Table, interval

FIRST_SEED = 1_000
"""Replications from this number on are for tuning, those before it for the comparison."""
NOTHING = 1e-9
"""Points of the food; less than that is rounding."""
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
"""What each is tried with instead, on top of its settings. The thesis' imitator has none."""


def candidates() -> dict[str, Compared]:
    """Every learner that is tuned, as it is, with each other setting, and with the surest behaviour."""
    found: dict[str, Compared] = {}
    for name, changes in CANDIDATES.items():
        learner = LEARNERS[name]
        found[name] = learner
        for number, change in enumerate(changes, 1):
            found[f"{name}.{number}"] = replace(learner, settings={**learner.settings, **change})
        found[f"{name}.{len(changes) + 1}"] = _surest(learner)
    return found


def differences(rows: Sequence[Batch], rng: np.random.Generator) -> dict[str, Estimate]:
    """How many points of the food each other setting delivers more than the registry's, over the same replications.

    Args:
        rows: Of candidates, in the order of `folder.in_order`.
        rng: Draws the resamples.
    """
    own: dict[str, list[Batch]] = {}
    for row in rows:
        if row.arena == ARENAS[0]:
            own.setdefault(row.learner, []).append(row)
    return {
        name: difference(theirs, own[_base(name)], rng) for name, theirs in own.items() if name != _base(name)
    }


def reading(gains: Mapping[str, Estimate], learners: Mapping[str, Compared]) -> str:
    """Which other settings are clearly better or worse than the registry's: the interval of the difference says it."""
    better = [name for name, gain in gains.items() if gain.low > NOTHING]
    worse = [name for name, gain in gains.items() if gain.high < -NOTHING]
    named = "; ".join(
        f"{learners[name].title} with `{told(learners[name])}`, {interval(gains[name])} points more"
        for name in better
    )
    return (
        f"{len(gains)} other settings were tried. Clearly more food than with the registry's, as the 95 % interval of "
        f"the difference lies above 0: {len(better)}{f' ({named})' if named else ''}. Clearly less: {len(worse)}. "
        "Where nothing differs, about one in forty is clearly more by chance; the registry's settings stay as they are."
    )


def tuning_page(table: Table, outcome: str, command: str) -> str:
    """Table and what came out, in Markdown."""
    return (
        f"# Settings of the learners\n\n## What came out\n\n{outcome}\n\n"
        f"{table.markdown()}\n## Command\n\n    {command}\n"
    )


def tuning_table(
    curves: Sequence[Curve], gains: Mapping[str, Estimate], learners: Mapping[str, Compared]
) -> Table:
    """All candidates in the corridor, the best of each learner marked."""
    own = [curve for curve in curves if curve.arena == ARENAS[0]]
    best: dict[str, Curve] = {}
    for curve in own:
        if _success(curve) > _success(best.setdefault(_base(curve.learner), curve)):
            best[_base(curve.learner)] = curve
    return Table(
        "table_tuning",
        "Settings compared",
        "In the corridor, after the largest amount of learning; means with 95 % intervals over replications that the "
        "comparison does not use. The first of each learner is that of the registry; more: points "
        "of the food delivered more than with that, over the same replications. Best: most food, then score.",
        (
            Column("learner"),
            Column("settings"),
            Column("food delivered (%)", estimate=True),
            Column("more (points)", estimate=True),
            Column("score (%)", estimate=True),
            Column("best"),
        ),
        [
            (
                learners[curve.learner].title,
                told(learners[curve.learner]),
                curve.end.delivered,
                gains.get(curve.learner, UNKNOWN),
                curve.end.score,
                "best" if best[_base(curve.learner)] is curve else "",
            )
            for curve in own
        ],
    )


def _surest(learner: Learner) -> Learner:
    if isinstance(learner, FromQueries):
        return replace(learner, learner=replace(learner.learner, sample=False))
    assert isinstance(learner, FromVectors)
    return replace(learner, sample=False)


def _base(name: str) -> str:
    return name.split(".")[0]


def _success(curve: Curve) -> tuple[float, float]:
    return curve.end.delivered.value, curve.end.score.value
