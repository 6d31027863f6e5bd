"""Claims about learning: the effect of more training, and of another arena (5.4.1.2, 5.4.2.2, 5.5)."""

from khepera_forage.thesis import appendix_a
from khepera_forage.thesis.claims.claim import (
    Above,
    Claim,
    Unit,
    Within,
    judged,
    percent,
    percent_change,
    points,
)
from khepera_forage.thesis.claims.evidence import Evidence, Sample, food_share, of_arena

SECTION = {"corridor": "5.4.1.2", "rectangle": "5.4.2.2"}
FIRST = {"corridor": 3, "rectangle": 5}
"""Episodes of the second cell of each arena, which ends the early gain."""
COMPARABLE = 10.0
"""Largest difference in score of comparable arenas; in the thesis the arenas differ by 7 to 9 points."""
_percent = Unit("%", ".4g")


def improves(evidence: Evidence, arena: str) -> Claim:
    """More episodes improve the learner: ten compared with one."""
    estimate = evidence.cell_scores({(arena, 10): 1.0, (arena, 1): -1.0})
    return judged(
        f"More episodes improve the learner ({arena})",
        SECTION[arena],
        estimate,
        Above(0.0),
        points,
        points(_thesis(arena, 10) - _thesis(arena, 1)),
        f"Mean score {_score(evidence, arena, 10)} after ten training episodes and "
        f"{_score(evidence, arena, 1)} after one; in the thesis {_percent(_thesis(arena, 10))} and "
        f"{_percent(_thesis(arena, 1))}.",
    )


def gain_shrinks(evidence: Evidence, arena: str) -> Claim:
    """The gain shrinks: the early points per episode minus the points per episode from five to ten."""
    first = FIRST[arena]
    early, late = 1.0 / (first - 1), 1.0 / 5
    weights = {(arena, 1): -early, (arena, first): early}
    weights[arena, 5] = weights.get((arena, 5), 0.0) + late
    weights[arena, 10] = -late
    gains = [
        (_mean_score(evidence, arena, after) - _mean_score(evidence, arena, before)) / (after - before)
        for before, after in ((1, first), (5, 10))
    ]
    return judged(
        f"The gain from an episode shrinks ({arena})",
        SECTION[arena],
        evidence.cell_scores(weights),
        Above(0.0),
        points,
        points(sum(weight * _thesis(*cell) for cell, weight in weights.items())),
        f"Each episode from 1 to {first} adds {points(gains[0])}, each from 5 to 10 {points(gains[1])}; the effect is "
        "the difference.",
    )


def generalises(evidence: Evidence) -> Claim:
    """Trained in the corridor, the learner forages in the rectangle better than chance."""
    learner = [row for row in of_arena(evidence.recalls, "rectangle") if row.episodes == 10]
    learned, chance = food_share(learner), food_share(of_arena(evidence.chance, "rectangle"))
    table = appendix_a.table_of("rectangle", 10)
    return judged(
        "The learner generalises: trained in the corridor, it forages in the rectangle",
        "5.4.2, 5.5",
        evidence.difference(learned, chance),
        Above(0.0),
        percent_change,
        f"{percent(table.collected / table.available)} of the food, chance not measured",
        f"After ten episodes in the corridor the learner brings home {percent(learned.value)} of the food; "
        f"behaviours drawn at random bring home {percent(chance.value)}.",
    )


def comparable(evidence: Evidence) -> Claim:
    """The scores in the rectangle and in the corridor are comparable."""
    estimate = evidence.cell_scores({("corridor", 10): 1.0, ("rectangle", 10): -1.0})
    return judged(
        "Performance in the rectangle is comparable to the corridor's",
        "5.4.2",
        estimate,
        Within(COMPARABLE),
        points,
        points(_thesis("corridor", 10) - _thesis("rectangle", 10)),
        f"Mean score after ten episodes: {_score(evidence, 'corridor', 10)} in the corridor, "
        f"{_score(evidence, 'rectangle', 10)} in the rectangle.",
    )


def _thesis(arena: str, episodes: int) -> float:
    """The mean of the scores that the thesis prints in the lines of a cell."""
    return appendix_a.mean_score(appendix_a.rows_of(appendix_a.table_of(arena, episodes)))


def _score(evidence: Evidence, arena: str, episodes: int) -> str:
    return _percent(_mean_score(evidence, arena, episodes))


def _mean_score(evidence: Evidence, arena: str, episodes: int) -> float:
    rows = [row for row in of_arena(evidence.recalls, arena) if row.episodes == episodes]
    return Sample(rows, lambda row: row.score).value
