"""`benchmarks/tracker.py`: its tables are complete and consistent, and failure has a warning.

That the tracker meets its requirements: `tests/vision`."""

from pathlib import Path

import pytest

from tests.benchmarks.conftest import QuickRun
from tests.benchmarks.running import read

pytest.importorskip("cv2")
ROUNDS = 100
KINDS = {"food": 2, "1 hole": 1, "2 holes": 1}
"""And how many of each there are."""


@pytest.fixture(scope="module")
def out(quick_run: QuickRun) -> Path:
    return quick_run("tracker")


def test_all_cameras_observe_the_same_trainings(out: Path) -> None:
    rows = [row for row in read(out / "observations.csv") if row["kind"]]
    seen = [
        [(row["training"], row["frame"], row["kind"], row["thing"]) for row in rows if row["camera"] == camera]
        for camera in ("tracker", "model", "threshold")
    ]
    assert seen[0] == seen[1] == seen[2]
    assert len(seen[0]) == ROUNDS * sum(KINDS.values())


def test_the_measurement_finds_the_parameters_of_the_model_and_no_fault_of_the_tracker(out: Path) -> None:
    model = {row["quantity"]: row for row in read(out / "table_model.csv")}
    for kind in KINDS:
        row = model[f"position_jitter (px), {kind}"]
        assert float(row["model, measured"]) == pytest.approx(float(row["Noise.laboratory()"]), rel=0.15)
    for kind in ("1 hole", "2 holes"):
        row = model[f"heading_jitter (deg), {kind}"]
        told = float(row["Noise.laboratory()"])
        assert float(row["model, measured"]) == pytest.approx((told**2 + 1 / 12) ** 0.5, rel=0.2)
    tracker = "tracker on rendered frames"
    assert float(model["labels that changed things"][tracker]) == 0
    assert float(model["regions of nothing, a round"][tracker]) < 0.01
    assert float(model["rounds"][tracker]) == ROUNDS


def test_everything_is_found_under_moderate_disturbances_and_failure_has_a_warning(out: Path) -> None:
    points = {(row["sweep"], row["curve"], float(row["value"])): row for row in read(out / "limits.csv")}
    limits = {(row["disturbance"], row["curve"], float(row["value"])): row for row in read(out / "table_limits.csv")}
    for point in (("width", "dark grey cable", 0.0), ("blur", "no cable", 0.3), ("noise", "no cable", 0.0)):
        row = limits[point]
        assert float(row["markers found (%)"]) >= 95
        assert float(row["food found (%)"]) == 100
        assert float(row["stray (per 1000)"]) == float(row["warning (%)"]) == 0
    for point in (("exposure", "no cable", 2.5), ("floor", "no cable", 170.0), ("noise", "no cable", 30.0)):
        assert float(limits[point]["warning (%)"]) == 100
    assert float(limits["exposure", "no cable", 2.5]["markers found (%)"]) < 50
    thick = limits["width", "black cable", 25.0]
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
