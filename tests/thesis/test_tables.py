"""Results of cells, and the tables of the report, from synthetic rows."""

import math
from typing import Any

import numpy as np
import pytest

from khepera_forage.estimates import Column, Estimate, Table, pick
from khepera_forage.rollouts.rows import TEACHER, RecallRow
from khepera_forage.task.states import State
from khepera_forage.thesis import appendix_a, tables
from khepera_forage.thesis.claims import Evidence, gather
from khepera_forage.thesis.design import FOODS, LABORATORY, NO_NOISE, noise_conditions
from tests.thesis.conftest import REPLICATIONS
from tests.thesis.synthetic import counts, failed, recall, training


def test_cell_results_equal_means_over_the_rows(recalls: list[RecallRow], results: list[tables.CellResult]) -> None:
    third = results[2]
    rows = pick(recalls, arena="corridor", episodes=5)
    assert third.recalls == len(rows) == 20 * REPLICATIONS
    assert third.score.ours.value == pytest.approx(np.mean([r.score for r in rows]))
    assert third.food.ours.value == pytest.approx(20 * np.mean([r.delivered for r in rows]))
    assert third.score.experiments[1] == pytest.approx(np.mean([r.score for r in rows if r.replication == 1]))
    assert third.food.experiments[1] == sum(r.delivered for r in rows if r.replication == 1)
    assert third.score.ours.low < third.score.ours.value < third.score.ours.high
    assert (third.thesis_printed, third.score.thesis, third.food.thesis) == (68.2, 68.2, 12)
    # An incomplete replication is no experiment.
    last = pick(recalls, arena="corridor", episodes=10)[-1]
    result = tables.cell_results([row for row in recalls if row is not last], np.random.default_rng(1))[3]
    assert result.recalls == 10 * REPLICATIONS - 1
    assert len(result.score.experiments) == REPLICATIONS - 1


def test_cell_table_has_printed_and_recomputed_scores(results: list[tables.CellResult]) -> None:
    table = tables.cell_table(results)
    second = dict(zip((column.name for column in table.columns), table.rows[1], strict=True))
    assert second["thesis: score (%)"] == 66.75
    assert second["from its lines (%)"] == pytest.approx(67.55)
    assert second["thesis: food"] == "11 of 20"
    assert [row[:2] for row in table.rows] == [(t.arena, t.episodes) for t in appendix_a.TABLES]


def test_table_as_markdown_csv_and_text() -> None:
    table = Table(
        "stem",
        "Title",
        "Note.",
        (Column("what"), Column("share", 2, estimate=True), Column("hidden", page=False), Column("count", 0)),
        [("a | b", Estimate(0.5, 0.25, 0.75), "x", 3), ("c", Estimate(0.5, math.nan, math.nan), "y", math.nan)],
    )
    assert table.markdown() == (
        "## Title\n\nNote.\n\n"
        "| what | share | count |\n| --- | ---: | ---: |\n"
        "| a / b | 0.50 [0.25, 0.75] | 3 |\n| c | 0.50 | - |\n"
    )
    assert table.csv() == "what,share,share: low,share: high,hidden,count\na | b,0.5,0.25,0.75,x,3\nc,0.5,,,y,\n"
    assert table.text() == (
        "Title\n\nNote.\n\n"
        "what               share  count\n"
        "a | b  0.50 [0.25, 0.75]      3\n"
        "c                   0.50      -\n"
    )
    assert table.text(22).endswith("what\na | b\nc\n(2 more columns are in table_stem.csv)\n")
    assert table.text(6).endswith("wh…\na …\nc\n(2 more columns are in table_stem.csv)\n")
    with pytest.raises(ValueError, match="stem: a row has 1 values; allowed: 4"):
        Table("stem", "Title", "Note.", table.columns, [("a",)])


def test_noise_table_has_the_cost_of_each_condition(noise_rows: list[RecallRow], evidence: Evidence) -> None:
    lines: dict[str, Any] = {f"{row[0]}, {row[1]}": row for row in tables.noise_table(noise_rows, evidence).rows}
    assert list(lines) == [f"{name}, {arena}, 10" for arena in FOODS for name in noise_conditions()]
    noiseless, noisy = (lines[f"{name}, corridor, 10"] for name in (NO_NOISE, LABORATORY))
    assert noisy[3].value == pytest.approx(noiseless[2].value - noisy[2].value)
    assert noisy[3].low < noisy[3].value < noisy[3].high
    assert math.isnan(noiseless[3].value)


def test_training_table_counts_attempts_by_noise() -> None:
    rows = [training(reason="separated"), training(attempt=2), training(file=2), training(file=2, noise="none")]
    table = tables.training_table(gather([], rows, np.random.default_rng(1)))
    assert [row[0] for row in table.rows] == ["none", LABORATORY]
    laboratory = table.rows[1]
    assert laboratory[1] == pytest.approx((1.5, math.nan, math.nan), nan_ok=True)
    assert laboratory[2:4] == (3, 2)
    assert laboratory[-1] == "separated: 1"


def test_teacher_table_has_quantiles_of_steps() -> None:
    rows = [
        recall(steps=s, correct=s, limit=2000, recall=s, ties=0, conflicts=0, learner=TEACHER) for s in range(41, 61)
    ]
    rows.append(failed(steps=2000, limit=2000, learner=TEACHER))
    corridor, rectangle = tables.teacher_table(gather(rows, [], np.random.default_rng(1))).rows
    assert corridor[:7] == ("corridor", 21, 42, 51, 60, math.inf, 500)
    assert corridor[7] == pytest.approx((100 * 20 / 21, math.nan, math.nan), nan_ok=True)
    assert rectangle[1] == 0


def test_tables_of_ties_and_states_are_shares_of_steps() -> None:
    rows = [
        recall(steps=100, correct=100, ties=30, conflicts=10),
        recall(
            recall=1,
            steps=300,
            correct=240,
            ties=10,
            conflicts=2,
            wrong_by_state=counts({State.NEXT_TO_FOOD: 60}),
            rounds_by_state=counts({State.NEXT_TO_FOOD: 80, State.SEARCH: 220}),
        ),
    ]
    evidence = gather(rows, [], np.random.default_rng(1))
    ties: Any = tables.ties_table(evidence).rows
    assert [estimate.value for estimate in ties[0][2:]] == [800, 10.0, 3.0]
    states: dict[Any, Any] = {row[1]: row for row in tables.state_table(evidence).rows if row[0] == "corridor"}
    assert [estimate.value for estimate in states["NEXT_TO_FOOD"][2:4]] == [20.0, 75.0]


def test_joint_table_takes_results_together(results: list[tables.CellResult]) -> None:
    """Each mean alone is usual: in ours, scores of the rectangle rise and fall with those of the corridor."""
    rng = np.random.default_rng(0)
    common = rng.normal(size=200)
    many = [
        r._replace(
            score=r.score._replace(
                thesis=60.0 if r.cell.arena == "corridor" else 40.0,
                experiments=(50 + 5 * common + 0.5 * rng.normal(size=200)).tolist(),
            ),
            food=r.food._replace(experiments=rng.integers(r.cell.available, size=200).tolist()),
        )
        for r in results
    ]
    steps = [recall(replication=k, steps=steps, correct=90) for k, steps in enumerate((200, 100, 150))]
    rows: dict[Any, Any] = {row[0]: row[1:] for row in tables.joint_table(many, [*steps, failed()]).rows}
    thesis, ours, percentile, tail = rows["mean score, rectangle (%)"]
    assert (thesis, ours) == pytest.approx((40.0, 50.0), abs=1)
    assert 0 < percentile < 6
    assert tail > 0.01
    assert rows["sum of all scores (%)"][0] == pytest.approx(4 * 60 + 3 * 40)
    assert rows["median steps of successful recalls, corridor"] == (185.5, 150.0, pytest.approx(66.7, abs=0.1), 1.0)
    assert rows["Mahalanobis distance of all means"][3] == pytest.approx(1 / 201)
    assert not tables.joint_table(many[:3], steps).rows, "it needs the whole design"
    assert not tables.joint_table(results, steps).rows, "it needs many experiments"
