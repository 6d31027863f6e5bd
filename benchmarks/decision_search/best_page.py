"""The page of the best single set: its values, its means beside the thesis, and how it was found."""

import json
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from decision_search.simpler import TOLERANCE, Trial
from khepera_forage.experiments.page import Page
from khepera_forage.experiments.tables import Column, Table, Value
from khepera_forage.task.decisions import Decisions
from khepera_forage.thesis.inference.posterior import fitted_columns
from khepera_forage.thesis.inference.summary import NAMES, SLOPES, thesis_statistics

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


def page(
    chosen: Final,
    start: Final,
    trials: Sequence[Trial],
    found: Sequence[Final],
    generations: Table,
    started_from: int,
) -> Page:
    """The chosen set, and how it was found from a number of admissible sets."""
    return Page(
        "The best single set of decisions",
        [
            f"Every value lies in the prior's range and is rounded. The search began with {started_from} "
            "admissible sets of `khepera-forage infer`. Only tables A.1 to A.4 were looked at. The best of all sets "
            "then lost every change from version 0.1 that the tables do not ask for.",
            "```python\n" + _as_code(chosen.decisions) + "\n```",
            _means(chosen),
            _trials(start, trials),
            _others(found),
            generations,
        ],
    )


def _as_code(decisions: Decisions) -> str:
    changes = decisions.differing(Decisions.v0_1())
    return "\n".join(
        ["Decisions(", *(f"    {name}={json.dumps(new)}," for name, (new, _) in changes.items()), ")"]
    )


def _means(final: Final) -> Table:
    thesis, fitted = thesis_statistics(), set(fitted_columns().tolist())
    return Table(
        "means",
        "Its means",
        "Beside the thesis, in new replications. `test`: not looked at.",
        (Column("statistic"), Column("use"), Column("thesis", 2), Column("this set", 2)),
        [
            (name, "fitted" if k in fitted else "test", float(thesis[k]), float(final.means[k]))
            for k, name in enumerate((*NAMES, *SLOPES))
            if np.isfinite(thesis[k])
        ],
    )


def _trials(start: Final, trials: Sequence[Trial]) -> Table:
    changes = start.decisions.differing(Decisions.v0_1())
    return Table(
        "trials",
        "Which changes the tables ask for",
        f"The best of the finalists differs from version 0.1 in {len(changes)} fields. Each in turn was given the "
        "value of version 0.1 or, failing that, a rounder one. The set kept it if it remained admissible, with a "
        f"misfit at most {TOLERANCE:g} above that of the start.",
        (
            Column("decision"),
            Column("value"),
            Column("tried"),
            Column("misfit"),
            Column("outcome"),
            Column("kept"),
        ),
        [
            (
                trial.name,
                str(trial.value),
                str(trial.simpler),
                trial.judgement.misfit,
                trial.judgement.outcome,
                "yes" if trial.accepted else "no",
            )
            for trial in trials
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
        "The best sets, replicated with other seeds than those that chose them. Misfit is the "
        "squared distance of the eight mean scores and shares of food, and of their two slopes, in the spread of "
        "experiments, plus the excess of the thesis's surprise over its expectation "
        "(`thesis/inference/moments.py`). Differences are root mean "
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
