"""Gradient boosting on state vectors."""

from typing import Any


def boosting(random_state: int = 0, **settings: Any) -> Any:
    """scikit-learn's gradient boosting, not fitted.

    The variant over histograms takes ten milliseconds a decision, this one a third of a millisecond.

    Args:
        random_state: Seed of its random choices.
        **settings: Arguments of `sklearn.ensemble.GradientBoostingClassifier`.
    """
    from sklearn.ensemble import GradientBoostingClassifier

    return GradientBoostingClassifier(random_state=random_state, **settings)
