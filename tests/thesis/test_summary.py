"""Summary statistics of experiments: of our recalls, and of the thesis's lines."""

import numpy as np
import pytest

from khepera_forage.thesis.design import THESIS, Cell, Subset
from khepera_forage.thesis.inference.simulate import FASTEST
from khepera_forage.thesis.inference.summary import (
    FITTED,
    NAMES,
    SLOPES,
    CellRecalls,
    of_recalls,
    printed_lines,
    printed_recalls,
    thesis_statistics,
    usable_lines,
)

pytest.importorskip("numba")
CELL = Cell("rectangle", 1, (Subset((1,)), Subset((2,))), 2, foods=2, limit=700)


def test_recalls_are_summarised_experiment_by_experiment() -> None:
    correct = np.array([[[70.0, 140.0], [350.0, 90.0]], [[700.0, 700.0], [700.0, 700.0]]])
    steps = np.array([[[100.0, 200.0], [700.0, 100.0]], [[700.0] * 2] * 2])
    delivered = np.array([[[2.0, 2.0], [1.0, 2.0]], [[0.0] * 2] * 2])
    penalty = np.array([[[0.0, 0.0], [5.0, 0.0]], [[20.0] * 2] * 2])
    summary = of_recalls(CELL, CellRecalls(correct, steps, delivered, penalty))
    assert summary.score.tolist() == [(70 + 70 + 45 + 90) / 4, 80.0]
    assert summary.food.tolist() == [7 / 8, 0.0]
    assert summary.right_failed.tolist() == [50.0, 100.0]
    assert summary.right_successful[0] == pytest.approx((70 + 70 + 90) / 3)
    assert summary.steps_successful[0] == 100.0
    assert summary.spread.tolist() == [pytest.approx(np.std([70, 67.5], ddof=1)), 0.0]
    assert np.isnan([summary.right_successful[1], summary.steps_successful[1]]).all()
    one = np.full((1, 1, 1), 1.0)
    summary = of_recalls(Cell("corridor", 10, (Subset((1,)),), 1, 1, 500), CellRecalls(2 * one, 3 * one, one, 0 * one))
    assert summary.score.tolist() == [66.0], "fractions of a percent are cut off, as in the thesis"
    assert np.isnan(summary.spread).all()


def by_name() -> dict[str, float]:
    return dict(zip((*NAMES, *SLOPES), thesis_statistics().tolist(), strict=True))


def test_lines_that_were_filled_down_or_contradict_themselves_are_left_out() -> None:
    """Of 195 to 198 of 249, and 159 to 161 of 490, only the first could have been measured."""
    steps = [(row.correct, row.total) for row in usable_lines(THESIS[0])]
    assert len(steps) == 15
    assert [one for one in steps if one[1] in (249, 490)] == [(195, 249), (159, 490)]
    assert by_name()["corridor 1 steps_successful"] == 233.5
    assert by_name()["corridor 10 score"] == pytest.approx(73.8, abs=0.5)


def test_simulated_lines_are_left_out_by_the_rule_of_the_printed_ones() -> None:
    lines = [line for line in printed_lines(THESIS[0]) if line.file_id == "g3"]
    cell = Cell("corridor", 1, (Subset((3,)),), 4, 1, 500)
    printed = printed_recalls(cell, lines)
    simulated = CellRecalls(*(np.repeat(array, 2, axis=0) for array in printed))
    assert simulated.usable(500).tolist() == [[[True, True, False, False]]] * 2
    late = printed._replace(steps=np.full((1, 1, 4), 500.0), penalty=np.array([[[20.0, 20.0, 20.0, 0.0]]]))
    assert late.usable(500).tolist() == [[[True, True, True, False]]], "equal counts at the limit are chance"


def test_statistics_have_names_and_rectangle_is_never_fitted() -> None:
    statistics = thesis_statistics()
    assert len(statistics) == len(NAMES) + len(SLOPES) == 46
    assert all(name.startswith("corridor") for name in FITTED)
    assert len(FITTED) == 4 * 6 + 2
    named = by_name()
    food = [named[f"{cell.arena} {cell.episodes} food"] for cell in THESIS]
    assert food == pytest.approx([8 / 20, 11 / 20, 12 / 20, 7 / 10, 7 / 24, 14 / 24, 13 / 24])
    assert named["corridor slope of food"] == pytest.approx(0.3)
    assert named["rectangle slope of score"] == pytest.approx(named["rectangle 10 score"] - named["rectangle 1 score"])


def test_fastest_recalls_are_those_of_the_usable_lines() -> None:
    steps: dict[str, list[int]] = {cell.arena: [] for cell in THESIS}
    for cell in THESIS:
        steps[cell.arena] += [row.total for row in usable_lines(cell)]
    assert {arena: min(totals) for arena, totals in steps.items()} == FASTEST
