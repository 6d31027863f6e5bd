"""Tables that compare the thesis with our results: cells, claims and rules; and the thesis's errata."""

from collections.abc import Iterator, Sequence
from itertools import repeat

from khepera_forage.estimates import Column, Estimate, Table, Value
from khepera_forage.thesis.cells import CellResult
from khepera_forage.thesis.claims import Claim
from khepera_forage.thesis.errata import errata

_V0_1_NOTE = (
    " The columns *v0.1* are of replications under the decisions of version 0.1, with the thesis's percentile among "
    "them."
)


def cell_table(results: Sequence[CellResult], v0_1_results: Sequence[CellResult] = ()) -> Table:
    """Mean score and food count of each cell, in the thesis and in our replications.

    Args:
        results: One for each cell.
        v0_1_results: The same cells under the decisions of version 0.1. Without any, the table has no columns for them.
    """
    rows: list[tuple[Value, ...]] = []
    for r, old in _pairs(results, v0_1_results):
        score, food = r.score_rank, r.food_rank
        rows.append(
            (
                r.cell.arena,
                r.cell.episodes,
                r.thesis_printed,
                r.thesis_score,
                r.score,
                score.percentile,
                score.tail,
                *((old.score, old.score_rank.percentile) if old else ()),
                f"{r.thesis_food} of {r.cell.available}",
                r.food,
                food.percentile,
                food.tail,
                *((old.food, old.food_rank.percentile) if old else ()),
                score.experiments,
                r.recalls,
            )
        )
    return Table(
        "cells",
        "Results of the thesis and of our replications",
        "Mean score in percent and food carried home, with a 95 % interval over replications. The table shows the "
        "thesis's score as printed, and as the mean of the scores in the printed lines; the latter is compared with "
        "ours. Each replication contains one experiment of the thesis's size. *Percentile* is the rank of the "
        "thesis's value among these experiments. *Tail* is the probability that one more of our experiments is "
        "at least as extreme, on either side." + (_V0_1_NOTE if v0_1_results else ""),
        (
            Column("arena"),
            Column("episodes"),
            Column("thesis: score (%)", 2),
            Column("from its lines (%)", 2),
            Column("ours: score (%)", 1, estimate=True),
            Column("score percentile", 0),
            Column("score tail", 2),
            *(_v0_1_columns("score", "score (%)") if v0_1_results else ()),
            Column("thesis: food"),
            Column("ours: food", 1, estimate=True),
            Column("food percentile", 0),
            Column("food tail", 2),
            *(_v0_1_columns("food", "food") if v0_1_results else ()),
            Column("experiments"),
            Column("recalls"),
        ),
        rows,
    )


def _pairs(
    results: Sequence[CellResult], v0_1_results: Sequence[CellResult]
) -> Iterator[tuple[CellResult, CellResult | None]]:
    """Each cell's result, and that of version 0.1 if there is any."""
    return zip(results, v0_1_results or repeat(None, len(results)), strict=True)


def _v0_1_columns(name: str, heading: str) -> tuple[Column, ...]:
    return Column(f"v0.1: {heading}", 1, estimate=True), Column(f"v0.1: {name} percentile", 0)


def summary_table(results: Sequence[CellResult], v0_1_results: Sequence[CellResult] = ()) -> Table:
    """The means of each cell in the thesis, in our replications, and in those of version 0.1 if there are any.

    Args:
        results: One for each cell.
        v0_1_results: The same cells under the decisions of version 0.1; may be empty.
    """
    rows: list[tuple[Value, ...]] = [
        (
            r.cell.arena,
            r.cell.episodes,
            r.thesis_score,
            r.score.value,
            *((old.score.value,) if old else ()),
            f"{r.thesis_food} of {r.cell.available}",
            r.food.value,
            *((old.food.value,) if old else ()),
        )
        for r, old in _pairs(results, v0_1_results)
    ]
    v0_1 = (Column("v0.1"),) if v0_1_results else ()
    return Table(
        "summary",
        "Summary",
        "Mean score, and food carried home in an experiment of the thesis's size."
        + (" v0.1: under the decisions of version 0.1." if v0_1_results else ""),
        (
            Column("arena"),
            Column("episodes"),
            Column("score (%): thesis", 2),
            Column("ours"),
            *v0_1,
            Column("food: thesis"),
            Column("ours"),
            *v0_1,
        ),
        rows,
    )


def claim_table(claims: Sequence[Claim]) -> Table:
    """The thesis's claims with effect and verdict."""
    return Table(
        "claims",
        "Claims of the thesis",
        "Each claim with its effect, a 95 % interval over replications, and a verdict. The next table lists the rule "
        "of each verdict, which was fixed before any data existed. A claim is undecided if its interval contains "
        "the rule's threshold, or if there are too few replications for an interval.",
        (
            Column("no."),
            Column("claim"),
            Column("section"),
            Column("effect [95 %]"),
            Column("value", estimate=True, page=False),
            Column("in the thesis"),
            Column("verdict"),
        ),
        [
            (
                i,
                c.name,
                c.thesis_section,
                c.effect,
                Estimate(c.value, c.low, c.high),
                c.thesis,
                c.verdict.value,
            )
            for i, c in enumerate(claims, 1)
        ],
    )


def rule_table(claims: Sequence[Claim]) -> Table:
    """The measurement behind each claim, and the rule of its verdict."""
    return Table(
        "rules",
        "Measurements and rules of the verdicts",
        "Ordered by the number of the claim.",
        (Column("no."), Column("rule"), Column("what was measured")),
        [(i, c.rule, c.sentence) for i, c in enumerate(claims, 1)],
    )


def errata_table() -> Table:
    """Errors of arithmetic in the thesis's tables."""
    return Table(
        "errata",
        "Errata of the thesis",
        "Values in tables A.1 to A.7 that do not follow from the values printed beside them. A *series* is a run of "
        "lines that count up by one, as a spreadsheet's fill-down produces them.",
        tuple(map(Column, ("table", "place", "kind", "printed", "expected"))),
        [tuple(erratum) for erratum in errata()],
    )
