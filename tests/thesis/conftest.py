"""A small reproduction that the tests of tables, figures and the report share."""

from pathlib import Path

import numpy as np
import pytest

from khepera_forage import study
from khepera_forage.envs.backends import COMPILED
from khepera_forage.estimates import pick
from khepera_forage.rollouts.rows import RecallRow, TrainingRow
from khepera_forage.study import Rows
from khepera_forage.task.decisions import DEFAULT_DECISIONS
from khepera_forage.thesis import reproduce as reproduction
from khepera_forage.thesis.claims import Evidence, gather
from khepera_forage.thesis.design import LABORATORY, noise_conditions
from khepera_forage.thesis.replication import JobCounts, jobs
from khepera_forage.thesis.tables import CellResult, cell_results
from tests.thesis import synthetic

REPLICATIONS = 6
PUBLISHED = Path(__file__).parents[2] / "docs" / "published" / "thesis.zip"


@pytest.fixture
def no_pictures(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let a report have no pictures, which take most of its time; those of `test_report.py` have them."""
    monkeypatch.setattr(study, "save", lambda figure, path: None)


@pytest.fixture
def one_job(monkeypatch: pytest.MonkeyPatch, no_pictures: None) -> None:
    """Let a reproduction on compiled worlds have one job of one row of each kind."""
    monkeypatch.setattr(reproduction, "jobs", synthetic.one_row_jobs)


@pytest.fixture(scope="session")
def rows() -> Rows:
    pytest.importorskip("numba")
    conditions = tuple(name for name in noise_conditions() if name != LABORATORY)
    counts = JobCounts(REPLICATIONS, REPLICATIONS, conditions, REPLICATIONS, 10)
    return Rows(row for job in jobs(3, counts, DEFAULT_DECISIONS, COMPILED) for row in job.run())


@pytest.fixture(scope="session")
def recalls(rows: Rows) -> list[RecallRow]:
    return pick(rows.of(RecallRow), noise=LABORATORY)


@pytest.fixture(scope="session")
def trainings(rows: Rows) -> list[TrainingRow]:
    return rows.of(TrainingRow)


@pytest.fixture(scope="session")
def noise_rows(rows: Rows) -> list[RecallRow]:
    return pick(rows.of(RecallRow), episodes=10)


@pytest.fixture(scope="session")
def evidence(recalls: list[RecallRow], trainings: list[TrainingRow]) -> Evidence:
    return gather(recalls, trainings, np.random.default_rng(1), 200)


@pytest.fixture(scope="session")
def results(recalls: list[RecallRow]) -> list[CellResult]:
    return cell_results(recalls, np.random.default_rng(5))
