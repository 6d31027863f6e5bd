"""`benchmarks/thesis.py`: the main job in small leaves its report, its pictures and its rows."""

from pathlib import Path

import pytest

from tests.benchmarks.running import help_of, is_picture, quick_here, read

ARGUMENTS = {"pymunk": ("--replications", "1", "--no-comparison"), "compiled": ()}
"""On pymunk a replication takes seconds; `tests/thesis/test_comparison.py` compares with version 0.1 there."""


@pytest.fixture(scope="module", params=["pymunk", "compiled"])
def out(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Path:
    if request.param == "compiled":
        pytest.importorskip("numba")
    folder = tmp_path_factory.mktemp("run") / "thesis"
    printed = quick_here("thesis", folder, "--backend", request.param, *ARGUMENTS[request.param])
    (folder.parent / "printed").write_text(printed, encoding="utf-8")
    return folder


def test_report_is_written_and_printed(out: Path) -> None:
    page = (out / "thesis.md").read_text(encoding="utf-8")
    assert page.strip() in (out.parent / "printed").read_text(encoding="utf-8")
    assert "| " in page


def test_pictures_are_drawn(out: Path) -> None:
    for figure in ("figure_5_2", "figure_5_3", "figure_5_4", "figure_5_5", "figure_5_6"):
        assert is_picture(out / f"{figure}.png")


def test_rows_are_kept(out: Path) -> None:
    recalls, trainings = read(out / "recalls.csv"), read(out / "trainings.csv")
    assert {row["learner"] for row in recalls} == {"imitator", "teacher", "random"}
    assert {row["arena"] for row in recalls} == {"corridor", "rectangle"}
    for row in recalls:
        assert 1 <= int(row["steps"]) <= int(row["limit"])
        assert 0 <= int(row["delivered"]) <= int(row["foods"])
    complete = [row for row in trainings if row["complete"] == "1"]
    assert complete
    assert all(int(row["vectors"]) > 0 for row in complete)


def test_help_names_every_argument() -> None:
    told = help_of("thesis")
    for argument in ("--seed", "--out", "--quick", "--replications", "--jobs", "--backend"):
        assert argument in told
