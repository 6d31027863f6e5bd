"""The results of each cell: the thesis's, ours, and the rank of the thesis's among ours."""

from collections import defaultdict
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from khepera_forage.estimates import (
    RESAMPLES,
    Estimate,
    PercentileRank,
    bootstrap,
    percentile_rank,
    ratio,
    replications,
    sums_by_replication,
)
from khepera_forage.rollouts.rows import IMITATOR, RecallRow
from khepera_forage.thesis import appendix_a
from khepera_forage.thesis.design import THESIS, Cell


@dataclass(frozen=True, slots=True)
class CellResult:
    """One table of appendix A and our replications of it.

    Attributes:
        cell: The arena and the amount of training.
        thesis_printed: The thesis's printed mean score, in percent.
        thesis_score: The mean of the scores in the thesis's lines; it differs where the printed mean is wrong.
        thesis_food: Food objects carried home in the thesis, of `cell.available`.
        score: Our mean score, in percent.
        food: Our mean number of food objects carried home, per experiment of the thesis's size.
        scores: Our mean score in each complete replication, an experiment of the thesis's size.
        foods: Food objects carried home in each complete replication.
        recalls: Number of our recall episodes.
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
    def score_rank(self) -> PercentileRank:
        """The rank of the thesis's mean score among our experiments."""
        return percentile_rank(self.thesis_score, self.scores)

    @property
    def food_rank(self) -> PercentileRank:
        """The rank of the thesis's food count among our experiments."""
        return percentile_rank(self.thesis_food, self.foods)


def in_cell(rows: Iterable[RecallRow], cell: Cell) -> list[RecallRow]:
    """The recall episodes of the imitator in one cell."""
    return [r for r in rows if (r.learner, r.arena, r.episodes) == (IMITATOR, cell.arena, cell.episodes)]


def cell_results(
    recalls: Sequence[RecallRow],
    rng: np.random.Generator,
    resamples: int = RESAMPLES,
) -> list[CellResult]:
    """The result of every cell; rows of other policies than the imitator are ignored."""
    return [_result(in_cell(recalls, cell), cell, rng, resamples) for cell in THESIS]


def _result(rows: list[RecallRow], cell: Cell, rng: np.random.Generator, resamples: int) -> CellResult:
    numbers = replications(rows)
    sums = sums_by_replication(
        rows, numbers, lambda row: row.score, lambda row: row.delivered, lambda row: 1.0
    )
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
