"""`benchmarks/virtual_lab.py`: the same trainings and recalls in both worlds, and their comparison."""

from pathlib import Path

import pytest

from khepera_forage.estimates import Estimate
from tests.benchmarks.conftest import QuickRun
from tests.benchmarks.running import read
from tests.benchmarks.test_scripts import SCRIPTS
from tests.figure_checks import check_readable, lay_out

pytest.importorskip("serial")
pytest.importorskip("cv2")


@pytest.fixture(scope="module")
def out(quick_run: QuickRun) -> Path:
    return quick_run("virtual_lab", *SCRIPTS["virtual_lab"].run)


def test_the_same_recalls_in_both_worlds(out: Path) -> None:
    recalls = read(out / "recalls.csv")
    names = ("arena", "learner", "seed", "start_x", "food_x")
    pymunk, virtual = (
        [[row[name] for name in names] for row in recalls if row["world"] == world] for world in ("pymunk", "virtual")
    )
    assert pymunk == virtual
    assert len(pymunk) == 4
    for row in recalls:
        if (row["learner"], row["arena"]) == ("teacher", "rectangle"):
            assert row["delivered"] == row["foods"]
    assert [row["rounds_by_state"] for row in recalls[:4]] != [row["rounds_by_state"] for row in recalls[4:]]


def test_the_comparison_is_that_of_the_rows(out: Path) -> None:
    recalls = read(out / "recalls.csv")
    training = read(out / "trainings.csv")
    first, *lines = [
        line for line in read(out / "table_worlds.csv") if line["measure"] != "rounds of a complete episode"
    ]
    complete = [100 / len([row for row in training if row["world"] == world]) for world in ("pymunk", "virtual")]
    assert first["measure"] == "attempts complete (%)"
    assert [float(first[name]) for name in ("pymunk alone", "virtual laboratory")] == pytest.approx(complete, rel=1e-4)
    assert len(lines) == 4 * 3
    for line in lines:
        own = [row for row in recalls if f"{row['learner']}, {row['arena']}" == line["what"]]
        assert [row["world"] for row in own] == ["pymunk", "virtual"]
        pymunk, virtual = (
            {
                "score (%)": float(row["score"]),
                "food delivered (%)": 100 * int(row["delivered"]) / int(row["foods"]),
                "steps": float(row["steps"]),
            }[line["measure"]]
            for row in own
        )
        assert float(line["pymunk alone"]) == pytest.approx(pymunk, rel=1e-4)
        assert float(line["virtual laboratory"]) == pytest.approx(virtual, rel=1e-4)
        assert float(line["difference"]) == pytest.approx(virtual - pymunk, rel=1e-4, abs=1e-4)


def test_worlds_in_which_nothing_was_delivered_are_drawn() -> None:
    import virtual_lab

    nothing = dict.fromkeys((virtual_lab.ALONE, virtual_lab.LAB), Estimate(0.0, 0.0, 0.0))
    lines = [{"what": "teacher", "measure": measure.name, **nothing} for measure in virtual_lab.RECALL_MEASURES]
    check_readable(lay_out(virtual_lab.picture(lines)))
