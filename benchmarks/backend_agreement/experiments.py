"""The thesis's experiments on both backends: training and recalls, each backend with training files of its own."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from tqdm import tqdm

from backend_agreement.two_sample_tests import LEVEL, mean_of, welch
from khepera_forage.estimates import Column, Estimate, Table, holm, replications, sums_by_replication
from khepera_forage.rollouts.rows import RecallRow
from khepera_forage.task.decisions import DEFAULT_DECISIONS
from khepera_forage.thesis.cells import in_cell
from khepera_forage.thesis.design import THESIS, Cell
from khepera_forage.thesis.jobs import JobCounts, compiled_jobs
from khepera_forage.thesis.replication import Replication

QUICK_DESIGN = tuple(replace(cell, subsets=cell.subsets[:2], recalls=1) for cell in THESIS)
"""With `--quick`: one recall of two learners in every cell."""
COMPILED_FACTOR = 20
"""Compiled replications for each one with pymunk."""
MEASURES: Mapping[str, Callable[[RecallRow], float]] = {
    "score (%)": lambda row: row.score,
    "food": lambda row: row.delivered,
    "steps": lambda row: row.steps,
    "vectors": lambda row: row.experience_size,
}
"""What is compared: means over the recalls of an experiment."""
_COLUMNS = (
    *map(Column, ("arena", "episodes", "measure")),
    *(Column(name, 2, estimate=True) for name in ("pymunk", "compiled", "difference")),
    *(Column(name, 3) for name in ("p", "corrected p")),
)


class CellMeasure(NamedTuple):
    """One measure of one cell on both backends.

    Attributes:
        arena: `corridor` or `rectangle`.
        episodes: Training episodes.
        measure: A name of `MEASURES`.
        pymunk: Mean over replications, with its 95 % interval.
        compiled: The same.
        difference: Compiled minus pymunk.
        p: Of equal means (Welch's test).
    """

    arena: str
    episodes: int
    measure: str
    pymunk: Estimate
    compiled: Estimate
    difference: Estimate
    p: float


class Experiment(NamedTuple):
    """One replication of the thesis's design with pymunk: ten training files, and recalls in every cell.

    Attributes:
        seed: Of the benchmark.
        number: Of the replication.
        cells: With fewer learners and recalls to do the same in small.
    """

    seed: int
    number: int
    cells: tuple[Cell, ...] = THESIS

    @property
    def key(self) -> str:
        """Number of the replication."""
        return f"experiment {self.number}"

    def run(self) -> Sequence[RecallRow]:
        """Train, and return the recalls."""
        return Replication(self.seed, self.number, cells=self.cells).run().recalls


def compiled_experiments(seed: int, count: int) -> list[RecallRow]:
    """The recalls of compiled replications."""
    jobs = compiled_jobs(seed, JobCounts(count, 0, (), 0, 0), DEFAULT_DECISIONS)
    return [row for job in tqdm(jobs, "compiled experiments", disable=None) for row in job.run().recalls]


def experiments_table(pymunk: Sequence[RecallRow], compiled: Sequence[RecallRow]) -> Table:
    """All measures of all cells on both backends."""
    results = [
        _compare(pymunk, compiled, cell, measure, value)
        for cell in THESIS
        for measure, value in MEASURES.items()
    ]
    corrected = holm([result.p for result in results])
    different = [
        f"{result.measure} in the {result.arena} after {result.episodes} episodes"
        for result, p in zip(results, corrected, strict=True)
        if p < LEVEL
    ]
    verdict = f"Differences: {', '.join(different)}." if different else "No test detects a difference."
    counts = (len(replications(rows)) for rows in (pymunk, compiled))
    note = (
        "{:,} replications of the thesis's design with pymunk and {:,} compiled, each with ten training files of its "
        "own backend. Score, food and steps: per recall. Vectors: in the imitator's experience. Brackets: 95 % "
        "intervals over replications. Welch's test, corrected by Holm's rule for the "
        f"{len(results)} lines. {verdict}"
    ).format(*counts)
    rows = [(*result, p) for result, p in zip(results, corrected, strict=True)]
    return Table("experiments", "The thesis's experiments", note, _COLUMNS, rows)


def _compare(
    pymunk: Sequence[RecallRow],
    compiled: Sequence[RecallRow],
    cell: Cell,
    measure: str,
    value: Callable[[RecallRow], float],
) -> CellMeasure:
    a, b = (_by_experiment(rows, cell, value) for rows in (pymunk, compiled))
    return CellMeasure(cell.arena, cell.episodes, measure, mean_of(a), mean_of(b), *welch(a, b))


def _by_experiment(
    rows: Sequence[RecallRow], cell: Cell, value: Callable[[RecallRow], float]
) -> NDArray[np.float64]:
    """The mean of a measure in each replication of a cell."""
    own = in_cell(rows, cell)
    sums = sums_by_replication(own, replications(own), value, lambda _: 1.0)
    return sums[:, 0] / sums[:, 1]
