"""`benchmarks/throughput.py`: every measure is there and plausible. No test depends on speed."""

import statistics
from pathlib import Path

import pytest
from timing.measures import Line, Measure

from tests.benchmarks.conftest import QuickRun
from tests.benchmarks.running import read

LINES = {
    "Environments": {
        "Corridor-v1, resets included",
        "Corridor-v1, resets left out",
        "Rectangle-v1, resets included",
        "CorridorWheels-v1, resets included",
        "paired corridors, resets included",
    },
    "Bare pymunk": {
        "five pymunk steps, then eight rays: a round of 0.1 s",
        "one pymunk step, then eight rays",
        "share of the simulation",
        "share of the setters",
        "share of the rays",
    },
    "Imitator": {
        "imitator while it forages",
        "imitator, cache emptied before every query",
        "queries that the cache answers",
        "imitator over many vectors",
        "one more vector learned",
        "vectors of that imitator",
        "distinct among them",
    },
    "Processes": {"import khepera_forage"},
    "A step of Corridor-v1, part by part": {
        "pymunk's own step",
        "wheels, gripper and rounds, in Python",
        "infra-reds and optical barrier",
        "camera and tracking",
        "perception, state, food tracking",
        "behaviour: raw data to motors",
        "observation, reward, info",
        "Gymnasium's wrappers",
        "the teacher's decision",
        "sum of the parts",
        "the same steps without stopwatch",
    },
}
TOTALS = {"sum of the parts", "the same steps without stopwatch"}
GOALS = {
    "Corridor-v1, resets included": 15_000,
    "paired corridors, resets included": 4_000,
    "imitator while it forages": 40_000,
    "imitator, cache emptied before every query": 40_000,
    "imitator over many vectors": 20_000,
    "import khepera_forage": 0.5,
}


@pytest.fixture(scope="module")
def out(quick_run: QuickRun) -> Path:
    return quick_run("throughput")


@pytest.fixture(scope="module")
def rows(out: Path) -> dict[str, list[dict[str, str]]]:
    """The repeats of every measure."""
    measures: dict[str, list[dict[str, str]]] = {}
    for row in read(out / "measurements.csv"):
        measures.setdefault(row["name"], []).append(row)
    return measures


def values_of(rows: list[dict[str, str]]) -> list[float]:
    return [float(row["value"]) for row in rows]


def test_every_measure_has_a_line(rows: dict[str, list[dict[str, str]]]) -> None:
    found: dict[str, set[str]] = {}
    for name, (first, *_) in rows.items():
        found.setdefault(first["section"], set()).add(name)
    assert found == LINES


def test_values_are_positive_and_the_table_has_their_median(
    out: Path, rows: dict[str, list[dict[str, str]]]
) -> None:
    table = {row["measure"]: row["measured"] for row in read(out / "table_environments.csv")}
    for name, repeats in rows.items():
        assert [row["repeat"] for row in repeats] == ["0", "1"]
        assert min(values_of(repeats)) > 0, name
        if name in table:
            shown = float(table[name].split(" [")[0].replace(",", ""))
            assert shown == pytest.approx(statistics.median(values_of(repeats)), rel=0.01)


def test_goals_stand_beside_what_was_measured(rows: dict[str, list[dict[str, str]]]) -> None:
    assert {name: float(own[0]["goal"]) for name, own in rows.items() if own[0]["goal"]} == GOALS


def test_leaving_resets_out_never_slows(rows: dict[str, list[dict[str, str]]]) -> None:
    included, left_out = (values_of(rows[f"Corridor-v1, resets {how}"]) for how in ("included", "left out"))
    assert all(a > b for a, b in zip(left_out, included, strict=True))


def test_parts_add_up(rows: dict[str, list[dict[str, str]]]) -> None:
    parts = list(LINES["A step of Corridor-v1, part by part"] - TOTALS)
    for i, total in enumerate(values_of(rows["sum of the parts"])):
        assert sum(values_of(rows[part])[i] for part in parts) == pytest.approx(total)


def test_shares_of_bare_pymunk_add_up(rows: dict[str, list[dict[str, str]]]) -> None:
    shares = [values_of(own) for name, own in rows.items() if name.startswith("share of the")]
    for repeat in zip(*shares, strict=True):
        assert sum(repeat) == pytest.approx(100)


def test_the_cache_answers_what_came_before(rows: dict[str, list[dict[str, str]]]) -> None:
    answered = values_of(rows["queries that the cache answers"])
    assert 0 < answered[0] < 100
    assert len(set(answered)) == 1, "every repeat does the same work"


def test_the_page_has_goals_and_one_line_a_measure(out: Path, rows: dict[str, list[dict[str, str]]]) -> None:
    page = (out / "throughput.md").read_text(encoding="utf-8")
    assert "at least 15,000" in page
    assert "at most 0.5" in page
    for name in rows:
        assert page.count(f"| {name} |") == 1


def test_a_line_compares_its_median_with_the_goal() -> None:
    fast = Line(Measure("s", "n", "steps/s", "", 100.0), (90.0, 200.0, 300.0))
    slow = Line(Measure("s", "n", "ns a step", "", 100.0), (90.0, 200.0, 300.0))
    assert (fast.median, fast.bound, fast.factor) == (200.0, "at least 100", 2.0)
    assert (slow.bound, slow.factor) == ("at most 100", 0.5)
    assert Line(Measure("s", "n", "s"), (1.0,)).factor is None
