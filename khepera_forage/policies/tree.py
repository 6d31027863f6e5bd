"""A decision tree of state vectors, as the teacher has one (figure 4.2)."""

from typing import Any


def tree(random_state: int = 0, **settings: Any) -> Any:
    """scikit-learn's decision tree, not fitted.

    Categories stay small whole numbers, which a tree can split.

    Args:
        random_state: Seed of the choice between equally good splits.
        **settings: Arguments of `sklearn.tree.DecisionTreeClassifier`.
    """
    from sklearn.tree import DecisionTreeClassifier

    return DecisionTreeClassifier(random_state=random_state, **settings)
