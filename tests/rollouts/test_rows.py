"""Rows and their files: consistency, writing, strict reading and incomplete files."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from khepera_forage.rollouts.row_files import RowWriter, read_rows, write_rows
from khepera_forage.rollouts.rows import RecallRow, TrainingRow
from khepera_forage.task.states import State
from tests.limited_disk import largest_file
from tests.thesis.synthetic import counts, failed, recall, training

NEXT, SEARCH = State.NEXT_TO_FOOD, State.SEARCH
MORE = {"steps": 201, "rounds_by_state": (201,) + (0,) * 9}
ELSEWHERE = {"wrong_by_state": counts({NEXT: 40}), "rounds_by_state": counts({SEARCH: 200})}


@pytest.mark.parametrize(
    ("row", "changes", "message"),
    [
        (recall, {"steps": 501}, r"steps is 501; allowed: 1\.\.limit, which is 500"),
        (recall, {"correct": 201, "wrong_by_state": counts({})}, r"correct is 201; allowed: 0\.\.steps, which"),
        (recall, {"score": 79.0}, r"score is 79.0; allowed: 80.000000"),
        (recall, {"food_x": (1.0, 2.0)}, r"food_x is \(1.0, 2.0\); allowed: one value for each of 1 foods"),
        (recall, {"delivered": 0, "penalty": 0}, r"delivered is 0; allowed: 1, the sum of food_delivered"),
        (recall, {"wrong_by_state": counts({SEARCH: 39}), **MORE}, "wrong_by_state is .* that add up to 41"),
        (recall, {"rounds_by_state": (200,) + (0,) * 8}, "rounds_by_state is .*; allowed: 10 counts"),
        (recall, ELSEWHERE, r"wrong_by_state\[2\] is 40; allowed: at most 0"),
        (recall, {"orient_without_food": 41}, r"orient_without_food is 41; allowed: 0\.\.40 wrong rounds"),
        (recall, {"conflicts": 51}, r"conflicts is 51; allowed: 0\.\.50 ties"),
        (recall, {"decisions": "next_to_foot=17"}, "decision 'next_to_foot' is unknown; allowed"),
        (training, {"complete": False}, "reason is ''; allowed: empty if and only if complete"),
        (training, {"complete": True, "reason": "separated"}, "reason is 'separated'; allowed"),
        (training, {"vectors": 121}, r"vectors is 121; allowed: 0\.\.120 rounds"),
        (training, {"attempt": 0}, "attempt is 0; allowed: 1 or more"),
        (training, {"decisions": "patience=0"}, "decision patience is 0; allowed: a whole number from 1"),
    ],
)
def test_inconsistent_row_is_an_error(row: Callable[..., Any], changes: dict[str, Any], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        row(**changes)


def test_recall_row_has_derived_properties() -> None:
    row = failed(
        food_x=(-30.0,),
        food_y=(40.0,),
        wrong_by_state=counts({State.SEARCH: 80, State.NEXT_TO_FOOD: 120}),
        rounds_by_state=counts({State.SEARCH: 370, State.NEXT_TO_FOOD: 130}),
    )
    assert row.food_home_distances == (50.0,)
    assert row.failed
    assert row.failure_mode is State.NEXT_TO_FOOD
    assert (row.orient_wanted, row.orient_missed) == (130, 120)
    assert recall().failure_mode is None
    assert failed(correct=500).failure_mode is None


def test_written_rows_are_read_equal(tmp_path: Path) -> None:
    rows = [
        recall(),
        failed(start_x=-1 / 3),
        recall(arena="rectangle", food_delivered=(True, False), food_x=(0.1, 2.0), food_y=(1e-9, 3.0)),
    ]
    tries = [training(), training(attempt=2, reason='separated, "too long"')]
    write_rows(tmp_path / "recalls.csv", RecallRow, rows)
    write_rows(tmp_path / "trainings.csv", TrainingRow, tries)
    assert read_rows(tmp_path / "recalls.csv", RecallRow) == rows
    assert read_rows(tmp_path / "trainings.csv", TrainingRow) == tries


def test_earlier_rows_stay_until_the_first_new_one(tmp_path: Path) -> None:
    path = tmp_path / "rows.csv"
    write_rows(path, RecallRow, [recall(), recall(recall=1)])
    with RowWriter(path, RecallRow) as writer:
        assert len(read_rows(path, RecallRow)) == 2
        writer.write(recall(recall=2))
        writer.write(recall(recall=3))
    assert read_rows(path, RecallRow) == [recall(recall=2), recall(recall=3)]
    with RowWriter(path, RecallRow) as writer, largest_file(5), pytest.raises(OSError, match=r"rows\.csv"):
        writer.write(recall())
    assert read_rows(path, RecallRow) == [recall(recall=2), recall(recall=3)]


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("replication,", "replica,", "1: header is 'replica,"),
        ("\n0,1,1", "\n0,one,1", "2: file is 'one'; allowed: a whole number"),
        ("\n0,1,1", "\n0, 1,1", "2: file is ' 1'; allowed: a whole number"),
        (",1,120,", ",yes,120,", "2: complete is 'yes'; allowed: 0 or 1"),
        (",1,120,", ",120,", "2: 10 values; allowed: 11"),
        (",120,", ",100,", r"2: vectors is 110; allowed: 0\.\.100 rounds"),
        ("laboratory", '"laboratory', "2: line is .*laboratory.*; allowed: comma-separated values"),
        ("\n0,1,2", "\n0,1,1", "3: the row repeats line 2"),
    ],
)
def test_damaged_file_is_an_error(tmp_path: Path, old: str, new: str, message: str) -> None:
    path = tmp_path / "rows.csv"
    write_rows(path, TrainingRow, [training(), training(attempt=2)])
    path.write_text(path.read_text().replace(old, new))
    with pytest.raises(ValueError, match=f"rows.csv:{message}"):
        read_rows(path, TrainingRow)


def test_empty_file_is_an_error(tmp_path: Path) -> None:
    (tmp_path / "rows.csv").touch()
    with pytest.raises(ValueError, match=r"rows.csv:1: header is ''"):
        read_rows(tmp_path / "rows.csv", TrainingRow)
