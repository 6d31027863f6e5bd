"""The `khepera-forage reproduce` command, with one synthetic job for each set of decisions."""

from pathlib import Path

import pytest

from khepera_forage.study import Job
from khepera_forage.thesis import reproduce as reproduction
from khepera_forage.thesis.replication import Row
from tests.benchmarks.running import read
from tests.cli.running import Run
from tests.thesis.synthetic import one_row_jobs


@pytest.fixture(autouse=True)
def one_job(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(reproduction, "jobs", one_row_jobs)


REPRODUCE = "reproduce --quick --out . --decision next_to_food=22 --decision close_to_food=31"


def test_reproduce_ends_with_a_summary_of_both_decisions(run: Run) -> None:
    start, end = run(REPRODUCE).split("Summary\n")
    assert "smoke test" in start
    page = Path("thesis.md").read_text(encoding="utf-8")
    assert page.startswith("# The thesis's experiments, repeated")
    size = "1 replication, 1 recall episodes of the imitator"
    assert f"{size}, noise: laboratory, decisions: v1, next_to_food=22, close_to_food=31, backend: compiled. " in page
    assert f"For comparison: {size}, decisions: v0.1. " in page
    assert "`recalls_v0.1.csv`" in page
    assert "| v0.1: score (%) |" in page
    assert "| undecided |" in page
    assert "| supported |" not in page, "one replication gives no interval"
    assert "Effect of each source of noise" not in page
    fourth = read(Path("table_cells.csv"))[3]
    assert float(fourth["ours: score (%)"]) == float(fourth["v0.1: score (%)"]) == 80.0
    assert {"v0.1: score percentile", "v0.1: food: low", "v0.1: food percentile"} <= fourth.keys()
    assert "\n\n## Command\n\n    " in page
    lines = end.strip().splitlines()
    assert "arena      episodes  score (%): thesis  ours  v0.1  food: thesis  ours  v0.1" in lines
    assert lines[-1] == "Page (thesis.md), tables, figures and rows are in ."
    assert max(map(len, lines[:-1])) <= 80
    (last,) = (line.split() for line in lines if line.startswith("corridor") and "10" in line.split())
    assert last == ["corridor", "10", "73.80", "80.0", "80.0", "7", "of", "10", "10.0", "10.0"]
    assert Path("recalls_v0.1.csv").exists()


def test_reproduce_without_comparison_has_only_our_results(run: Run) -> None:
    assert "v0.1" not in run(f"{REPRODUCE} --no-comparison")
    assert "v0.1: score" not in Path("thesis.md").read_text(encoding="utf-8")
    assert not Path("recalls_v0.1.csv").exists()


def test_reproduction_that_was_killed_continues(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    def interrupted() -> list[Row]:
        if not resumed:
            raise KeyboardInterrupt
        return []

    resumed: list[bool] = []
    second = Job("two", interrupted, ())
    monkeypatch.setattr(reproduction, "jobs", lambda *given: [*one_row_jobs(*given), second])
    with pytest.raises(KeyboardInterrupt):
        reproduction.reproduce(0, 1, Path(), backend="compiled", comparison=False)
    assert not Path("thesis.md").exists()
    resumed.append(True)
    reproduction.reproduce(0, 1, Path(), backend="compiled", comparison=False)
    assert "1 of 2 units are done already" in capsys.readouterr().out
    assert not list(Path().glob("units*")), "the next run starts from nothing"
    assert len(Path("recalls.csv").read_text().splitlines()) == 2
