"""Which readings of the thesis do its own tables support? Approximate Bayesian computation by random forests.

    python benchmarks/decisions.py --help

1. Sets of decisions are drawn from a prior with a source for every range. A set is admissible if the teacher can do
   under it what the thesis says of it. Under each admissible set, the thesis's whole design is replicated.
2. A random forest learns from these sets what statistics of the corridor's tables say about each decision. It is first
   validated on sets that it has not seen, and then given tables A.1 to A.4. Tables A.5 to A.7 are the test set.

Writes one page a question. Needs numba and SALib: pip install 'khepera-forage[fast,inference]'. Ten thousand sets take
some hours; a run that was killed continues.
"""

import sys

import numpy as np
from decision_inference import (
    cells_page,
    claims_page,
    posterior_page,
    prior_page,
    questions_page,
    test_set_page,
    validation_page,
)
from decision_inference.cells_page import Predictions
from decision_inference.sets import Drawn, draw
from harness.arguments import Arguments, Count, parse
from harness.figures import COLOURS, GREY, OURS
from harness.page import Page, write

from khepera_forage.noise import Noise
from khepera_forage.task.decisions import Decisions
from khepera_forage.thesis.design import ARENAS, THESIS
from khepera_forage.thesis.inference import individual_recalls
from khepera_forage.thesis.inference.posterior import Posterior, infer
from khepera_forage.thesis.inference.prior import Laboratory
from khepera_forage.thesis.inference.simulate import recalls_under
from khepera_forage.thesis.inference.summary import of_recalls, with_slopes
from khepera_forage.thesis.inference.weighted import sample

EXPERIMENTS, QUICK_EXPERIMENTS = 500, 4
"""Replications under the decisions of version 0.1, and under the defaults if they are others."""
SAMPLED, QUICK_SAMPLED = 200, 3
"""Sets drawn from the posterior, of which an experiment's individual recalls are shown."""


def predictions_under(name: str, colour: str, decisions: Decisions, given: Arguments) -> Predictions:
    """Experiments under one set of decisions and the laboratory's noise."""
    count = QUICK_EXPERIMENTS if given.quick else EXPERIMENTS
    cells = recalls_under(Laboratory(decisions, Noise.laboratory()), given.seed, count)
    statistics = with_slopes([of_recalls(cell, own) for cell, own in zip(THESIS, cells, strict=True)])
    recalls = {arena: individual_recalls.of_arena(cells, arena) for arena in ARENAS}
    return Predictions(name, colour, statistics, np.ones(count), recalls)


def predictions_of_posterior(given: Arguments, drawn: Drawn, posterior: Posterior) -> Predictions:
    """Experiments under the admissible sets, weighted; individual recalls under some sets drawn by weight."""
    sets, experiments, width = drawn.statistics.shape
    rng = np.random.default_rng(given.seed)
    chosen = sample(posterior.weights, QUICK_SAMPLED if given.quick else SAMPLED, rng)
    played = [recalls_under(drawn.laboratories[k], int(rng.integers(2**62)), 1) for k in chosen]
    recalls = {}
    for arena in ARENAS:
        own = [individual_recalls.of_arena(cells, arena) for cells in played]
        recalls[arena] = individual_recalls.IndividualRecalls(*map(np.concatenate, zip(*own, strict=True)))
    return Predictions(
        "posterior",
        OURS,
        drawn.statistics.reshape(sets * experiments, width).astype(np.float64),
        np.repeat(posterior.weights / experiments, experiments),
        recalls,
    )


def pages(given: Arguments, drawn: Drawn) -> dict[str, Page]:
    """All pages, by the name of their files."""
    posterior = infer(drawn.parameters, drawn.statistics, given.seed)
    known = [predictions_under("version 0.1", GREY, Decisions.v0_1(), given)]
    if Decisions() != Decisions.v0_1():
        known.append(predictions_under("default", COLOURS[2], Decisions(), given))
    inferred = predictions_of_posterior(given, drawn, posterior)
    thesis = {arena: individual_recalls.of_thesis(arena) for arena in ARENAS}
    return {
        "prior": prior_page.page(drawn),
        "validation": validation_page.page(posterior),
        "posterior": posterior_page.page(drawn, posterior, given.seed),
        "cells": cells_page.page([*known, inferred], thesis),
        "test_set": test_set_page.page(inferred, drawn.statistics, posterior.weights, known),
        "claims": claims_page.page(given, drawn, posterior),
        "questions": questions_page.page(posterior, drawn.statistics, given.seed),
    }


def main() -> int:
    """Run the benchmark."""
    sets = Count("sets", 10_000, 6, "admissible sets", least=3)
    experiments = Count("experiments", 20, 2, "replications of the thesis's design under each set")
    given = parse("decisions", __doc__, sets, experiments)
    for name, page in pages(given, draw(given, given.sets, given.experiments)).items():
        write(given.out, name, page, given.command())
        print(f"# {page.title}\n")
        print("\n".join(table.markdown() for table in page.tables))
    print(f"Pages, pictures, tables and sets are in {given.out}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
