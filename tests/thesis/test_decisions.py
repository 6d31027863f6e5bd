"""Reproductions under other decisions: rows are never mixed, and those of version 0.1 stand beside them."""

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from khepera_forage.envs.backends import COMPILED
from khepera_forage.rollouts.row_files import read_rows, write_rows
from khepera_forage.rollouts.rows import IMITATOR, RecallRow
from khepera_forage.study import Job, Rows
from khepera_forage.task import decisions as decisions_module
from khepera_forage.task.decisions import Decisions
from khepera_forage.thesis import reproduce as reproduction
from khepera_forage.thesis.design import LABORATORY, NO_NOISE, THESIS
from khepera_forage.thesis.replication import UntrainedRow
from khepera_forage.thesis.reproduce import PAGE, SUMMARY, V0_1_RECALLS, write_report
from tests.thesis.synthetic import one_row, recall, training

V0_1 = Decisions.v0_1()
OTHER = replace(V0_1, next_to_food=22, food_to_home=200)
TEXT = "v0.1;food_to_home=200;next_to_food=22"
NEXT, NEXT_TEXT = replace(V0_1, next_to_food=22), "v0.1;next_to_food=22"


def test_report_refuses_rows_of_different_decisions(tmp_path: Path) -> None:
    rows = [recall(decisions=TEXT), training()]
    with pytest.raises(ValueError, match=r"rows of different decisions: food_to_home is .*; next_to_food is") as error:
        write_report(tmp_path, Rows(rows), np.random.default_rng(0))
    assert str(error.value).endswith("allowed: rows of the same decisions in one report")
    assert not list(tmp_path.iterdir())


def reproduce(out: Path, decisions: Decisions) -> Path:
    return reproduction.reproduce(0, 1, out, backend=COMPILED, decisions=decisions)


@pytest.mark.usefixtures("one_job")
def test_reproduction_refuses_a_folder_with_rows_of_other_decisions(tmp_path: Path) -> None:
    reproduce(tmp_path, OTHER)
    for path in [tmp_path / f"{name}.csv" for name in ("recalls", "trainings", "orient")]:
        content = path.read_bytes()
        message = f"{path} has rows of other decisions: food_to_home is 200, not 180; next_to_food is 22, not 20; "
        with pytest.raises(ValueError, match=re.escape(message)) as error:
            reproduce(tmp_path, V0_1)
        assert str(error.value).endswith("same decisions (now v0.1), another --out, or no such file")
        assert path.read_bytes() == content
        path.unlink()


@pytest.mark.usefixtures("one_job")
@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        (f",decisions\n(.*),{TEXT}", r"\n\1", ": food_to_home is 180, not 200"),
        (TEXT, "", ": food_to_home is 180, not 200"),
        (TEXT, "next_to_food=near", "2: decision next_to_food is 'near'; allowed: a number"),
    ],
)
def test_rows_keep_their_decisions(
    old: str, new: str, message: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Also those of version 0.1, which wrote no decisions, under other defaults, or that are damaged."""
    monkeypatch.setitem(decisions_module.VERSIONS, "v1", OTHER)
    path = tmp_path / "recalls.csv"
    write_rows(path, RecallRow, [recall(decisions=TEXT)])
    path.write_text(re.sub(old, new, path.read_text()))
    with pytest.raises(ValueError, match=re.escape(message)):
        reproduce(tmp_path, OTHER)
    path.write_text(path.read_text().partition("\n")[0] + "\n")
    reproduce(tmp_path, OTHER)


@pytest.mark.usefixtures("no_pictures")
def test_reproduction_compares_with_version_0_1(tmp_path: Path) -> None:
    """The rows are those of a reproduction under version 0.1, which is not compared with itself."""
    pytest.importorskip("numba")
    first, second, old = (tmp_path / name for name in ("first", "second", "old"))
    for out, decisions in ((first, NEXT), (second, NEXT), (old, V0_1)):
        reproduction.reproduce(3, 1, out, quick=True, backend=COMPILED, decisions=decisions)
    ours, v0_1 = (read_rows(first / name, RecallRow) for name in ("recalls.csv", V0_1_RECALLS))
    assert {row.decisions for row in ours} == {NEXT_TEXT}
    assert v0_1 == [
        row for row in read_rows(old / "recalls.csv", RecallRow) if row.learner == IMITATOR and row.noise == LABORATORY
    ]
    assert len(v0_1) == sum(cell.size for cell in THESIS)
    assert not (old / V0_1_RECALLS).exists()
    assert not any("v0.1" in (old / name).read_text() for name in ("table_cells.csv", SUMMARY))
    assert "For comparison" not in (old / PAGE).read_text()
    for name in ("recalls.csv", V0_1_RECALLS, "table_cells.csv", PAGE, SUMMARY):
        one, other = (re.sub(rb"load average [\d.]+", b"", (out / name).read_bytes()) for out in (first, second))
        assert one == other


@pytest.mark.usefixtures("no_pictures")
def test_reproduction_goes_on_without_a_noise_condition(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    missing = UntrainedRow(0, 7, NO_NOISE, "none of 200 attempts at a training episode was complete", "v0.1")
    job = Job("one", lambda: [*one_row("v0.1"), missing], ())
    monkeypatch.setattr(reproduction, "jobs", lambda *_: [job])
    page = reproduce(tmp_path, V0_1).read_text()
    assert "as no attempt at a training episode was complete: none (7)." in page
    assert "| none | corridor, 10 | - | - | - | - | 0 | 0 |" in page
    assert [row.count for row in read_rows(tmp_path / "untrained.csv", UntrainedRow)] == [7]


@pytest.mark.usefixtures("one_job")
def test_reproduction_replaces_only_rows_of_version_0_1(tmp_path: Path) -> None:
    path = tmp_path / V0_1_RECALLS
    for _ in range(2):
        reproduce(tmp_path, NEXT)
        assert [row.decisions for row in read_rows(path, RecallRow)] == ["v0.1"]
    write_rows(path, RecallRow, [recall(decisions=NEXT_TEXT)])
    ours = tmp_path / "recalls.csv"
    ours.unlink()
    message = f"{path} has rows of other decisions: next_to_food is 22, not 20; allowed: "
    with pytest.raises(ValueError, match=re.escape(message)):
        reproduce(tmp_path, NEXT)
    assert not ours.exists(), "the command stops before the first experiment"
    reproduction.reproduce(0, 1, tmp_path, backend=COMPILED, decisions=NEXT, comparison=False)
    assert [row.decisions for row in read_rows(path, RecallRow)] == [NEXT_TEXT]


@pytest.mark.usefixtures("no_pictures")
def test_comparison_does_not_change_the_other_results(tmp_path: Path, recalls: list[RecallRow]) -> None:
    rows = [replace(row, decisions="v0.1") for row in recalls]
    for name, v0_1_recalls in (("alone", []), ("beside", rows)):
        rng = np.random.default_rng(9)
        write_report(tmp_path / name, Rows(recalls), rng, resamples=200, v0_1_recalls=v0_1_recalls)
    claims = [(tmp_path / name / "table_claims.csv").read_bytes() for name in ("alone", "beside")]
    assert claims[0] == claims[1]
