"""A decision tree of state vectors: what the teacher's own tree (figure 4.2) looks like to a learner."""

from typing import Any


def tree(random_state: int = 0, **settings: Any) -> Any:
    """scikit-learn's decision tree, not fitted.

    Categories are small whole numbers and stay so: a tree splits them as it needs.

    Args:
        random_state: Of the choice between splits that are equally good.
        **settings: Those of `sklearn.tree.DecisionTreeClassifier`.
    """
    from sklearn.tree import DecisionTreeClassifier

    return DecisionTreeClassifier(random_state=random_state, **settings)
