"""Other settings of the learners, the same number for each, compared with those of the registry.

The comparison has replications of its own, in the corridor, after the largest amount of learning.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from khepera_forage.comparison.learning import ARENAS, Compared, RecallBatch, settings_of
from khepera_forage.comparison.results import DELIVERED, Curve, curves
from khepera_forage.estimates import UNKNOWN, Column, Estimate, Table, difference, interval, pick
from khepera_forage.policies.learners import LEARNERS, FromQueries, FromVectors, Learner
from khepera_forage.study import Page

FIRST_REPLICATION = 1_000
"""Replications from this number on are for tuning, those before it for the comparison of learners."""
ROUNDING = 1e-9
"""Points of the food; smaller differences are rounding."""
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
        learner = LEARNERS[name]
        found[name] = learner
        for number, change in enumerate(changes, 1):
            found[f"{name}.{number}"] = replace(learner, settings={**learner.settings, **change})
        found[f"{name}.{len(changes) + 1}"] = _most_probable(learner)
    return found


def differences(rows: Sequence[RecallBatch], seed: int) -> dict[str, Estimate]:
    """Points of the food that each other setting delivers more than the registry's, over the same replications.

    Args:
        rows: Of candidates, in the order of `in_order`.
        seed: Of the resamples.
    """
    own: dict[str, list[RecallBatch]] = {}
    for row in pick(rows, arena=ARENAS[0]):
        own.setdefault(row.learner, []).append(row)
    return {
        name: difference(theirs, own[_base(name)], DELIVERED, np.random.default_rng(seed))
        for name, theirs in own.items()
        if name != _base(name)
    }


def result(gains: Mapping[str, Estimate], learners: Mapping[str, Compared]) -> str:
    """Which other settings are better or worse than the registry's, judged by the interval of the difference."""
    better = [name for name, gain in gains.items() if gain.low > ROUNDING]
    worse = [name for name, gain in gains.items() if gain.high < -ROUNDING]
    named = "; ".join(
        f"{learners[name].title} with `{settings_of(learners[name])}`, {interval(gains[name])} points more"
        for name in better
    )
    return (
        f"{len(gains)} other settings were compared. Settings that deliver more food than the registry's, with a 95 % "
        f"interval of the difference above 0: {len(better)}{f' ({named})' if named else ''}. Settings that deliver "
        f"less: {len(worse)}. Without any true difference, one setting in forty would appear better by chance. The "
        "registry's settings stay as they are."
    )


def page(rows: Sequence[RecallBatch], learners: Mapping[str, Compared], seed: int) -> Page:
    """The result and the table."""
    gains = differences(rows, seed)
    table = _table(curves(rows, seed), gains, learners)
    return Page("Settings of the learners", [f"## Results\n\n{result(gains, learners)}", table])


def _table(found: Sequence[Curve], gains: Mapping[str, Estimate], learners: Mapping[str, Compared]) -> Table:
    """All candidates in the corridor, the best of each learner marked."""
    own = [curve for curve in found if curve.arena == ARENAS[0]]
    best: dict[str, Curve] = {}
    for curve in own:
        if _success(curve) > _success(best.setdefault(_base(curve.learner), curve)):
            best[_base(curve.learner)] = curve
    rows = [
        (
            learners[curve.learner].title,
            settings_of(learners[curve.learner]),
            curve.end.delivered,
            gains.get(curve.learner, UNKNOWN),
            curve.end.score,
            "best" if best[_base(curve.learner)] is curve else "",
        )
        for curve in own
    ]
    return Table(
        "tuning",
        "Settings compared",
        "In the corridor, after the largest amount of learning. Means with 95 % intervals, over replications that the "
        "comparison of learners does not use. The first line of each learner has the settings of the registry. More: "
        "points of the food delivered more than with those, over the same replications. Best: most food, then score.",
        (
            Column("learner"),
            Column("settings"),
            Column("food delivered (%)", estimate=True),
            Column("more (points)", estimate=True),
            Column("score (%)", estimate=True),
            Column("best"),
        ),
        rows,
    )


def _most_probable(learner: Learner) -> Learner:
    if isinstance(learner, FromQueries):
        return replace(learner, learner=replace(learner.learner, sample=False))
    assert isinstance(learner, FromVectors)
    return replace(learner, sample=False)


def _base(name: str) -> str:
    return name.split(".")[0]


def _success(curve: Curve) -> tuple[float, float]:
    return curve.end.delivered.value, curve.end.score.value
