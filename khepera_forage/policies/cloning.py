"""Behavioural cloning: a small network fitted to the teacher's behaviours."""

from typing import Any

CORRIDOR_DIAGONAL = 138
"""Pixels by which distances are scaled in every arena: a network learns places in pixels, not in diagonals."""


def cloning(random_state: int = 0, **settings: Any) -> Any:
    """scikit-learn's multi-layer perceptron on encoded state vectors (`policies.features.encoded`), not fitted.

    Args:
        random_state: Seed of the first weights and of the order of the vectors.
        **settings: Arguments of `sklearn.neural_network.MLPClassifier`.
    """
    from sklearn.neural_network import MLPClassifier
    from sklearn.pipeline import make_pipeline
    from sklearn.preprocessing import FunctionTransformer

    from khepera_forage.policies.features import encoded

    return make_pipeline(
        FunctionTransformer(encoded, kw_args={"diagonal": CORRIDOR_DIAGONAL}),
        MLPClassifier(random_state=random_state, **settings),
    )
