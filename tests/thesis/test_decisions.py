"""Reproductions under other decisions: they reach every environment and every row, and are never mixed."""

import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from khepera_forage.envs.backends import COMPILED
from khepera_forage.rollouts.row_files import write_rows
from khepera_forage.rollouts.rows import RANDOM, TEACHER, RecallRow
from khepera_forage.study import Rows
from khepera_forage.task import decisions as decisions_module
from khepera_forage.task.decisions import Decisions, decisions_text
from khepera_forage.thesis import reproduce as reproduction
from khepera_forage.thesis.design import Cell, Subset
from khepera_forage.thesis.orient_analysis import OrientRow, arrival_vectors
from khepera_forage.thesis.replication import baseline, replicate
from khepera_forage.thesis.reproduce import write_report
from tests.thesis.synthetic import recall, training

V0_1 = Decisions.v0_1()
OTHER = replace(V0_1, next_to_food=22, food_to_home=200)
TEXT = "v0.1;food_to_home=200;next_to_food=22"
DIFFERENCES = "food_to_home is 200, not 180; next_to_food is 22, not 20"
SMALL = (Cell("corridor", 1, (Subset((1,)),), 1, foods=1, limit=500),)


def test_arrival_vectors_follow_the_decisions() -> None:
    """The robot arrives 20 to 22 pixels from the food; the first place is 10 pixels nearer to home than in training."""
    assert arrival_vectors(OTHER)[0, :, [1, 4]].T.tolist() == [[50, 20], [51, 21], [52, 22]]


def test_rows_of_a_replication_name_its_decisions() -> None:
    rows = replicate(1, 0, cells=SMALL, decisions=OTHER)
    assert len(Rows(rows).of(OrientRow)) == 6
    assert {row.decisions for row in rows} == {TEXT}
    defaults = decisions_text(Decisions())
    assert {row.decisions for row in replicate(1, 0, cells=SMALL)} == {defaults}


@pytest.mark.parametrize("learner", [TEACHER, RANDOM])
def test_rows_of_a_baseline_name_its_decisions(learner: str) -> None:
    (row,) = Rows(baseline(0, 0, learner, "corridor", 1, decisions=OTHER)).of(RecallRow)
    assert row.decisions == TEXT
    assert row.score == 100 or learner == RANDOM, "the teacher classifies states with the same thresholds"


@pytest.mark.parametrize("table", ["recalls", "trainings", "teachers", "noise_rows", "orient_rows"])
def test_report_refuses_rows_of_different_decisions(table: str, tmp_path: Path) -> None:
    rows: dict[str, list[Any]] = {
        "recalls": [recall()],
        "trainings": [training()],
        "teachers": [recall(learner=TEACHER)],
        "noise_rows": [recall()],
        "orient_rows": [OrientRow(0, 1, "g1", 0, 1.0, 0.0, 0.0)],
    }
    rows[table] = [replace(rows[table][0], decisions=TEXT)]
    with pytest.raises(
        ValueError, match=r"rows of different decisions: food_to_home is .*; next_to_food is"
    ) as error:
        write_report(
            tmp_path,
            rows["recalls"],
            rows["trainings"],
            rows["teachers"],
            rows["noise_rows"],
            np.random.default_rng(0),
            orient_rows=rows["orient_rows"],
        )
    assert str(error.value).endswith("allowed: rows of the same decisions in one report")
    assert not list(tmp_path.iterdir())


def reproduce(out: Path, decisions: Decisions | None) -> Path:
    return reproduction.reproduce(0, 1, out, backend=COMPILED, decisions=decisions)


@pytest.mark.usefixtures("one_job")
@pytest.mark.parametrize("name", ["recalls", "trainings", "orient"])
def test_reproduction_refuses_a_folder_with_rows_of_other_decisions(name: str, tmp_path: Path) -> None:
    reproduce(tmp_path, OTHER)
    for other in {"recalls", "trainings", "orient"} - {name}:
        (tmp_path / f"{other}.csv").unlink()
    path = tmp_path / f"{name}.csv"
    before = path.read_bytes()
    with pytest.raises(
        ValueError, match=re.escape(f"{path} has rows of other decisions: {DIFFERENCES}; ")
    ) as error:
        reproduce(tmp_path, V0_1)
    assert str(error.value).endswith("same decisions (now v0.1), another --out, or no such file")
    with pytest.raises(ValueError, match=re.escape(f"{path} has rows of other decisions: ")) as error:
        reproduce(tmp_path, None)
    assert f"(now {decisions_text(Decisions())})" in str(error.value)
    assert path.read_bytes() == before


@pytest.mark.usefixtures("one_job")
def test_rows_of_an_older_version_are_of_its_decisions(tmp_path: Path) -> None:
    path = tmp_path / "recalls.csv"
    write_rows(path, RecallRow, [recall()])
    path.write_text(path.read_text().replace(",decisions\n", "\n").replace(",\n", "\n"))
    with pytest.raises(ValueError, match="has rows of other decisions: food_to_home is 180, not 200"):
        reproduce(tmp_path, OTHER)
    path.write_text(path.read_text().split("\n")[0] + "\n")
    reproduce(tmp_path, OTHER)


@pytest.mark.usefixtures("one_job")
@pytest.mark.parametrize("text", ["", "v0.1"])
def test_rows_keep_their_decisions_under_other_defaults(
    text: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(decisions_module.VERSIONS, "v1", OTHER)
    write_rows(tmp_path / "recalls.csv", RecallRow, [recall(decisions=text)])
    with pytest.raises(ValueError, match="food_to_home is 180, not 200") as error:
        reproduce(tmp_path, OTHER)
    assert "(now v1)" in str(error.value)


@pytest.mark.usefixtures("one_job")
def test_reproduction_refuses_a_damaged_row(tmp_path: Path) -> None:
    path = tmp_path / "recalls.csv"
    write_rows(path, RecallRow, [recall(decisions=TEXT)])
    path.write_text(path.read_text().replace(TEXT, "next_to_food=near"))
    with pytest.raises(
        ValueError, match=re.escape(f"{path}:2: decision next_to_food is 'near'; allowed: a number")
    ):
        reproduce(tmp_path, OTHER)


def test_reproduction_refuses_something_else_than_decisions(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match=r"decisions is 17; allowed: a khepera_forage\.Decisions, or None"):
        reproduction.reproduce(0, 1, tmp_path, decisions=17)  # type: ignore[arg-type]
