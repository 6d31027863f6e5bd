"""Claims about what the learner does: where food must lie, and the behaviour 'orient with food' (5.4.1.2)."""

from khepera_forage.experiments.claim import Above, Beyond, Claim, judged, percent, percent_change
from khepera_forage.experiments.claims_learning import SECTION
from khepera_forage.experiments.evidence import (
    NEAR_TRAINING,
    TRAINING_DISTANCE,
    Evidence,
    delivered_where,
    foods_where,
    of_arena,
)
from khepera_forage.experiments.rows import RecallRow
from khepera_forage.foraging.states import State

AREA_MARGIN = 0.10
"""Difference in success below which two areas count as equal; the thesis has "most of the times" and "rarely"."""
GHOSTS = 0.10
"""Share of recalls beyond which a behaviour out of place counts as something that the learner does."""
MOST = 0.5
ALL_CORRECT = 0.9
"""Share of correct rounds from which "all the consequent behaviours are correctly executed" may be said."""
AFTER_ORIENT = (
    State.ORIENTED_WITH_FOOD,
    State.READY_TO_PICK_UP_FOOD,
    State.FOOD_IN_HAND,
    State.AT_HOME_WITH_FOOD,
)


def areas(evidence: Evidence, arena: str) -> Claim:
    """Success depends on the side of the training place on which the food lies, whichever is area 1."""
    rows = of_arena(evidence.recalls, arena)
    place = TRAINING_DISTANCE
    return _places(
        evidence,
        rows,
        f"Success depends on the food's area: nearer to home or further than in training ({arena})",
        SECTION[arena],
        (lambda distance: distance < place, lambda distance: distance >= place),
        ("nearer to home than in training", "further"),
        Beyond(AREA_MARGIN),
        "most of the times in area 2, rarely in area 1",
    )


def around_training(evidence: Evidence, arena: str) -> Claim:
    """Food as far from home as in training is brought home more often than other food."""
    rows = of_arena(evidence.recalls, arena)

    def near(distance: float) -> bool:
        return abs(distance - TRAINING_DISTANCE) <= NEAR_TRAINING

    return _places(
        evidence,
        rows,
        f"It succeeds where food lies as far from home as in training ({arena})",
        SECTION[arena],
        (near, lambda distance: not near(distance)),
        (f"within {NEAR_TRAINING:.0f} pixels of the training distance", "elsewhere"),
        Above(0.0),
        "the learner should know food close to its home as well as far away",
    )


def _places(  # noqa: PLR0913
    evidence: Evidence,
    rows: list[RecallRow],
    name: str,
    section: str,
    inside: tuple["Inside", "Inside"],
    words: tuple[str, str],
    rule: Above | Beyond,
    thesis: str,
) -> Claim:
    """Success with food in one range of distances less that in another."""
    shares = [evidence.mean(rows, delivered_where(where), foods_where(where)).value for where in inside]
    counts = [sum(map(foods_where(where), rows)) for where in inside]
    raise NotImplementedError


def ghost_orient(evidence: Evidence, arena: str) -> Claim:
    """'Orient with food' is executed where no food is."""
