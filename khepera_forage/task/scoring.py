"""The score of a recall: equation 5.1 and its penalties (5.4)."""

PENALTY_NONE_DELIVERED = 20.0
PENALTY_SOME_LEFT = 5.0


def penalty(delivered: int, deliverable: int) -> float:
    """Percent taken off for food left in the arena (5.4.1.1, 5.4.2.1).

    Args:
        delivered: Food brought home that is not poisonous.
        deliverable: All food that is not known to be poisonous; poison never counts as uncollected.
    """
    if delivered >= deliverable:
        return 0.0
    return PENALTY_SOME_LEFT if delivered else PENALTY_NONE_DELIVERED


def score(correct: int, steps: int, penalty: float) -> float:
    """Correct behaviours / steps - penalty, in percent (equation 5.1); 0 before the first step.

    Args:
        correct: Steps on which the teacher would have done the same.
        steps: All steps so far.
        penalty: See `penalty`.
    """
    return 100.0 * correct / steps - penalty if steps else 0.0
