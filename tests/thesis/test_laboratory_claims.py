"""The claims under one laboratory: those of the ordinary reproduction, with other decisions and another noise."""

import re
from dataclasses import replace

import numpy as np
import pytest

from khepera_forage import Decisions, Noise
from khepera_forage.envs.backends import COMPILED
from khepera_forage.rollouts.rows import RecallRow, TrainingRow
from khepera_forage.rollouts.training import IncompleteTrainingError
from khepera_forage.study import Rows
from khepera_forage.task.decisions import DEFAULT_DECISIONS
from khepera_forage.thesis.claims import claims, gather
from khepera_forage.thesis.design import LABORATORY, NO_LOSSES
from khepera_forage.thesis.inference.claims import CLAIMS, RESAMPLES, LaboratoryClaims, claim_table, claims_of, measure
from khepera_forage.thesis.inference.prior import LabModel
from khepera_forage.thesis.replication import JobCounts, jobs

pytest.importorskip("numba")

REPLICATIONS = 5
"""As few as give intervals."""
DEFAULT = LabModel(Decisions(), Noise.laboratory())


def test_default_laboratory_has_the_claims_of_the_ordinary_reproduction() -> None:
    counts = JobCounts(REPLICATIONS, REPLICATIONS, (NO_LOSSES,), 20, 25)
    rows = Rows(row for job in jobs(3, counts, DEFAULT_DECISIONS, COMPILED) for row in job.run())
    recalls = [row for row in rows.of(RecallRow) if row.noise == LABORATORY]
    evidence = gather(recalls, rows.of(TrainingRow), np.random.default_rng(3), RESAMPLES)
    assert claims_of(DEFAULT, 3, REPLICATIONS) == claims(evidence)


def test_laboratory_without_complete_training_is_an_error() -> None:
    reversed_markers = replace(Noise.laboratory(), reversal_rate=1.0)
    hopeless = LabModel(Decisions(next_to_food=22, most_attempts=2), reversed_markers)
    with pytest.raises(IncompleteTrainingError):
        claims_of(hopeless, 3, 1)
    (row,) = measure(3, 0, hopeless, 1)
    assert re.match(r"none of 2 attempts .* was complete, .*; seed \d+, decisions: .*next_to_food=22", row.reason)
    assert not row.verdicts


def test_tables_of_claims_have_shares_of_the_laboratories_that_were_measured() -> None:
    held = LaboratoryClaims(0, "{}", "", ("supported",) * len(CLAIMS), (1.0,) * len(CLAIMS))
    not_held = replace(held, verdicts=("undecided",) * len(CLAIMS), effects=(3.0,) * len(CLAIMS))
    unmeasured = LaboratoryClaims(2, "{}", "no training", (), ())
    claimed = claim_table([held], [held, not_held, unmeasured])
    for line in claimed.rows:
        assert (line[2].value, line[3].value) == (100, 50)  # type: ignore[union-attr]
    assert claimed.rows[0][4] == "+2.0 points"
    assert "Share of 1 admissible laboratories of the prior, and of 2 laboratories" in claimed.note
