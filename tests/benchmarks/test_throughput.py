"""`benchmarks/throughput.py`: every measure is there and sane; how fast anything is, no test asks."""

import statistics
from pathlib import Path

import pytest

from tests.benchmarks.running import help_of, is_picture, quick, read

LINES = {
    "Environments": {
        "Corridor-v0, resets included",
        "Corridor-v0, resets left out",
        "Rectangle-v0, resets included",
        "CorridorWheels-v0, resets included",
        "paired corridors, resets included",
    },
    "Bare pymunk": {
        "five physics steps, then eight rays: a round of 0.1 s",
        "one physics step, then eight rays",
        "share of the physics",
        "share of the setters",
        "share of the rays",
    },
    "Imitator": {
        "imitator as it forages",
        "imitator, memo emptied before every query",
        "queries that the memo answers",
        "imitator over many vectors",
        "one more vector learned",
        "vectors of that imitator",
        "distinct among them",
    },
    "Processes": {"import khepera_forage"},
    "A step of Corridor-v0, part by part": {
        "physics: pymunk's own step",
        "wheels, gripper and rounds, in Python",
        "infra-reds and optical barrier",
        "camera and tracking",
        "perception, state, food register",
        "behaviour: raw data to motors",
        "observation, reward, info",
        "Gymnasium's wrappers",
        "the teacher's decision",
        "sum of the parts",
        "the same steps, nothing replaced",
    },
}
GOALS = {
    "Corridor-v0, resets included": 15_000,
    "paired corridors, resets included": 4_000,
    "imitator as it forages": 40_000,
    "imitator, memo emptied before every query": 40_000,
    "imitator over many vectors": 20_000,
    "import khepera_forage": 0.5,
}


@pytest.fixture(scope="module")
def out(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("run") / "throughput"
    (folder.parent / "printed").write_text(quick("throughput.py", folder), encoding="utf-8")
    return folder


@pytest.fixture(scope="module")
def rows(out: Path) -> dict[str, dict[str, str]]:
    return {row["name"]: row for row in read(out / "throughput.csv")}


def test_every_measure_has_a_line(rows: dict[str, dict[str, str]]) -> None:
    found: dict[str, set[str]] = {}
    for row in rows.values():
        found.setdefault(row["section"], set()).add(row["name"])
    assert found == LINES


def test_values_are_positive_and_the_median_is_that_of_the_repeats(rows: dict[str, dict[str, str]]) -> None:
    for row in rows.values():
        repeats = [float(value) for value in row["repeats"].split(";")]
        assert len(repeats) == 2
        assert min(repeats) > 0, row["name"]
        assert float(row["median"]) == statistics.median(repeats)
        assert (float(row["lowest"]), float(row["highest"])) == (min(repeats), max(repeats))


def test_goals_stand_beside_what_was_measured(rows: dict[str, dict[str, str]]) -> None:
    assert {name: float(row["goal"]) for name, row in rows.items() if row["goal"]} == GOALS


def test_leaving_resets_out_never_slows(rows: dict[str, dict[str, str]]) -> None:
    included, left_out = (
        [float(value) for value in rows[f"Corridor-v0, resets {how}"]["repeats"].split(";")]
        for how in ("included", "left out")
    )
    assert all(a > b for a, b in zip(left_out, included, strict=True))


def test_parts_add_up(rows: dict[str, dict[str, str]]) -> None:
    parts = [row for row in rows.values() if row["section"] == "A step of Corridor-v0, part by part"][:-2]
    for i, total in enumerate(rows["sum of the parts"]["repeats"].split(";")):
        assert sum(float(row["repeats"].split(";")[i]) for row in parts) == pytest.approx(float(total))


def test_shares_of_bare_pymunk_add_up(rows: dict[str, dict[str, str]]) -> None:
    shares = [row["repeats"].split(";") for name, row in rows.items() if name.startswith("share of the")]
    for repeat in zip(*shares, strict=True):
        assert sum(map(float, repeat)) == pytest.approx(100)


def test_memo_answers_what_came_before(rows: dict[str, dict[str, str]]) -> None:
    answered = [float(value) for value in rows["queries that the memo answers"]["repeats"].split(";")]
    assert 0 < answered[0] < 100
    assert len(set(answered)) == 1, "every repeat does the same work"


def test_table_is_printed_and_written_with_its_picture(out: Path, rows: dict[str, dict[str, str]]) -> None:
    page = (out / "throughput.md").read_text(encoding="utf-8")
    printed = (out.parent / "printed").read_text(encoding="utf-8")
    assert "at least 15,000" in page
    assert "at most 0.5" in page
    for name in rows:
        assert page.count(f"| {name} |") == 1
        assert f"| {name} |" in printed
    assert is_picture(out / "throughput.png")


def test_help_names_every_argument() -> None:
    told = help_of("throughput.py")
    for argument in ("--seed", "--out", "--quick", "--steps", "--repeats", "--memory", "results/throughput"):
        assert argument in told
