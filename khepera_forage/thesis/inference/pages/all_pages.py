"""All pages of the inference, by the name of their files."""

import numpy as np

from khepera_forage.figures import COLOURS, GREY, OURS
from khepera_forage.noise import Noise
from khepera_forage.study import Arguments, Page
from khepera_forage.task.decisions import Decisions
from khepera_forage.thesis.design import ARENAS, THESIS
from khepera_forage.thesis.inference import individual_recalls
from khepera_forage.thesis.inference.draw import Drawn
from khepera_forage.thesis.inference.pages import (
    cells_page,
    claims_page,
    posterior_page,
    prior_page,
    questions_page,
    test_set_page,
    validation_page,
)
from khepera_forage.thesis.inference.pages.cells_page import Predictions
from khepera_forage.thesis.inference.posterior import Posterior, infer
from khepera_forage.thesis.inference.prior import Laboratory
from khepera_forage.thesis.inference.sensitivity import QUICK_RESAMPLES, RESAMPLES
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
    resamples = QUICK_RESAMPLES if given.quick else RESAMPLES
    return {
        "prior": prior_page.page(drawn),
        "validation": validation_page.page(posterior),
        "posterior": posterior_page.page(drawn, posterior, given.seed, resamples),
        "cells": cells_page.page([*known, inferred], thesis),
        "test_set": test_set_page.page(inferred, drawn.statistics, posterior.weights, known),
        "claims": claims_page.page(given, drawn, posterior),
        "questions": questions_page.page(posterior, drawn.statistics, given.seed),
    }
