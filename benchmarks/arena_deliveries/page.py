"""The page of `benchmarks/arenas.py`."""

from collections.abc import Sequence

import numpy as np
from backend_agreement.paired_tables import mcnemar

from arena_deliveries.recalls import COMPILED, FOODS, GROUPS, ONE_THIRD_EACH, PYMUNK, Delivery
from khepera_forage.estimates import Column, Measure, Table, Value, holm, mean, pick
from khepera_forage.sim.arenas.named import FAMILY
from khepera_forage.study import Page

GOALS = {"PICKABLE": 98.0, "PUSHABLE": 95.0}
"""Percent of the food that is to be delivered."""
DELIVERED = Measure[Delivery](
    "delivered (%)", lambda row: 100.0 * row.delivered, lambda row: row.deliverable, digits=2
)
PROCEDURAL = "all procedural"


def page(rows: Sequence[Delivery], levels: int, recalls: int, rng: np.random.Generator) -> Page:
    """The page.

    Args:
        rows: All recalls.
        levels: Test levels of each difficulty.
        recalls: Recalls in each named arena.
        rng: For intervals.
    """
    text = (
        f"The teacher forages with the laboratory's noise in every arena of the family ({recalls} recalls a line) and "
        f"in {levels} procedural arenas of each difficulty (one recall each, with the noise of the difficulty). The "
        "same seeds are used on both backends. An episode ends at the step limit of its environment. Brackets: 95 % "
        "intervals, bootstrapped over procedural arenas, or over recalls in a single arena."
    )
    return Page(
        "Does the teacher find its way?",
        [text, _deliveries(rows, rng), _poison(rows), _agreement(rows)],
    )


def _groups(rows: Sequence[Delivery], **values: str) -> list[tuple[str, list[Delivery]]]:
    """Each group with its rows, and all procedural arenas together."""
    groups = [(group, pick(rows, group=group, **values)) for group in GROUPS]
    together = [row for group, own in groups if group not in FAMILY for row in own]
    return [*groups, (PROCEDURAL, together)]


def _deliveries(rows: Sequence[Delivery], rng: np.random.Generator) -> Table:
    lines: list[tuple[Value, ...]] = []
    for food, goal in GOALS.items():
        for group, own in _groups(rows, food=food):
            sides = [pick(own, backend=backend) for backend in (PYMUNK, COMPILED)]
            shares = [mean(side, DELIVERED, rng) for side in sides]
            steps = [float(np.median([row.steps for row in side])) for side in sides]
            met = "yes" if min(share.value for share in shares) >= goal else "no"
            lines.append((food, group, *shares, goal, met, *steps))
    columns = (
        *map(Column, ("food", "arenas")),
        *(Column(f"{backend}: delivered (%)", 2, estimate=True) for backend in (PYMUNK, COMPILED)),
        Column("goal (%)", 0),
        Column("met"),
        *(Column(f"{backend}: median steps", 0) for backend in (PYMUNK, COMPILED)),
    )
    note = "Share of the food that is brought home, when all food is of one type."
    return Table("deliveries", "Food delivered", note, columns, lines)


def _poison(rows: Sequence[Delivery]) -> Table:
    lines: list[tuple[Value, ...]] = []
    for group, own in _groups(rows, food=ONE_THIRD_EACH):
        for backend in (PYMUNK, COMPILED):
            side = pick(own, backend=backend)
            totals = [
                sum(getattr(row, name) for row in side)
                for name in ("deliverable", "delivered", "poisonous", "poison_home")
            ]
            lines.append((group, backend, *totals))
    columns = tuple(
        map(Column, ("arenas", "backend", "deliverable", "delivered", "poisonous", "poison brought home"))
    )
    note = "Food objects of all recalls, when each is pickable, pushable or poisonous with equal odds."
    return Table("poison", "Poisonous food", note, columns, lines)


def _agreement(rows: Sequence[Delivery]) -> Table:
    lines: list[tuple[Value, ...]] = []
    for food in FOODS:
        for group, own in _groups(rows, food=food):
            sides = (pick(own, backend=PYMUNK), pick(own, backend=COMPILED))
            complete = [
                (a.delivered == a.deliverable, b.delivered == b.deliverable)
                for a, b in zip(*sides, strict=True)
            ]
            outcomes = ((True, True), (True, False), (False, True), (False, False))
            counts = [complete.count(outcome) for outcome in outcomes]
            lines.append((food, group, *counts, mcnemar(counts[1], counts[2])))
    corrected = holm([float(str(line[-1])) for line in lines])
    columns = (
        *map(Column, ("food", "arenas", "both", "pymunk only", "compiled only", "neither")),
        Column("p", 3),
        Column("corrected p", 3),
    )
    note = (
        "Recalls in which everything is delivered, by backend. Noise is drawn independently on the two backends. p: "
        f"McNemar's exact test, corrected by Holm's rule for the {len(lines)} lines; the backends differ below 0.05."
    )
    table = [(*line, p) for line, p in zip(lines, corrected, strict=True)]
    return Table("backends", "Agreement of the backends", note, columns, table)
