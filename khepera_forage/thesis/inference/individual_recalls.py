"""Individual recalls, of ours and of the thesis: are both from one distribution?"""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.stats import ks_2samp

from khepera_forage.thesis.design import THESIS
from khepera_forage.thesis.inference.summary import CellRecalls, usable_lines, usable_places

Floats = NDArray[np.float64]


class IndividualRecalls(NamedTuple):
    """All recalls in an arena; each array has the shape (experiments, recalls).

    Attributes:
        score: Percent.
        steps: Steps.
        right: Share of correct steps, percent.
    """

    score: Floats
    steps: Floats
    right: Floats


INDIVIDUAL = {"score": "score (%)", "steps": "steps", "right": "right steps (%)"}
"""The measures, and how they are called on pages."""


def of_arena(cells: Sequence[CellRecalls], arena: str) -> IndividualRecalls:
    """Recalls of all cells of an arena: as many of each set of files as the thesis has usable lines.

    Args:
        cells: One element a cell of `THESIS`.
        arena: `corridor` or `rectangle`.
    """
    own = [
        (recalls, usable_places(cell))
        for cell, recalls in zip(THESIS, cells, strict=True)
        if cell.arena == arena
    ]
    return IndividualRecalls(
        *(
            np.concatenate(
                [
                    getattr(recalls, name).reshape(len(recalls.steps), -1)[:, places]
                    for recalls, places in own
                ],
                axis=1,
            )
            for name in INDIVIDUAL
        )
    )


def of_thesis(arena: str) -> IndividualRecalls:
    """The thesis's lines for an arena, as one experiment, without those that contradict themselves."""
    rows = [row for cell in THESIS if cell.arena == arena for row in usable_lines(cell)]
    right = [100.0 * row.correct / row.total for row in rows]
    scores = [math.floor(share) - row.points for share, row in zip(right, rows, strict=True)]
    steps = [row.total for row in rows]
    return IndividualRecalls(*(np.array([values], dtype=np.float64) for values in (scores, steps, right)))


def p_value(thesis: Floats, experiments: Floats) -> float:
    """Probability that an experiment lies at least as far from the rest as the thesis does.

    Recalls of an experiment share their training files and are not independent. So the thesis is compared with whole
    experiments of ours, and not with as many independent recalls.

    Args:
        thesis: A measure of the thesis's recalls.
        experiments: The same of ours, shape (experiments, recalls).
    """
    own = np.array([_distance(row, experiments) for row in experiments])
    return float((1 + (own >= _distance(thesis, experiments) - 1e-12).sum()) / (1 + len(own)))


def _distance(one: Floats, other: Floats) -> float:
    """Kolmogorov and Smirnov's: the largest difference between two empirical distribution functions, 0 to 1."""
    return float(ks_2samp(one.ravel(), other.ravel(), method="asymp").statistic)
