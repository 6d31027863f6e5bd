"""Tables that compare the thesis with our results: cells, claims and rules; and the thesis's errata."""

from collections.abc import Sequence

from khepera_forage.thesis.cells import CellResult
from khepera_forage.thesis.claims import Claim
from khepera_forage.thesis.errata import errata
from khepera_forage.thesis.statistics import Estimate
from khepera_forage.thesis.tables import Column, Table, Value


def cell_table(results: Sequence[CellResult]) -> Table:
    """Mean score and food count of each cell, in the thesis and in our replications."""
    rows: list[tuple[Value, ...]] = []
    for r in results:
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
                f"{r.thesis_food} of {r.cell.available}",
                r.food,
                food.percentile,
                food.tail,
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
        "at least as extreme, on either side.",
        (
            Column("arena"),
            Column("episodes"),
            Column("thesis: score (%)", 2),
            Column("from its lines (%)", 2),
            Column("ours: score (%)", 1, estimate=True),
            Column("score percentile", 0),
            Column("score tail", 2),
            Column("thesis: food"),
            Column("ours: food", 1, estimate=True),
            Column("food percentile", 0),
            Column("food tail", 2),
            Column("experiments"),
            Column("recalls"),
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
