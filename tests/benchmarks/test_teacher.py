"""`benchmarks/teacher.py`: the expert delivers, and without ORIENT nobody does."""

from pathlib import Path

import pytest

from tests.benchmarks.conftest import QuickRun
from tests.benchmarks.running import read

FORAGES = 15
FOODS = {"corridor": 1, "rectangle": 2}
EXPERT = [(arena, food) for arena in FOODS for food in ("PICKABLE", "PUSHABLE", "POISONOUS")]


@pytest.fixture(scope="module")
def out(quick_run: QuickRun) -> Path:
    return quick_run("teacher")


@pytest.fixture(scope="module")
def table(out: Path) -> dict[tuple[str, str, str], dict[str, str]]:
    return {(row["arena"], row["food"], row["policy"]): row for row in read(out / "table_teacher.csv")}


@pytest.fixture(scope="module")
def forages(out: Path) -> list[dict[str, str]]:
    return read(out / "forages.csv")


def test_every_condition_has_a_line(table: dict[tuple[str, str, str], dict[str, str]]) -> None:
    checks = {(arena, "PICKABLE", "SEARCH for ORIENT") for arena in FOODS}
    assert set(table) == {(arena, food, "teacher") for arena, food in EXPERT} | checks
    for (arena, _, _), row in table.items():
        assert int(row["forages"]) == FORAGES
        assert int(row["food objects"]) == FORAGES * FOODS[arena]


def test_shares_lie_in_their_intervals(table: dict[tuple[str, str, str], dict[str, str]]) -> None:
    for row in table.values():
        for name in ("food delivered (%)", "food settled (%)", "forages finished (%)"):
            share, low, high = (float(row[f"{name}{end}"]) for end in ("", ": low", ": high"))
            assert 0 <= low <= share + 1e-6
            assert share - 1e-6 <= high <= 100
            assert low < high


@pytest.mark.parametrize(("arena", "food"), EXPERT)
def test_teacher_settles_nearly_all_food(
    table: dict[tuple[str, str, str], dict[str, str]], arena: str, food: str
) -> None:
    row = table[arena, food, "teacher"]
    assert float(row["food settled (%)"]) > 90
    delivered = float(row["food delivered (%)"])
    assert delivered == 0 if food == "POISONOUS" else delivered > 90
    low, median, high = (float(row[f"steps{end}"]) for end in (": low", "", ": high"))
    assert 0 < low < median < high


@pytest.mark.parametrize("arena", FOODS)
def test_without_orient_nothing_is_delivered(
    table: dict[tuple[str, str, str], dict[str, str]], arena: str
) -> None:
    row = table[arena, "PICKABLE", "SEARCH for ORIENT"]
    assert float(row["food delivered (%)"]) == float(row["food settled (%)"]) == 0


def test_rows_are_those_of_the_table(
    table: dict[tuple[str, str, str], dict[str, str]], forages: list[dict[str, str]]
) -> None:
    for (arena, food, policy), row in table.items():
        own = [f for f in forages if (f["arena"], f["food"], f["policy"]) == (arena, food, policy)]
        assert len(own) == FORAGES
        delivered = sum(int(f["delivered"]) for f in own)
        assert float(row["food delivered (%)"]) == pytest.approx(100 * delivered / int(row["food objects"]))
        assert int(row["poison brought home"]) == sum(int(f["poison_home"]) for f in own)
        for forage in own:
            assert 1 <= int(forage["steps"]) <= int(forage["limit"])


def test_lines_of_an_arena_share_their_starts(forages: list[dict[str, str]]) -> None:
    for arena in FOODS:
        seeds: dict[tuple[str, str], list[str]] = {}
        for row in forages:
            if row["arena"] == arena:
                seeds.setdefault((row["food"], row["policy"]), []).append(row["seed"])
        assert len(seeds) == 4
        assert len({tuple(line) for line in seeds.values()}) == 1
        assert len(set(next(iter(seeds.values())))) == FORAGES
