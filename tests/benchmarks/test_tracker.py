"""`benchmarks/tracker.py`: its tables are complete and consistent, and failure has a warning.

That the tracker meets its requirements: `tests/vision`."""

from pathlib import Path

import pytest

pytest.importorskip("cv2")

from laboratory.observations import loss_rate, observe, reversals
from laboratory.troubles import SETUPS

from khepera_forage.vision.scene import Region, Truth
from tests.benchmarks.conftest import QuickRun
from tests.benchmarks.running import read

ROUNDS = 100
WIDTH, EXPOSURE, FLOOR, NOISE = (
    "width of the cable (mm)",
    "exposure (factor)",
    "floor (white: 215)",
    "noise (grey levels)",
)
KINDS = {"food": 2, "1 hole": 1, "2 holes": 1}
"""And how many of each there are."""


@pytest.fixture(scope="module")
def out(quick_run: QuickRun) -> Path:
    return quick_run("tracker")


def test_every_thing_is_observed_in_every_round(out: Path) -> None:
    rows = [row for row in read(out / "observations.csv") if row["kind"]]
    assert len({(row["frame"], row["kind"], row["thing"]) for row in rows}) == len(rows) == ROUNDS * sum(KINDS.values())


def test_trainings_show_no_fault_of_the_tracker(out: Path) -> None:
    line = {row["quantity"]: row for row in read(out / "table_trainings.csv")}
    found = {name: float(row["tracker on rendered frames"]) for name, row in line.items()}
    for kind in KINDS:
        assert 0 < found[f"position_jitter (px), {kind}"] < 0.06
    for kind in ("1 hole", "2 holes"):
        # At least that of the rounding to whole degrees.
        assert 0.25 < found[f"heading_jitter (deg), {kind}"] < 0.45
    assert found["reversal_rate"] == 0
    assert found["regions of nothing, a round"] < 0.01
    assert found["rounds"] == ROUNDS


def test_every_marker_in_trouble_is_found_or_lost_without_a_wrong_one(out: Path) -> None:
    rows = read(out / "table_troubles.csv")
    assert [row["frames"].split(" of ")[1] for row in rows] == [f"{width} x {height}" for width, height, _ in SETUPS]
    for row in rows:
        markers = 2 * int(row["frames"].split(" of ")[0])
        lost = int(row["lost with a warning"]) + int(row["lost without"])
        assert float(row["found (%)"]) == pytest.approx(100 * (markers - lost) / markers)
        assert int(row["wrong number, front or phantom"]) == int(row["off by more than 5 mm"]) == 0
        assert float(row["99 % (mm)"]) < 5
        assert float(row["frames/s"]) > 0


def test_a_loss_and_a_reversal_are_counted() -> None:
    truth = Truth(((100.0, 100.0, 0.0, 1),), ())
    region = Region(0, 20.0, 20.0, 1, 180, True, False, 0.0, 0.0, 0.0, 0.0)
    frames = [[region], [region], [region._replace(found=False)], []]
    rows = [row for number, regions in enumerate(frames) for row in observe((0, number), truth, regions)]
    assert [row.found for row in rows] == [True, True, False, False]
    assert reversals(rows) == 2
    assert loss_rate(rows).value == 1 / 2
    assert [row.kind for row in observe((0, 0), truth, [region, region._replace(label=1)])] == ["1 hole", ""]


def test_everything_is_found_under_moderate_disturbances_and_failure_has_a_warning(out: Path) -> None:
    points = {(row["sweep"], row["curve"], float(row["value"])): row for row in read(out / "limits.csv")}
    limits = {(row["disturbance"], row["curve"], float(row["value"])): row for row in read(out / "table_limits.csv")}
    for point in ((WIDTH, "cable", 0.0), ("blur (pixels)", "no cable", 0.3), (NOISE, "no cable", 0.0)):
        row = limits[point]
        assert float(row["markers found (%)"]) >= 95
        assert float(row["food found (%)"]) == 100
        assert float(row["stray (per 1000)"]) == float(row["warning (%)"]) == 0
    for point in ((EXPOSURE, "no cable", 2.5), (FLOOR, "no cable", 170.0), (NOISE, "no cable", 30.0)):
        assert float(limits[point]["warning (%)"]) == 100
    assert float(limits[EXPOSURE, "no cable", 2.5]["markers found (%)"]) < 50
    thick = limits[WIDTH, "cable", 25.0]
    assert float(thick["markers found (%)"]) < 50 < float(thick["food found (%)"]), "no cable crosses the food"
    assert limits.keys() == points.keys()
    for key, row in points.items():
        line = {name: float(value) for name, value in limits[key].items() if "(" in name}
        things, markers, foods, stray = (float(row[name]) for name in ("things", "markers", "foods", "stray"))
        wanted = {
            "markers found (%)": 100 * markers / things,
            "food found (%)": 100 * foods / things,
            "stray (per 1000)": 1000 * stray / things,
            "warning (%)": float(row["warned"]),
        }
        assert {name: line[name] for name in wanted} == pytest.approx(wanted, rel=1e-4)
