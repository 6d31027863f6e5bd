"""The outcome as a page, a table for machines and a picture."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from _agreement.comparing import LEVEL, Comparison, Power, holm
from _agreement.samples import CONDITIONS, MEMORIES, SLOW, TRAININGS, Condition, Sample
from khepera_forage.thesis.figures import GREY, OURS, THESIS, new_figure
from khepera_forage.thesis.tables import Column, Table

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_COLUMNS = (
    Column("policy"),
    Column("arena"),
    Column("measure"),
    Column("pymunk", digits=2, estimate=True),
    Column("batch", digits=2, estimate=True),
    Column("difference", digits=2, estimate=True),
    Column("p of means", digits=3),
    Column("p of shapes", digits=3),
    Column("corrected: means", digits=3),
    Column("corrected: shapes", digits=3),
)
_POWER_COLUMNS = (
    Column("policy"),
    Column("arena"),
    Column("found by means (%)", estimate=True),
    Column("found by shapes (%)", estimate=True),
    Column("false alarm by means (%)", estimate=True),
    Column("false alarm by shapes (%)", estimate=True),
)


def compared(results: Sequence[Comparison], pymunk: int, batch: int) -> Table:
    """Both simulators side by side, nothing planted."""
    note = (
        f"{pymunk:,} recalls in pymunk and {batch:,} in the batch of every line, noise of the laboratory, the thesis' "
        f"arenas, food and limits, random starts. The imitator is {MEMORIES} imitators that take turns, of {TRAININGS} "
        "training episodes each, the same ones in both. In brackets: 95 % intervals. Means: Welch's test; shapes: that "
        "of Kolmogorov and Smirnov, whose p is too large for counts with many ties, never too small. Corrected by "
        f"Holm's rule for the {2 * len(results)} tests of this table. {verdict(results)}"
    )
    ps = [p for result in results for p in (result.p_mean, result.p_shape)]
    corrected = holm(ps)
    rows = [
        (*result.condition, result.measure, *result[3:], corrected[2 * k], corrected[2 * k + 1])
        for k, result in enumerate(results)
    ]
    return Table("agreement", "The batch against pymunk", note, _COLUMNS, rows)


def verdict(results: Sequence[Comparison]) -> str:
    """What the corrected tests find, in a sentence."""
    corrected = holm([p for result in results for p in (result.p_mean, result.p_shape)])
    found = [
        f"{result.measure} of the {result.condition.policy} in the {result.condition.arena}"
        for k, result in enumerate(results)
        if min(corrected[2 * k : 2 * k + 2]) < LEVEL
    ]
    if not found:
        return "No test finds a difference."
    return f"A difference is found in: {', '.join(found)}."


def planted(results: Sequence[Comparison]) -> Table:
    """Both simulators side by side, the batch's wheels slow."""
    note = (
        f"The same with a planted difference: in the batch wheels reach {100 * SLOW:g} % of the speed they are told. "
        "Not corrected for the number of tests."
    )
    rows = [(*result.condition, result.measure, *result[3:]) for result in results]
    return Table("planted", "Wheels 2 % slow", note, _COLUMNS[:-2], rows)


def surely(results: Sequence[Power], repeats: int) -> Table:
    """How surely a planted difference is found."""
    note = (
        f"Share of {repeats} repeated samples, as large as above and drawn with replacement from what the batch has "
        f"played, in which the steps of recalls tell wheels 2 % slow from others at the {100 * LEVEL:g} % level; and, "
        "as false alarms, from wheels that are alike. In brackets: Wilson's 95 % intervals."
    )
    rows = [(*result.condition, *result[1:]) for result in results]
    return Table("power", "How surely it would be found", note, _POWER_COLUMNS, rows)


def picture(samples: Mapping[tuple[Condition, str], Sample]) -> "Figure":
    """The distributions of steps and of scores; `samples` by condition and `pymunk`, `batch` or `slow`."""
    figure = new_figure(12.0, 5.6)
    axes = figure.subplots(2, len(CONDITIONS))
    styles = (
        ("pymunk", "pymunk", {"color": GREY, "lw": 3.2, "alpha": 0.6}),
        ("slow", "batch, wheels 2 % slow", {"color": THESIS, "lw": 1.0, "ls": "--"}),
        ("batch", "batch", {"color": OURS, "lw": 1.2}),
    )
    for column, condition in enumerate(CONDITIONS):
        for row, measure in enumerate(("steps", "score")):
            panel = axes[row][column]
            for kind, label, style in styles:
                values = np.sort(getattr(samples[condition, kind], measure))
                shares = 100 * np.arange(1, len(values) + 1) / len(values)
                panel.plot(
                    np.append(values[:1], values),
                    np.append(0, shares),
                    label=label,
                    drawstyle="steps-post",
                    **style,
                )
            panel.grid(color="0.9")
            panel.set_xlabel("steps of a recall" if measure == "steps" else "score (%)", fontsize=9)
            panel.tick_params(labelsize=8)
            if measure == "score":
                panel.set_xlim(-24, 104)
        axes[0][column].set_title(" in the ".join(condition), fontsize=10)
    for row in range(2):
        axes[row][0].set_ylabel("recalls with at most that (%)", fontsize=9)
    axes[0][0].legend(fontsize=8, loc="lower right")
    return figure
