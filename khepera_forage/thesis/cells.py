"""The results of each cell of the thesis: its figures, ours, and where its figures lie among ours."""

from collections import defaultdict
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from khepera_forage.rollouts.rows import IMITATOR, RecallRow
from khepera_forage.thesis import appendix_a
from khepera_forage.thesis.design import THESIS, Cell
from khepera_forage.thesis.statistics import (
    RESAMPLES,
    Estimate,
    Standing,
    bootstrap,
    ratio,
    replications,
    standing,
    tally,
)


@dataclass(frozen=True, slots=True)
class CellResult:
    """One table of appendix A beside our replications of it.

    Attributes:
        cell: What was done.
        thesis_printed: The mean score that the table prints, in percent.
        thesis_score: The mean of the scores printed in its lines: another where the thesis erred.
        thesis_food: Food objects carried home, of `cell.available`.
        score: Our mean score, in percent.
        food: Our food carried home per experiment of the same size.
        scores: Mean score of each experiment of the same size, one a complete replication.
        foods: Food carried home in each of them.
        recalls: Recall episodes we ran.
    """

    cell: Cell
    thesis_printed: float
    thesis_score: float
    thesis_food: int
    score: Estimate
    food: Estimate
    scores: tuple[float, ...]
    foods: tuple[int, ...]
    recalls: int

    @property
    def score_standing(self) -> Standing:
        """Where the thesis' mean score lies among our experiments."""
        return standing(self.thesis_score, self.scores)

    @property
    def food_standing(self) -> Standing:
        """Where the thesis' food count lies among our experiments."""
        return standing(self.thesis_food, self.foods)


def in_cell(rows: Iterable[RecallRow], cell: Cell) -> list[RecallRow]:
    """The imitator's recall episodes that belong to one cell."""
    return [r for r in rows if (r.learner, r.arena, r.episodes) == (IMITATOR, cell.arena, cell.episodes)]


def cell_results(
    recalls: Sequence[RecallRow],
    rng: np.random.Generator,
    cells: Sequence[Cell] = THESIS,
    resamples: int = RESAMPLES,
) -> list[CellResult]:
    """The result of every cell.

    Args:
        recalls: Rows of the imitator; of others, which are left out.
        rng: Draws the resamples.
        cells: The design.
        resamples: How many.
    """
    return [_result(in_cell(recalls, cell), cell, rng, resamples) for cell in cells]


def _result(rows: list[RecallRow], cell: Cell, rng: np.random.Generator, resamples: int) -> CellResult:
    numbers = replications(rows)
    sums = tally(rows, numbers, lambda row: row.score, lambda row: row.delivered, lambda row: 1.0)
    score = bootstrap(sums[:, [0, 2]], ratio, rng, resamples)
    food = bootstrap(sums[:, [1, 2]], ratio, rng, resamples)
    experiments: dict[int, list[RecallRow]] = defaultdict(list)
    for row in rows:
        experiments[row.replication].append(row)
    whole = [group for _, group in sorted(experiments.items()) if len(group) == cell.size]
    table = appendix_a.table_of(cell.arena, cell.episodes)
    return CellResult(
        cell=cell,
        thesis_printed=float(table.average),
        thesis_score=appendix_a.mean_score(appendix_a.rows_of(table)),
        thesis_food=table.collected,
        score=score,
        food=Estimate(*(cell.size * value for value in food)),
        scores=tuple(sum(row.score for row in group) / cell.size for group in whole),
        foods=tuple(sum(row.delivered for row in group) for group in whole),
        recalls=len(rows),
    )
