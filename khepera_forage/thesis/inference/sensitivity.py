"""Global sensitivity: how much of the outcome's variance over admissible sets a decision explains alone."""

import warnings
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from khepera_forage.estimates import Estimate
from khepera_forage.thesis.design import ARENAS
from khepera_forage.thesis.inference.parameters import Parameter
from khepera_forage.thesis.inference.summary import NAMES

Floats = NDArray[np.float64]
OUTCOMES = tuple((arena, measure) for arena in ARENAS for measure in ("score", "food"))
RESAMPLES, QUICK_RESAMPLES = 100, 10
"""Number of bootstrap samples of the sets, and with `--quick`."""


def outcome(statistics: NDArray[np.float32], arena: str, measure: str) -> Floats:
    """Mean score (percent) or share of food in an arena, over its cells and all experiments; one a set."""
    columns = [k for k, name in enumerate(NAMES) if name.startswith(arena) and name.endswith(f" {measure}")]
    return np.asarray(statistics[:, :, columns].mean(axis=(1, 2)), dtype=np.float64)


def first_order(
    parameters: Sequence[Parameter], values: Floats, seed: int, resamples: int = RESAMPLES
) -> list[Estimate]:
    """Sobol' indices of the first order from the sets as they are, with bootstrapped 95 % intervals.

    Args:
        parameters: What was drawn.
        values: The outcome, one a set.
        seed: Of the bootstrap.
        resamples: Number of bootstrap samples of the sets.

    Raises:
        ImportError: SALib is not installed.
    """
    try:
        from SALib.analyze import delta
    except ImportError:
        raise ImportError(
            "sensitivity needs SALib, which is not installed: pip install 'khepera-forage[inference]'"
        ) from None
    problem: dict[str, Any] = {
        "num_vars": len(parameters),
        "names": [parameter.name for parameter in parameters],
        "bounds": [[parameter.values.min(), parameter.values.max()] for parameter in parameters],
    }
    inputs = np.stack([parameter.values for parameter in parameters], axis=1)
    state = np.random.get_state()  # noqa: NPY002 (SALib seeds numpy's global generator)
    try:
        with warnings.catch_warnings():  # SALib changes the filters of the whole process
            found = delta.analyze(
                problem, inputs, values, num_resamples=resamples, seed=seed + 1, method="sobol"
            )
    finally:
        np.random.set_state(state)  # noqa: NPY002
    return [
        Estimate(float(value), float(value - half), float(value + half))
        for value, half in zip(found["S1"], found["S1_conf"], strict=True)
    ]
