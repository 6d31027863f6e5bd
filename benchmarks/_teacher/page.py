"""The outcome as a table and as a picture."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from _teacher.forages import CONDITIONS, NO_ORIENT, Condition, Forage
from khepera_forage.task.states import FoodType
from khepera_forage.thesis.figures import GREY, OURS, THESIS, mark, new_figure
from khepera_forage.thesis.statistics import Estimate, wilson
from khepera_forage.thesis.tables import Column, Table

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_NOTE = (
    "Noise of the laboratory, the thesis' limits (500 and 700 steps), the same random starts for every line of an "
    "arena. Shares are percentages with Wilson's 95 % interval; those of food take two objects in one arena for "
    "independent, those of forages need no such assumption. Settled: delivered, or known to be poisonous and left. "
    "A forage is finished when all its food is settled or was poison brought home. Steps: median and, in brackets, the "
    "5th and 95th percentile of all forages, those at the limit included. Without ORIENT the task must be impossible: "
    "that line is the check on it."
)
_COLUMNS = (
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


class Summary(NamedTuple):
    """What came of a condition; shares in percent."""

    condition: Condition
    forages: int
    foods: int
    delivered: Estimate
    settled: Estimate
    finished: Estimate
    poison_home: int
    steps: Estimate


def summaries(rows: Sequence[Forage]) -> list[Summary]:
    """One a condition."""
    return [
        _summary(condition, [row for row in rows if (row.arena, row.food, row.policy) == condition])
        for condition in CONDITIONS
    ]


def table(results: Sequence[Summary]) -> Table:
    """All conditions."""
    rows = [(*result.condition, *result[1:]) for result in results]
    return Table("teacher", "The teacher alone", _NOTE, _COLUMNS, rows)


def picture(results: Sequence[Summary]) -> "Figure":
    """Food settled (delivered, for the teacher without ORIENT) and steps."""
    figure = new_figure(8.6, 0.9 + 0.42 * len(results))
    left, right = figure.subplots(1, 2, sharey=True)
    for place, result in enumerate(reversed(results)):
        colour = THESIS if result.condition.policy == NO_ORIENT else OURS
        share = result.settled if result.condition.food == FoodType.POISONOUS.name else result.delivered
        mark(left, share.value, place, share, colour, level=True)
        mark(right, result.steps.value, place, result.steps, colour, level=True)
    names = [" ".join(result.condition) for result in reversed(results)]
    left.set_yticks(range(len(names)), names, fontsize=8)
    left.set_ylim(-0.6, len(names) - 0.4)
    left.set_xlim(-4, 104)
    left.set_xlabel("food delivered; poison: left where it is (%)\nbars: Wilson's 95 % interval", fontsize=9)
    right.set_xlim(left=0)
    right.set_xlabel("steps of a forage\nbars: 5th to 95th percentile", fontsize=9)
    for axes in (left, right):
        axes.grid(axis="x", color="0.9")
    figure.supxlabel(
        f"{results[0].forages} random starts each, noise of the laboratory", fontsize=8, color=GREY
    )
    return figure


def _summary(condition: Condition, rows: Sequence[Forage]) -> Summary:
    foods = sum(row.foods for row in rows)
    delivered = sum(row.delivered for row in rows)
    low, median, high = np.percentile([row.steps for row in rows], (5, 50, 95)).tolist()
    return Summary(
        condition,
        len(rows),
        foods,
        _percent(delivered, foods),
        _percent(delivered + sum(row.left for row in rows), foods),
        _percent(sum(row.finished for row in rows), len(rows)),
        sum(row.poison_home for row in rows),
        Estimate(median, low, high),
    )


def _percent(successes: int, trials: int) -> Estimate:
    return Estimate(*(100 * value for value in wilson(successes, trials)))
