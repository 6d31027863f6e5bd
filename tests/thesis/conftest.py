"""Synthetic reproductions that the tests of tables, figures and the report share."""

import numpy as np
import pytest

from khepera_forage import study
from khepera_forage.rollouts.rows import RANDOM, RecallRow, TrainingRow
from khepera_forage.thesis import reproduce as reproduction
from khepera_forage.thesis.design import (
    LABORATORY,
    NO_LOSSES,
    THESIS,
    noise_conditions,
)
from khepera_forage.thesis.tables import CellResult, cell_results
from tests.thesis import synthetic

REPLICATIONS = 6


@pytest.fixture
def no_pictures(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let a report have no pictures, which take most of its time; those of `test_report.py` have them."""
    monkeypatch.setattr(study, "save", lambda figure, path: None)


@pytest.fixture
def one_job(monkeypatch: pytest.MonkeyPatch, no_pictures: None) -> None:
    """Let a reproduction on compiled worlds have one job of one row of each kind."""
    monkeypatch.setattr(reproduction, "compiled_jobs", synthetic.one_row_jobs)


@pytest.fixture(scope="module")
def recalls() -> list[RecallRow]:
    rng = np.random.default_rng(1)
    chance = synthetic.cell_rows(THESIS[6], REPLICATIONS, rng, 0.3, lambda distance: 0.02, learner=RANDOM)
    return synthetic.reproduction(REPLICATIONS, rng) + chance


@pytest.fixture(scope="module")
def trainings() -> list[TrainingRow]:
    rng = np.random.default_rng(2)
    return [
        row
        for noise, complete in ((LABORATORY, 0.6), (NO_LOSSES, 0.9))
        for row in synthetic.attempts(REPLICATIONS, rng, noise, complete)
    ]


@pytest.fixture(scope="module")
def teachers() -> list[RecallRow]:
    rng = np.random.default_rng(3)
    return synthetic.teachers(REPLICATIONS, rng, "corridor", 110) + synthetic.teachers(
        REPLICATIONS, rng, "rectangle", 900
    )


@pytest.fixture(scope="module")
def noise_rows() -> list[RecallRow]:
    rng = np.random.default_rng(4)
    return [
        row
        for i, noise in enumerate(noise_conditions())
        for cell in (THESIS[3], THESIS[6])
        for row in synthetic.cell_rows(cell, REPLICATIONS, rng, 0.85 - 0.02 * i, lambda d: 0.7, noise=noise)
    ]


@pytest.fixture(scope="module")
def results(recalls: list[RecallRow]) -> list[CellResult]:
    return cell_results(recalls, np.random.default_rng(5))
