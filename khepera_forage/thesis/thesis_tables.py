"""Tables of the thesis beside us: the results of its cells, its claims, and its slips in arithmetic."""

from collections.abc import Sequence

from khepera_forage.thesis.cells import CellResult
from khepera_forage.thesis.claims import Claim
from khepera_forage.thesis.errata import slips
from khepera_forage.thesis.statistics import Estimate
from khepera_forage.thesis.tables import Column, Table, Value


def cell_table(results: Sequence[CellResult]) -> Table:
    """The thesis' mean score and food count of each cell beside ours."""
    rows: list[tuple[Value, ...]] = []
    for r in results:
        score, food = r.score_standing, r.food_standing
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
        "The thesis' results beside ours",
        "Mean score in percent and food carried home, with a 95 % interval over replications. The thesis' "
        "score stands here as printed and as the mean of the scores in its lines, compared with ours. "
        "*Percentile* is where the thesis' value lies among our experiments of the same size, one a "
        "replication; *tail* is the chance to lie at least as far out, on either side, for one more "
        "experiment like ours.",
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
    """The thesis' claims with effect and verdict."""
    return Table(
        "claims",
        "The thesis' claims",
        "Each claim with its effect, a 95 % interval over replications, and the verdict of a rule that was "
        "fixed before there were data: see below by number. An interval that reaches across the rule's "
        "threshold leaves the claim undecided.",
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
    """What was measured for each claim, and the rule of its verdict."""
    return Table(
        "rules",
        "What was measured, and the rules of the verdicts",
        "By number of the claim.",
        (Column("no."), Column("rule"), Column("what was measured")),
        [(i, c.rule, c.sentence) for i, c in enumerate(claims, 1)],
    )


def slip_table() -> Table:
    """What does not add up in the thesis' own tables."""
    return Table(
        "slips",
        "The thesis' own slips in arithmetic",
        "Computed from tables A.1 to A.7 as printed. *Series* are lines that count up by one, the mark of a "
        "spreadsheet's fill-down.",
        tuple(map(Column, ("table", "place", "kind", "printed", "would follow"))),
        [tuple(slip) for slip in slips()],
    )
