"""The thesis's results: tables A.1 to A.7 as printed, with their errors, and the same figures in chapter 5.

The penalty is normalised: no penalty is a dash (A.5 prints nothing), and other penalties have no percent sign (A.7
prints one). All other values are verbatim. `errata.py` lists the values that contradict each other.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from decimal import Decimal
from functools import cache
from importlib import resources
from typing import TYPE_CHECKING, TypeVar

from khepera_forage.rollouts.row_files import parse_rows

if TYPE_CHECKING:
    from _typeshed import DataclassInstance

_RowT = TypeVar("_RowT", bound="DataclassInstance")

NO_PENALTY = "-"


@dataclass(frozen=True, slots=True)
class PrintedRecall:
    """One line of tables A.1 to A.7: a recall episode.

    Attributes:
        table: `A.1` to `A.7`.
        line: Number of the line in the table, from 1; not printed in the thesis.
        arena: `corridor` or `rectangle`.
        episodes: Training episodes of the learner.
        file_id: The experience files used, as the thesis names them.
        correct: Steps with a correct behaviour.
        total: Steps.
        percent: Correct steps in percent, truncated to an integer.
        penalty: `-20`, `-5` or `-`.
        score: In percent.
    """

    table: str
    line: int
    arena: str
    episodes: int
    file_id: str
    correct: int
    total: int
    percent: int
    penalty: str
    score: int

    def __post_init__(self) -> None:
        if self.penalty not in (NO_PENALTY, "-5", "-20"):
            raise ValueError(f"penalty is {self.penalty!r}; allowed: -, -5 or -20")

    @property
    def points(self) -> int:
        """The penalty as a number: 0, 5 or 20 percentage points."""
        return 0 if self.penalty == NO_PENALTY else -int(self.penalty)

    def delivered(self, foods: int) -> int:
        """Food carried home, derived from the penalty: none at -20, all but one at -5, all without a penalty."""
        return {0: foods, 5: foods - 1, 20: 0}[self.points]


@dataclass(frozen=True, slots=True)
class PrintedSet:
    """The printed average of the recalls with one set of training files (A.4 and A.7 print none)."""

    table: str
    file_id: str
    average: Decimal


@dataclass(frozen=True, slots=True)
class PrintedTable:
    """The summary of one table, as printed below it and in the text of chapter 5.

    Attributes:
        table: `A.1` to `A.7`.
        arena: `corridor` or `rectangle`.
        episodes: Training episodes of the learner.
        foods: Food objects in the arena.
        limit: Time limit in steps.
        average: "Total Average", in percent.
        collected: "Food Collected".
        available: Food objects in all recalls of the table.
        text_average: Mean score in the text; None if only the table has it.
        text_collected: Food collected in the text.
        text_available: Food objects in all recalls, in the text.
    """

    table: str
    arena: str
    episodes: int
    foods: int
    limit: int
    average: Decimal
    collected: int
    available: int
    text_average: Decimal | None
    text_collected: int
    text_available: int


@cache
def recalls() -> tuple[PrintedRecall, ...]:
    """Every recall episode of the thesis, in the order of the tables."""
    return _load("appendix_a.csv", PrintedRecall)


@cache
def sets() -> tuple[PrintedSet, ...]:
    """Every printed average over one set of training files."""
    return _load("appendix_a_sets.csv", PrintedSet)


@cache
def tables() -> tuple[PrintedTable, ...]:
    """The summary of each table."""
    return _load("appendix_a_tables.csv", PrintedTable)


def table_of(arena: str, episodes: int) -> PrintedTable:
    """The table of one cell of the design.

    Raises:
        KeyError: The thesis has no table for this cell.
    """
    cells = {(table.arena, table.episodes): table for table in tables()}
    if (arena, episodes) not in cells:
        raise KeyError(f"no table for {arena!r} after {episodes!r} episodes; allowed: {list(cells)}")
    return cells[arena, episodes]


def rows_of(table: PrintedTable) -> tuple[PrintedRecall, ...]:
    """The recall episodes of one table."""
    return tuple(row for row in recalls() if row.table == table.table)


def mean_score(rows: Iterable[PrintedRecall]) -> float:
    """Mean of the printed scores, in percent."""
    scores = [row.score for row in rows]
    return sum(scores) / len(scores)


def _load(name: str, row_type: type[_RowT]) -> tuple[_RowT, ...]:
    text = resources.files(__package__).joinpath(name).read_text(encoding="utf-8")
    return tuple(parse_rows(text, name, row_type))
