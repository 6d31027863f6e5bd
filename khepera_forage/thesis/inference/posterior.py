"""What tables A.1 to A.4 say about the decisions: the posterior as weights of simulated sets, and its validation."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from khepera_forage.thesis.inference.calibration import Calibration, calibrate
from khepera_forage.thesis.inference.forest import TREES, SetForest
from khepera_forage.thesis.inference.parameters import Parameter
from khepera_forage.thesis.inference.summary import FITTED, NAMES, SLOPES, thesis_statistics

Floats = NDArray[np.float64]
Numbers = NDArray[np.intp]

HELD_OUT = 10
"""One set in this many is not learned: it stands in for the thesis in the validation."""


def fitted_columns() -> Numbers:
    """Places of the statistics that are fitted: those of tables A.1 to A.4 that the thesis has."""
    known = np.isfinite(thesis_statistics())
    names = (*NAMES, *SLOPES)
    return np.array([k for k, name in enumerate(names) if name in FITTED and known[k]], dtype=np.intp)


@dataclass(frozen=True, slots=True)
class Posterior:
    """Weights of admissible sets, given the thesis's tables.

    Attributes:
        parameters: What the prior draws, in all admissible sets.
        weights: One an admissible set, 1 together; held-out sets have none.
        calibrations: One a parameter, in the same order.
        held_out: Number of sets that the calibration tried to recover.
    """

    parameters: tuple[Parameter, ...]
    weights: Floats
    calibrations: tuple[Calibration, ...]
    held_out: int


def infer(
    parameters: Sequence[Parameter],
    statistics: NDArray[np.float32],
    seed: int,
    trees: int = TREES,
) -> Posterior:
    """Weight sets by their likeness to the thesis, and validate the weights on sets that were held out.

    Args:
        parameters: What the prior draws, in admissible sets.
        statistics: Of these sets, shape (sets, experiments, statistics of `summary`).
        seed: Of the forest.
        trees: Of the forest.

    Raises:
        ValueError: Fewer than three sets.
    """
    count = len(statistics)
    if count < 3:
        raise ValueError(f"{count} admissible sets; allowed: at least 3, to learn from and to validate with")
    columns = fitted_columns()
    held_out = np.arange(0, count, HELD_OUT)
    learned = np.setdiff1d(np.arange(count), held_out)
    targets = np.hstack([parameter.of(learned).targets for parameter in parameters])
    fitted = statistics[:, :, columns].astype(np.float64)
    forest = SetForest(fitted[learned], targets, seed, trees)
    observed = np.vstack([thesis_statistics()[columns], fitted[held_out, 0]])
    given = forest.weights(observed)
    weights = np.zeros(count)
    weights[learned] = given[0]
    rng = np.random.default_rng(seed)
    calibrations = [
        calibrate(parameter.of(learned), given[1:], parameter.of(held_out), rng) for parameter in parameters
    ]
    return Posterior(tuple(parameters), weights, tuple(calibrations), len(held_out))
