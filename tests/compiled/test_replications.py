"""Compiled replications of the thesis's design: rows like those of pymunk, under any decisions."""

from dataclasses import replace

import pytest

from khepera_forage.rollouts.rows import RANDOM, TEACHER, RecallRow, TrainingRow
from khepera_forage.study import Rows
from khepera_forage.task.decisions import Decisions
from khepera_forage.thesis.compiled_replications import baselines, replicate_together
from khepera_forage.thesis.design import Cell, Subset
from khepera_forage.thesis.orient_analysis import OrientRow

SMALL = (Cell("corridor", 2, (Subset((1,)), Subset((1, 2))), 2, foods=1, limit=500),)
OTHER = replace(Decisions.v0_1(), next_to_food=22, food_to_home=200)
TEXT = "v0.1;food_to_home=200;next_to_food=22"


@pytest.mark.parametrize(("decisions", "text"), [(Decisions.v0_1(), "v0.1"), (OTHER, TEXT)])
def test_rows_of_replications_name_their_decisions(decisions: Decisions, text: str) -> None:
    made = replicate_together(0, 0, 2, cells=SMALL, decisions=decisions)
    outcome = Rows(made)
    assert {row.decisions for row in made} == {text}
    assert [row.file_id for row in outcome.of(RecallRow)] == ["g1", "g1", "g12", "g12"] * 2
    assert sum(row.complete for row in outcome.of(TrainingRow)) == 4
    assert len(outcome.of(OrientRow)) == 2 * 2 * 6


@pytest.mark.parametrize("learner", [TEACHER, RANDOM])
def test_rows_of_a_baseline_name_their_decisions(learner: str) -> None:
    rows = Rows(baselines(0, 2, learner, "corridor", 3, decisions=OTHER)).of(RecallRow)
    assert {row.decisions for row in rows} == {TEXT}
    assert [row.replication for row in rows] == [0, 0, 0, 1, 1, 1]
    if learner == TEACHER:
        assert {row.score for row in rows} == {100.0}, "it forages under the same decisions"
