"""The page of the claims: in what share of laboratories does each hold, before and after looking at the tables?"""

from collections.abc import Sequence

import numpy as np

from khepera_forage.estimates import Column, Table, Value, wilson
from khepera_forage.study import Arguments, Page
from khepera_forage.thesis.claims import Verdict
from khepera_forage.thesis.inference.chunks import joined
from khepera_forage.thesis.inference.claims_table import (
    CLAIMS,
    ClaimsContents,
    MeasuredClaims,
    delete_claims,
    measure,
    verdict_table,
)
from khepera_forage.thesis.inference.draw import Drawn
from khepera_forage.thesis.inference.posterior import Posterior
from khepera_forage.thesis.inference.weighted import sample

LABORATORIES, QUICK_LABORATORIES = 80, 2
"""Drawn from the prior, and as many from the posterior."""
REPLICATIONS, QUICK_REPLICATIONS = 50, 5
"""Of the thesis's design under each."""
OBSERVATIONS = ("Success depends on", "'Orient with food' is executed where", "After 'orient with food'")
"""How the claims begin that belong to the test set: areas 1 and 2, ORIENT without food, and what follows it."""


def page(given: Arguments, drawn: Drawn, posterior: Posterior) -> Page:
    """Measure the claims, and say where they hold."""
    count = min(QUICK_LABORATORIES if given.quick else LABORATORIES, len(drawn.laboratories))
    rng = np.random.default_rng(given.seed)
    prior = rng.choice(len(drawn.laboratories), count, replace=False)
    inferred = sample(posterior.weights, count, rng)
    numbers = sorted({*prior.tolist(), *inferred.tolist()})
    contents = ClaimsContents(given.seed, QUICK_REPLICATIONS if given.quick else REPLICATIONS)
    folder = given.out / "claims"
    if given.fresh:
        delete_claims(folder)
    laboratories = {number: drawn.laboratories[number] for number in numbers}
    measured = joined(list(measure(folder, laboratories, contents, given.jobs)))
    samples = [measured.select(chosen.tolist()) for chosen in (prior, inferred)]
    return Page(
        "In which laboratories do the thesis's claims hold?",
        [
            f"Each claim was measured in {contents.replications} replications of the design under each laboratory. "
            "A claim holds if its whole 95 % interval is on the thesis's side of the rule in "
            "[../thesis/thesis.md](../thesis/thesis.md).",
            verdict_table(*samples),
            _observations(samples),
        ],
    )


def _observations(samples: Sequence[MeasuredClaims]) -> Table:
    own = [k for k, claim in enumerate(CLAIMS) if claim.name.startswith(OBSERVATIONS)]
    rows: list[tuple[Value, ...]] = []
    counts = []
    for measured in samples:
        known = measured.reasons == ""
        counts.append((measured.verdicts[known][:, own] == Verdict.SUPPORTED).sum(axis=1))
    for least in range(len(own) + 1):
        shares = [wilson(int((held >= least).sum()), len(held)) for held in counts]
        rows.append((least, *(type(share)(*(100 * value for value in share)) for share in shares)))
    return Table(
        "observations",
        "The observations of the test set",
        f"Share of laboratories in which at least so many of {len(own)} claims hold that were not fitted: areas 1 and "
        "2 and ORIENT where no food is, each in both arenas, and the behaviours after ORIENT (5.4.1.2, 5.4.2.2).",
        (
            Column("at least"),
            Column("admissible laboratories (%)", 0, estimate=True),
            Column("posterior laboratories (%)", 0, estimate=True),
        ),
        rows,
    )
