"""The tables and the picture of the page."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from backend_agreement.arenas import MOST_FOODS, MOST_OBSTACLES
from backend_agreement.paired import ODDS
from backend_agreement.paired import TRAININGS as IMITATOR_TRAININGS
from backend_agreement.samples import CONDITIONS, SLOW, TRAININGS, Condition, Sample
from backend_agreement.two_sample_tests import LEVEL, Comparison, Power
from khepera_forage.estimates import Column, Table, holm
from khepera_forage.figures import (
    GREY,
    OURS,
    SMALL,
    THESIS,
    WIDTH,
    grid,
    legend,
    new_figure,
    padded,
)

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_COLUMNS = (
    Column("policy"),
    Column("arena"),
    Column("measure"),
    Column("pymunk", digits=2, estimate=True),
    Column("compiled", digits=2, estimate=True),
    Column("difference", digits=2, estimate=True),
    Column("p of means", digits=3),
    Column("p of distributions", digits=3),
    Column("corrected: means", digits=3),
    Column("corrected: distributions", digits=3),
)
_POWER_COLUMNS = (
    Column("policy"),
    Column("arena"),
    Column("detected by means (%)", estimate=True),
    Column("detected by distributions (%)", estimate=True),
    Column("false alarm by means (%)", estimate=True),
    Column("false alarm by distributions (%)", estimate=True),
)

_SHOWN = {"steps": "steps of a recall", "score": "score (%)"}
"""Measures in the picture."""
SUMMARY = (
    "After reading this page you know how well the two backends agree, where and why they differ, and whether the "
    "current code gives the results of version 0.1 under its decisions."
)
REASONS = """### Where the backends differ

Recalls with the same seed begin alike and then part, even without noise. The state vector is in whole pixels, so a
fraction of a millimetre changes a decision, and the next decisions follow from that one. Only rates can be compared.
These differences remain:

- **Pushed food slides on in pymunk only.** A learner that misses ORIENT turns and closes its jaw while food stands
  between its open fingers. In pymunk a finger then flings the food a little: in a quick turn it moves outward by 1 to 2
  mm a round, and the barrier or the closing fingers miss it. The compiled backend computes no forces, so the food stays
  where the finger leaves it. The imitator therefore delivers a little more there, above all in wide arenas. The
  teacher never does this, and does not differ. The check that showed the cause (no script repeats it): 60 imitators of
  ten training episodes each, 2,400 recalls in the rectangle from the same starts. They deliver 0.82 objects with
  pymunk and 0.85 compiled, a difference of 0.03 [0.01, 0.06], in 14 [8, 19] steps less. With ten times the friction
  between food and floor, so that food stops at once in pymunk too, the difference in food is 0.00 [-0.02, 0.03].
- **Corners of obstacles.** In pymunk the two sides of a corner are separate walls, and bodies may overlap a wall by
  0.1 mm. Carried food or a finger that slides along one side therefore catches on the end of the other side. The
  compiled backend moves bodies out of walls completely and has no friction at walls, so the robot slides past the
  corner. This is rare, because the teacher's behaviours pass corners at a distance.
- **Grip.** In pymunk, fingers that close on food beside the middle turn the robot by about half a degree. The compiled
  backend does not turn the robot. Near a corner such a difference can decide on which side of it the robot passes.

Training does not differ: imitators that were trained with pymunk and compiled ones deliver the same in compiled recalls
of the corridor (60 and 600 imitators of ten episodes: 65 [59, 72] and 66 [64, 68] % of the food; no script repeats
it).

Another difference was a defect and is corrected (commit b2e33fb). A compiled finger beyond the end of an obstacle's
wall counted as behind that wall, and the robot was thrown aside by up to 46 mm."""


def random_arenas_text(arenas: int, recalls: int) -> str:
    """What is done in random arenas."""
    odds = ", ".join(f"{100 * share:g} % {food_type.name.lower()}" for food_type, share in ODDS.items())
    return (
        f"{arenas} random arenas take turns: convex and not convex, without obstacles and with one to "
        f"{MOST_OBSTACLES}. Each has one to {MOST_FOODS} food objects ({odds}). Recalls of each policy in each arena: "
        f"{recalls}, with the same seeds on both backends. A seed has the same start, food places and food types on "
        "both. The teacher forages without noise and with the laboratory's. The imitator was trained once, in "
        f"{IMITATOR_TRAININGS} episodes in the compiled corridor with pickable food. A recall ends after 500 steps "
        "with one food object, and 200 more for each further one."
    )


def agreement_table(results: Sequence[Comparison], pymunk: int, compiled: int, imitators: int) -> Table:
    """Both backends side by side.

    Args:
        results: Of every condition and measure.
        pymunk: Recalls under each condition.
        compiled: The same.
        imitators: How many take turns.
    """
    corrected = _corrected(results)
    different = [
        f"{result.measure} of the {' in the '.join(result.condition)}"
        for result, ps in zip(results, corrected, strict=True)
        if min(ps) < LEVEL
    ]
    verdict = f"Differences: {', '.join(different)}." if different else "No test detects a difference."
    note = (
        f"{pymunk:,} recalls with pymunk and {compiled:,} compiled recalls in every line; noise of the laboratory, the "
        f"thesis's arenas, food and limits, random starts. {imitators} imitators of {TRAININGS} training episodes each "
        "take turns, the same on both backends. Brackets: 95 % intervals. Means: Welch's test. Distributions: "
        "Kolmogorov-Smirnov test, whose p-value is too large for counts with many ties, never too small. Corrected by "
        f"Holm's rule for the {2 * len(results)} tests of this table. {verdict}"
    )
    rows = [(*result.condition, *result[1:], *ps) for result, ps in zip(results, corrected, strict=True)]
    return Table("agreement", "Corridor and rectangle", note, _COLUMNS, rows)


def slow_wheels_table(results: Sequence[Comparison]) -> Table:
    """Both backends side by side, with slow wheels in the compiled recalls."""
    note = (
        f"The same with an artificial difference: in the compiled recalls wheels reach {100 * SLOW:g} % of the "
        "commanded speed. Not corrected for the number of tests."
    )
    rows = [(*result.condition, *result[1:]) for result in results]
    return Table("slow_wheels", "Wheels 2 % slow", note, _COLUMNS[:-2], rows)


def power_table(results: Sequence[Power], repeats: int) -> Table:
    """The rates at which the artificial difference is detected."""
    note = (
        f"Share of {repeats} repeated samples, as large as above and drawn with replacement from the compiled recalls, "
        f"in which the steps of recalls differ at the {100 * LEVEL:g} % level with wheels 2 % slow; false alarms: with "
        "equal wheels. Brackets: Wilson's 95 % intervals."
    )
    rows = [(*result.condition, *result[1:]) for result in results]
    return Table("power", "Power of the tests", note, _POWER_COLUMNS, rows)


def picture(samples: Mapping[tuple[Condition, str], Sample]) -> "Figure":
    """The distributions of steps and of scores.

    Args:
        samples: By condition and `pymunk`, `compiled` or `slow`.
    """
    figure = new_figure(WIDTH, 0.7 + 1.9 * len(CONDITIONS))
    axes = figure.subplots(len(CONDITIONS), 2)
    styles = (
        ("pymunk", "pymunk", {"color": GREY, "lw": 3.2, "alpha": 0.6}),
        ("slow", "compiled, wheels 2 % slow", {"color": THESIS, "lw": 1.0, "ls": "--"}),
        ("compiled", "compiled", {"color": OURS, "lw": 1.2}),
    )
    for line, condition in zip(axes, CONDITIONS, strict=True):
        for panel, (measure, label) in zip(line, _SHOWN.items(), strict=True):
            for kind, name, style in styles:
                values = np.sort(getattr(samples[condition, kind], measure))
                shares = 100 * np.arange(len(values) + 1) / len(values)
                panel.plot(np.append(values[:1], values), shares, label=name, drawstyle="steps-post", **style)
            grid(panel, "both")
            panel.set_ylim(*padded(0, 100))
            panel.set_xlabel(label, fontsize=9)
            panel.tick_params(labelsize=SMALL)
            panel.set_title(" in the ".join(condition), fontsize=10)
        line[0].set_ylabel("recalls up to\nthe value (%)", fontsize=9)
        line[1].set_xlim(-24, 104)
    legend(figure, axes[0][0])
    return figure


def _corrected(results: Sequence[Comparison]) -> list[tuple[float, float]]:
    """The corrected p-values of means and of distributions."""
    values = holm([p for result in results for p in (result.p_mean, result.p_distribution)])
    return list(zip(values[::2], values[1::2], strict=True))
