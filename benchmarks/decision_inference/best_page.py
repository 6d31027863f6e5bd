"""The page of the best single set: its values, its means beside the thesis, and how it was found."""

import json
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from harness.page import Page
from numpy.typing import NDArray

from khepera_forage.task.decisions import Decisions
from khepera_forage.thesis.inference.posterior import fitted_columns
from khepera_forage.thesis.inference.summary import NAMES, SLOPES, thesis_statistics
from khepera_forage.thesis.tables import Column, Table, Value

Floats = NDArray[np.float64]


class Final(NamedTuple):
    """A set with natural values, replicated again.

    Attributes:
        decisions: The set.
        misfit: In the new replications; infinity if it is not admissible.
        outcome: Why it is not admissible, or `admissible`.
        means: Of its statistics.
    """

    decisions: Decisions
    misfit: float
    outcome: str
    means: Floats


def page(found: Sequence[Final], generations: Table, started_from: int) -> Page:
    """The best set, the others, and how they were found from a number of admissible sets."""
    chosen = found[0].decisions
    return Page(
        "The best single set of decisions",
        [
            f"Every value lies in the prior's range and is rounded. The search began with {started_from} "
            "admissible sets of `benchmarks/decisions.py`. Only tables A.1 to A.4 were looked at.",
            "```python\n" + _as_code(chosen) + "\n```",
            _fields(chosen),
            _means(found[0]),
            _others(found),
            generations,
        ],
    )


def _as_code(decisions: Decisions) -> str:
    changes = decisions.differing(Decisions.v0_1())
    return "\n".join(
        ["Decisions(", *(f"    {name}={json.dumps(new)}," for name, (new, _) in changes.items()), ")"]
    )


def _fields(chosen: Decisions) -> Table:
    rows = [(name, *map(str, pair)) for name, pair in chosen.differing(Decisions.v0_1()).items()]
    return Table(
        "fields",
        "What differs from version 0.1",
        "Fields that are not here have the values of version 0.1.",
        (Column("decision"), Column("best set"), Column("version 0.1")),
        rows,
    )


def _means(final: Final) -> Table:
    thesis, fitted = thesis_statistics(), set(fitted_columns().tolist())
    return Table(
        "means",
        "Means of the best set",
        "Beside the thesis. `test`: not looked at.",
        (Column("statistic"), Column("use"), Column("thesis", 2), Column("best set", 2)),
        [
            (name, "fitted" if k in fitted else "test", float(thesis[k]), float(final.means[k]))
            for k, name in enumerate((*NAMES, *SLOPES))
            if np.isfinite(thesis[k])
        ],
    )


def _others(found: Sequence[Final]) -> Table:
    thesis, names = thesis_statistics(), (*NAMES, *SLOPES)
    rows: list[tuple[Value, ...]] = []
    for place, final in enumerate(found):
        differences = []
        for measure in (" score", " food"):
            columns = [k for k in fitted_columns() if names[k] in NAMES and names[k].endswith(measure)]
            differences.append(float(np.sqrt(np.mean((final.means[columns] - thesis[columns]) ** 2))))
        rows.append((place + 1, final.outcome, final.misfit, *differences))
    return Table(
        "finalists",
        "The finalists",
        "The best sets with natural values, replicated with other seeds than those that chose them. Misfit is the "
        "squared distance of the eight mean scores and shares of food, in the spread of experiments, plus the excess "
        "of the thesis's surprise over its expectation (`thesis/inference/moments.py`). Differences are root mean "
        "squares over the four corridor cells.",
        (
            Column("rank"),
            Column("outcome"),
            Column("misfit"),
            Column("difference of scores", 1),
            Column("difference of food", 3),
        ),
        rows,
    )
