"""The page of the teacher's forages: a table and a picture."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

from khepera_forage.estimates import Column, Estimate, Table, percent, pick, quantiles
from khepera_forage.figures import (
    OURS,
    SMALL,
    THESIS,
    WIDTH,
    entry,
    grid,
    legend,
    mark,
    new_figure,
)
from khepera_forage.study import Page, Picture
from khepera_forage.task.states import FoodType
from teacher_alone.forages import CONDITIONS, NO_ORIENT, Condition, Forage

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_NOTE = (
    "Noise of the laboratory; the thesis's limits of 500 and 700 steps; the same random starts for every line of an "
    "arena. Shares are percentages with Wilson's 95 % interval. Shares of food treat two objects in one arena as "
    "independent; shares of forages need no such assumption. Settled: delivered, or known to be poisonous and left "
    "where it was. A forage is finished when all its food is settled or poison was brought home. Steps: median and, in "
    "brackets, 5th and 95th percentile of all forages, including those that reached the limit. The lines without "
    "ORIENT are a check: they must deliver nothing."
)


def page(rows: Sequence[Forage]) -> Page:
    """A table and a picture of all conditions."""
    columns = (
        Column("arena"),
        Column("food"),
        Column("policy"),
        Column("forages"),
        Column("food objects"),
        Column("food delivered (%)", estimate=True),
        Column("food settled (%)", estimate=True),
        Column("forages finished (%)", estimate=True),
        Column("poison brought home"),
        Column("steps", digits=0, estimate=True),
    )
    own = {condition: pick(rows, **condition._asdict()) for condition in CONDITIONS}
    table = Table(
        "teacher", "The teacher alone", _NOTE, columns, [(*c, *_summary(own[c])) for c in CONDITIONS]
    )
    return Page(
        "The teacher", [table, Picture("teacher", "food delivered and steps of a forage", _picture(own))]
    )


def _summary(rows: Sequence[Forage]) -> tuple[int | Estimate, ...]:
    foods = sum(row.foods for row in rows)
    return (
        len(rows),
        foods,
        percent(sum(row.delivered for row in rows), foods),
        _settled(rows),
        percent(sum(row.finished for row in rows), len(rows)),
        sum(row.poison_home for row in rows),
        quantiles([row.steps for row in rows]),
    )


def _settled(rows: Sequence[Forage]) -> Estimate:
    return percent(sum(row.delivered + row.left for row in rows), sum(row.foods for row in rows))


def _picture(own: dict[Condition, list[Forage]]) -> "Figure":
    figure = new_figure(WIDTH, 1.1 + 0.42 * len(own))
    left, right = figure.subplots(1, 2, sharey=True)
    for place, (condition, rows) in enumerate(reversed(own.items())):
        colour, marker = (THESIS, "s") if condition.policy == NO_ORIENT else (OURS, "o")
        # Without ORIENT food may lie about untouched: only the teacher's poison counts as settled when it is left.
        delivered = percent(sum(row.delivered for row in rows), sum(row.foods for row in rows))
        share = _settled(rows) if condition.food == FoodType.POISONOUS.name else delivered
        steps = quantiles([row.steps for row in rows])
        mark(left, share.value, place, share, colour, level=True, marker=marker)
        mark(right, steps.value, place, steps, colour, level=True, marker=marker)
    names = [f"{condition.arena}, {condition.food.lower()} food" for condition in reversed(own)]
    left.set_yticks(range(len(names)), names, fontsize=SMALL)
    left.set_ylim(-0.6, len(names) - 0.4)
    left.set_xlim(-4, 104)
    left.set_xlabel("food delivered, poison left alone (%)\nbars: Wilson's 95 % interval", fontsize=9)
    right.set_xlim(left=0)
    right.set_xlabel("steps of a forage (median)\nbars: 5th to 95th percentile", fontsize=9)
    entry(left, "teacher", OURS, "o")
    entry(left, "teacher that searches in place of orienting", THESIS, "s")
    grid(left, "x")
    grid(right, "x")
    count = len(next(iter(own.values())))
    legend(figure, left, f"{count} random starts each, noise of the laboratory")
    return figure
