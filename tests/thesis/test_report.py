"""Tables, figures and the page of the report, from synthetic rows."""

import csv
import math
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from khepera_forage.rollouts.rows import RANDOM, RecallRow, TrainingRow
from khepera_forage.task.states import State
from khepera_forage.thesis import appendix_a
from khepera_forage.thesis.cells import CellResult, cell_results
from khepera_forage.thesis.claims.evidence import gather
from khepera_forage.thesis.design import (
    LABORATORY,
    NO_LOSSES,
    NO_NOISE,
    THESIS,
    TRAINING_DISTANCE,
    noise_conditions,
)
from khepera_forage.thesis.figure_5_4 import BIN, fig_5_4, food_places, success_by_distance
from khepera_forage.thesis.figures import fig_5_2, fig_5_3, fig_5_5, fig_5_6, noise_figure
from khepera_forage.thesis.measured_tables import (
    noise_table,
    state_table,
    teacher_table,
    ties_table,
    training_table,
)
from khepera_forage.thesis.report import PAGE, write_report
from khepera_forage.thesis.statistics import UNKNOWN, Estimate
from khepera_forage.thesis.tables import Column, Table
from khepera_forage.thesis.thesis_tables import cell_table, errata_table
from tests.thesis import synthetic
from tests.thesis.synthetic import counts, failed, recall, training

REPLICATIONS = 6


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


def test_cell_results_equal_means_over_the_rows(recalls: list[RecallRow], results: list[CellResult]) -> None:
    third = results[2]
    rows = [r for r in recalls if (r.arena, r.episodes) == ("corridor", 5)]
    assert third.recalls == len(rows) == 20 * REPLICATIONS
    assert third.score.value == pytest.approx(np.mean([r.score for r in rows]))
    assert third.food.value == pytest.approx(20 * np.mean([r.delivered for r in rows]))
    assert third.scores[1] == pytest.approx(np.mean([r.score for r in rows if r.replication == 1]))
    assert third.foods[1] == sum(r.delivered for r in rows if r.replication == 1)
    assert third.score.low < third.score.value < third.score.high
    assert (third.thesis_printed, third.thesis_score, third.thesis_food) == (68.2, 68.2, 12)


def test_cell_results_ignore_other_policies(recalls: list[RecallRow], results: list[CellResult]) -> None:
    last = results[6]
    assert last.recalls == 12 * REPLICATIONS
    assert any(row.learner == RANDOM and row.arena == "rectangle" for row in recalls)


def test_cell_results_rank_among_complete_replications_only(recalls: list[RecallRow]) -> None:
    last = max(i for i, r in enumerate(recalls) if (r.arena, r.episodes) == ("corridor", 10))
    short = recalls[:last] + recalls[last + 1 :]
    result = cell_results(short, np.random.default_rng(1))[3]
    assert result.recalls == 10 * REPLICATIONS - 1
    assert len(result.scores) == result.score_rank.experiments == REPLICATIONS - 1


def test_cell_table_has_printed_and_recomputed_scores(results: list[CellResult]) -> None:
    table = cell_table(results)
    second = dict(zip((column.name for column in table.columns), table.rows[1], strict=True))
    assert second["thesis: score (%)"] == 66.75
    assert second["from its lines (%)"] == pytest.approx(67.55)
    assert second["thesis: food"] == "11 of 20"
    assert [row[:2] for row in table.rows] == [(t.arena, t.episodes) for t in appendix_a.tables()]


def test_table_as_markdown_and_csv() -> None:
    table = Table(
        "stem",
        "Title",
        "Note.",
        (Column("what"), Column("share", 2, estimate=True), Column("hidden", page=False), Column("count", 0)),
        [
            ("a | b", Estimate(0.5, 0.25, 0.75), "x", 3),
            ("c", Estimate(0.5, math.nan, math.nan), "y", math.nan),
        ],
    )
    assert table.markdown() == (
        "## Title\n\nNote.\n\n"
        "| what | share | count |\n| --- | ---: | ---: |\n"
        "| a / b | 0.50 [0.25, 0.75] | 3 |\n| c | 0.50 | - |\n"
    )
    assert (
        table.csv() == "what,share,share: low,share: high,hidden,count\na | b,0.5,0.25,0.75,x,3\nc,0.5,,,y,\n"
    )
    with pytest.raises(ValueError, match="stem: a row has 1 values; allowed: 4"):
        Table("stem", "Title", "Note.", table.columns, [("a",)])


def test_noise_table_has_the_cost_of_each_condition(
    noise_rows: list[RecallRow], trainings: list[TrainingRow]
) -> None:
    evidence = gather([], trainings, [], np.random.default_rng(1))
    table = noise_table(noise_rows, evidence)
    names = list(noise_conditions())
    assert [row[0] for row in table.rows] == names * 2
    score = {row[0]: row[2] for row in table.rows if row[1] == "corridor, 10"}
    cost = {row[0]: row[3] for row in table.rows if row[1] == "corridor, 10"}
    noiseless, noisy, difference = score[NO_NOISE], score[LABORATORY], cost[LABORATORY]
    assert isinstance(noiseless, Estimate)
    assert isinstance(noisy, Estimate)
    assert isinstance(difference, Estimate)
    assert difference.value == pytest.approx(noiseless.value - noisy.value)
    assert 0 < difference.low < difference.value < difference.high
    assert repr(cost[NO_NOISE]) == repr(UNKNOWN)


def test_training_table_counts_attempts_by_noise() -> None:
    rows = [
        training(reason="separated"),
        training(attempt=2),
        training(file=2),
        training(file=2, noise="none"),
    ]
    table = training_table(gather([], rows, [], np.random.default_rng(1)))
    assert [row[0] for row in table.rows] == ["none", LABORATORY]
    laboratory = table.rows[1]
    assert laboratory[1] == pytest.approx((1.5, math.nan, math.nan), nan_ok=True)
    assert laboratory[2:4] == (3, 2)
    assert laboratory[-1] == "separated: 1"


def test_teacher_table_has_quantiles_of_steps() -> None:
    rows = [recall(steps=s, correct=s, limit=2000, recall=s, ties=0, conflicts=0) for s in range(41, 61)]
    rows.append(failed(steps=2000, limit=2000))
    corridor, rectangle = teacher_table(gather([], [], rows, np.random.default_rng(1))).rows
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
    evidence = gather(rows, [], [], np.random.default_rng(1))
    (tie,) = ties_table(evidence).rows
    assert [estimate.value for estimate in tie[2:] if isinstance(estimate, Estimate)] == [800, 10.0, 3.0]
    states = {row[1]: row for row in state_table(evidence).rows if row[0] == "corridor"}
    visited, wrong = states["NEXT_TO_FOOD"][2:4]
    assert isinstance(visited, Estimate)
    assert isinstance(wrong, Estimate)
    assert (visited.value, wrong.value) == (20.0, 75.0)


def test_errata_table_has_all_errata() -> None:
    assert len(errata_table().rows) == 29


def test_success_by_distance_ignores_other_arenas_and_policies() -> None:
    rows = [
        recall(food_x=(-30.0,), food_y=(1.0,)),
        failed(food_x=(0.0,), food_y=(30.0,)),
        failed(food_x=(-90.0,)),
    ]
    ignored = [recall(arena="rectangle"), recall(learner=RANDOM)]
    near, far = success_by_distance(food_places(rows + ignored))
    assert (near[0], near[1], near[2].value) == (BIN * 3.5, 2, 0.5)
    assert (far[1], far[2].value) == (1, 0.0)
    assert BIN * 4 <= TRAINING_DISTANCE < BIN * 5


def test_figures_show_the_thesis_and_our_means(results: list[CellResult]) -> None:
    """The thesis's values are those of its figures 5.2, 5.3, 5.5 and 5.6."""
    for figure, arena, values, scale in (
        (fig_5_2(results), "corridor", [52.7, 67.55, 68.2, 73.8], None),
        (fig_5_3(results), "corridor", [8, 11, 12, 14], 20),
        (fig_5_5(results), "rectangle", [44.25, 60.33, 67.08], None),
        (fig_5_6(results), "rectangle", [7, 14, 13], 24),
    ):
        (axes,) = figure.axes
        points = [(line.get_marker(), np.ravel(line.get_ydata())) for line in axes.lines]
        thesis = [y[0] for marker, y in points if marker == "D"]
        ours = [y[0] for marker, y in points if marker == "o"]
        assert thesis == pytest.approx(values, abs=0.01)
        mine = [r for r in results if r.cell.arena == arena]
        if scale is None:
            assert ours == pytest.approx([r.score.value for r in mine])
        else:
            assert ours == pytest.approx([scale * r.food.value / r.cell.available for r in mine])
            assert axes.get_ylim()[1] >= scale


def test_figures_without_rows_can_be_drawn() -> None:
    results = cell_results([], np.random.default_rng(1))
    for figure in (fig_5_2(results), fig_5_3(results), fig_5_4([])):
        figure.draw_without_rendering()


def test_noise_figure_has_a_panel_for_each_cell(
    noise_rows: list[RecallRow], trainings: list[TrainingRow]
) -> None:
    table = noise_table(noise_rows, gather([], trainings, [], np.random.default_rng(1)))
    labels = [axes.get_xlabel() for axes in noise_figure(table).axes]
    assert labels == [
        "score (%)\ncorridor, 10 episodes",
        "score (%)\nrectangle, 10 episodes",
        "attempts per complete\ntraining episode",
    ]


def test_report_has_page_tables_and_figures(
    tmp_path: Path,
    recalls: list[RecallRow],
    trainings: list[TrainingRow],
    teachers: list[RecallRow],
    noise_rows: list[RecallRow],
) -> None:
    folder = tmp_path / "results"
    rng = np.random.default_rng(6)
    written = write_report(folder, recalls, trainings, teachers, noise_rows, rng, resamples=200)
    assert all(path.stat().st_size > 0 for path in written)
    page = (folder / PAGE).read_text(encoding="utf-8")
    pictures = sorted(path.name for path in written if path.suffix == ".png")
    assert pictures == [*(f"figure_5_{i}.png" for i in range(2, 7)), "noise.png"]
    for picture in pictures:
        assert f"({picture})" in page
        with Image.open(folder / picture) as image:
            assert min(image.size) > 400
    assert "6 replications, 636 recall episodes of the imitator, noise: laboratory, backend: pymunk." in page
    assert "nan" not in page
    with open(folder / "table_claims.csv", encoding="utf-8", newline="") as file:
        claims = list(csv.DictReader(file))
    assert len(claims) == 18
    assert {claim["verdict"] for claim in claims} <= {"supported", "not supported", "undecided"}
    assert float(claims[0]["value: low"]) <= float(claims[0]["value"]) <= float(claims[0]["value: high"])


def test_report_on_one_replication_has_no_supported_claim(tmp_path: Path) -> None:
    rows = synthetic.reproduction(1, np.random.default_rng(7))
    write_report(tmp_path, rows, [], [], [], np.random.default_rng(8), resamples=200)
    page = (tmp_path / PAGE).read_text(encoding="utf-8")
    assert "1 replication, 106 recall episodes" in page
    assert "| undecided |" in page
    assert "| supported |" not in page
    assert "Effect of each source of noise" not in page


def test_report_with_the_same_generator_is_the_same(tmp_path: Path, recalls: list[RecallRow]) -> None:
    pages = []
    for name in ("a", "b"):
        write_report(tmp_path / name, recalls, [], [], [], np.random.default_rng(9), resamples=200)
        pages.append((tmp_path / name / PAGE).read_text(encoding="utf-8"))
    assert pages[0] == pages[1]
