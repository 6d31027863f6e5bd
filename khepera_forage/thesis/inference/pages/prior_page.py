"""The page of the prior: what could have been, which sets are admissible, and what these predict."""

from collections import Counter

import numpy as np
from numpy.typing import NDArray

from khepera_forage.estimates import Column, Table
from khepera_forage.study import Page
from khepera_forage.thesis.inference.draw import Drawn
from khepera_forage.thesis.inference.prior import PRIOR, Range


def page(drawn: Drawn) -> Page:
    """Tables of the prior and of the reasons."""
    return Page(
        "The prior: laboratories that could have been the thesis's", [_prior(), _reasons(drawn.sets.reasons)]
    )


def _prior() -> Table:
    rows = []
    for name, part in (*PRIOR.decisions.items(), *PRIOR.noise.items()):
        if isinstance(part, Range):
            values = f"{part.least:g} to {part.most:g}"
        else:
            values = "; ".join(f"{reading} ({share:.0%})" for reading, share in part.of.items())
        rows.append((name, values, part.source))
    return Table(
        "prior",
        "The prior",
        "Numbers are uniform in their range; readings have the probability in brackets. Everything else has the "
        "value of version 0.1, or the laboratory's noise. The ranges were written before anything was fitted.",
        (Column("decision or noise"), Column("values"), Column("source")),
        rows,
    )


def _reasons(reasons: NDArray[np.str_]) -> Table:
    counts = Counter(reason or "admissible" for reason in reasons.tolist())
    return Table(
        "admissible",
        "Which sets are admissible",
        "A set is admissible if the teacher brings home at least 98 % of the food in both arenas, its fastest forage "
        "leaves room for the fastest recalls of the thesis (65 and 205 steps), it delivers nothing with SEARCH in the "
        "place of ORIENT, and at least half of the attempts at a training episode are complete. The first reason "
        "counts. No learner is looked at.",
        (Column("outcome"), Column("sets"), Column("share (%)")),
        [(name, count, 100.0 * count / len(reasons)) for name, count in counts.most_common()],
    )
