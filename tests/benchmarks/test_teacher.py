"""`benchmarks/teacher.py`: the expert delivers, and without ORIENT nobody does."""

from pathlib import Path

import pytest

from tests.benchmarks.running import help_of, is_picture, quick, read

FORAGES = 25
FOODS = {"corridor": 1, "rectangle": 2}
EXPERT = [(arena, food) for arena in FOODS for food in ("PICKABLE", "PUSHABLE", "POISONOUS")]


@pytest.fixture(scope="module")
def out(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("run") / "teacher"
    (folder.parent / "printed").write_text(quick("teacher.py", folder), encoding="utf-8")
    return folder


@pytest.fixture(scope="module")
def table(out: Path) -> dict[tuple[str, str, str], dict[str, str]]:
    return {(row["arena"], row["food"], row["policy"]): row for row in read(out / "teacher.csv")}


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


def test_same_rows_on_any_number_of_processes(out: Path, tmp_path: Path) -> None:
    few = [quick("teacher.py", tmp_path / jobs, "--forages", "2", "--jobs", jobs) for jobs in ("1", "2")]
    assert few[0].replace(str(tmp_path / "1"), "") == few[1].replace(str(tmp_path / "2"), "")
    rows = [(tmp_path / jobs / "forages.csv").read_bytes() for jobs in ("1", "2")]
    assert rows[0] == rows[1]


def test_table_is_printed_and_written_with_its_picture(out: Path) -> None:
    page = (out / "teacher.md").read_text(encoding="utf-8")
    printed = (out.parent / "printed").read_text(encoding="utf-8")
    for line in page.splitlines():
        if line.startswith("| "):
            assert line in printed
    assert is_picture(out / "teacher.png")


def test_help_names_every_argument() -> None:
    told = help_of("teacher.py")
    for argument in ("--seed", "--out", "--quick", "--forages", "--jobs", "results/teacher"):
        assert argument in told
