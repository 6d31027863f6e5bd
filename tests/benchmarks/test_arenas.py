"""`benchmarks/arenas.py`: the teacher in every arena, with the same seeds on both backends."""

from pathlib import Path

import pytest

from khepera_forage.sim.arenas.difficulty import DIFFICULTIES
from khepera_forage.sim.arenas.named import FAMILY
from tests.benchmarks.conftest import QuickRun
from tests.benchmarks.running import read

pytest.importorskip("numba")
GROUPS = [*FAMILY, *DIFFICULTIES]
RECALLS, LEVELS = 2, 1
FOODS = ["PICKABLE", "PUSHABLE", "a third each"]


@pytest.fixture(scope="module")
def out(quick_run: QuickRun) -> Path:
    return quick_run("arenas", "--recalls", str(RECALLS), "--levels", str(LEVELS))


def test_every_arena_and_food_has_its_recalls_on_both_backends(out: Path) -> None:
    rows = read(out / "deliveries.csv")
    for group in GROUPS:
        for food in FOODS:
            own = [row for row in rows if row["group"] == group and row["food"] == food]
            sides = [[row for row in own if row["backend"] == name] for name in ("pymunk", "compiled")]
            same = [
                [(row["arena"], row["seed"], row["deliverable"], row["poisonous"]) for row in side]
                for side in sides
            ]
            assert same[0] == same[1]
            assert len(same[0]) == (RECALLS if group in FAMILY else LEVELS)


def test_teacher_delivers_nearly_all_food_and_no_poison(out: Path) -> None:
    rows = read(out / "deliveries.csv")
    assert sum(int(row["poison_home"]) for row in rows) == 0
    assert sum(int(row["poisonous"]) for row in rows) > 20
    delivered, deliverable = (sum(int(row[name]) for row in rows) for name in ("delivered", "deliverable"))
    assert delivered >= 0.95 * deliverable


def test_tables_count_what_the_rows_hold(out: Path) -> None:
    rows = read(out / "deliveries.csv")
    for line in read(out / "table_deliveries.csv"):
        groups = list(DIFFICULTIES) if line["arenas"] == "all procedural" else [line["arenas"]]
        for backend in ("pymunk", "compiled"):
            own = [
                row
                for row in rows
                if row["group"] in groups and row["food"] == line["food"] and row["backend"] == backend
            ]
            share = sum(int(row["delivered"]) for row in own) / sum(int(row["deliverable"]) for row in own)
            assert float(line[f"{backend}: delivered (%)"]) == pytest.approx(100.0 * share, abs=0.01)
    for line in read(out / "table_backends.csv"):
        counts = sum(int(line[name]) for name in ("both", "pymunk only", "compiled only", "neither"))
        assert counts == (
            RECALLS
            if line["arenas"] in FAMILY
            else LEVELS * (len(DIFFICULTIES) if line["arenas"] == "all procedural" else 1)
        )
