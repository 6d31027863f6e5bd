"""`benchmarks/backends.py`: without ORIENT nobody delivers, and both backends have the same recalls."""

from pathlib import Path

import pytest

from khepera_forage.sim.arenas.difficulty import DIFFICULTIES
from khepera_forage.sim.arenas.named import FAMILY
from tests.benchmarks.conftest import QuickRun
from tests.benchmarks.running import read

pytest.importorskip("numba")
Rows = list[dict[str, str]]


@pytest.fixture(scope="module")
def out(quick_run: QuickRun) -> Path:
    return quick_run("backends")


@pytest.fixture(scope="module")
def rows(out: Path) -> Rows:
    return read(out / "recalls.csv")


def test_teacher_settles_nearly_all_food_and_needs_orient(out: Path) -> None:
    for line in read(out / "table_teacher.csv"):
        delivered, settled = float(line["food delivered (%)"]), float(line["food settled (%)"])
        if line["policy"] == "SEARCH for ORIENT":
            assert delivered == settled == 0
        else:
            assert settled > 90
            assert delivered == 0 if line["food"] == "POISONOUS" else delivered > 90
        assert float(line["steps: low"]) <= float(line["steps"]) <= float(line["steps: high"])


def test_lines_of_the_teacher_share_their_starts(rows: Rows) -> None:
    for arena in ("corridor", "rectangle"):
        seeds: dict[tuple[str, str], list[str]] = {}
        for row in rows:
            if (row["part"], row["arena"]) == ("teacher", arena):
                seeds.setdefault((row["food"], row["policy"]), []).append(row["seed"])
        assert len(seeds) == 4
        assert len({tuple(line) for line in seeds.values()}) == 1


def test_every_arena_has_the_same_recalls_on_both_backends(rows: Rows) -> None:
    names = ("policy", "arena", "level", "food", "seed", "foods", "deliverable")
    sides = [
        sorted(
            [row[name] for name in names]
            for row in rows
            if (row["part"], row["backend"]) == ("arenas", backend)
        )
        for backend in ("pymunk", "compiled")
    ]
    assert sides[0] == sides[1]
    assert {row[1] for row in sides[0]} == {*FAMILY, *DIFFICULTIES}


def test_tables_count_what_the_rows_hold(out: Path, rows: Rows) -> None:
    for line in read(out / "table_deliveries.csv"):
        groups = list(DIFFICULTIES) if line["arenas"] == "all procedural" else [line["arenas"]]
        for backend in ("pymunk", "compiled"):
            own = [
                row
                for row in rows
                if (row["part"], row["policy"], row["food"], row["backend"])
                == ("arenas", "teacher", line["food"], backend)
                and row["arena"] in groups
            ]
            share = sum(int(row["delivered"]) for row in own) / sum(int(row["deliverable"]) for row in own)
            assert float(line[f"{backend}: delivered (%)"]) == pytest.approx(100.0 * share, abs=0.01)


def test_two_sample_tests_have_a_line_for_each_measure(out: Path) -> None:
    assert len(read(out / "table_agreement.csv")) == 2 * 2 * 3
    assert len(read(out / "table_experiments.csv")) == 7 * 4
    for name in ("agreement", "experiments"):
        for line in read(out / f"table_{name}.csv"):
            change = float(line["compiled"]) - float(line["pymunk"])
            assert float(line["difference"]) == pytest.approx(change, abs=0.01)
