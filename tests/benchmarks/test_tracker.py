"""`benchmarks/tracker.py`: its tables are complete and consistent, and the tracker meets its requirements."""

from pathlib import Path

import pytest

from tests.benchmarks.conftest import QuickRun
from tests.benchmarks.running import read

pytest.importorskip("cv2")
SCENES, ROUNDS = 10, 2 * 60
KINDS = {"food": 2, "1 hole": 1, "2 holes": 1}
"""And how many of each there are."""


@pytest.fixture(scope="module")
def out(quick_run: QuickRun) -> Path:
    return quick_run("tracker")


@pytest.fixture(scope="module")
def accuracy(out: Path) -> dict[tuple[str, str], dict[str, str]]:
    return {(row["appearance"], row["region"]): row for row in read(out / "table_accuracy.csv")}


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("appearance", ["nothing but quantisation", "laboratory", "blur 1.2 pixels"])
def test_the_tracker_meets_its_requirements(
    accuracy: dict[tuple[str, str], dict[str, str]], appearance: str, kind: str
) -> None:
    row = accuracy[appearance, kind]
    assert int(row["things"]) == SCENES * KINDS[kind]
    assert float(row["found (%)"]) > 90
    assert float(row["within 1 px (%)"]) >= 99
    if kind != "food":
        assert float(row["within 3 deg (%)"]) >= 99
        assert row["reversed"] == "0"


def test_uncorrected_parallax_moves_centres(accuracy: dict[tuple[str, str], dict[str, str]]) -> None:
    corrected, not_corrected = (
        accuracy[f"camera at 2.7 m, {how}", "food"] for how in ("parallax corrected", "not corrected")
    )
    assert float(corrected["centre: median (px)"]) < 0.2 < float(not_corrected["centre: median (px)"])


def test_all_cameras_observe_the_same_trainings(out: Path) -> None:
    rows = [row for row in read(out / "observations.csv") if row["source"] == "training" and row["kind"]]
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


def test_speed_has_its_goal(out: Path) -> None:
    rows = {row["part"]: row for row in read(out / "table_speed.csv")}
    assert {part: row["goal"] for part, row in rows.items()} == {
        "tracker": "at least 300",
        "tracker, each marker under a cable": "at least 300",
        "renderer": "",
    }


def test_everything_is_found_under_moderate_disturbances_and_failure_has_a_warning(out: Path) -> None:
    limits = {(row["disturbance"], row["curve"], float(row["value"])): row for row in read(out / "table_limits.csv")}
    for point in (("width", "dark grey cable", 6.0), ("blur", "no cable", 0.3), ("exposure", "no cable", 0.75)):
        row = limits[point]
        assert float(row["markers found (%)"]) >= 95
        assert float(row["food found (%)"]) == 100
        assert float(row["stray (per 1000)"]) == float(row["warning (%)"]) == 0
    for point in (("exposure", "no cable", 2.5), ("floor", "no cable", 155.0), ("noise", "no cable", 30.0)):
        assert float(limits[point]["warning (%)"]) == 100
    assert float(limits["exposure", "no cable", 2.5]["markers found (%)"]) < 50


def test_lens_is_calibrated_from_enough_points(out: Path) -> None:
    rows = {row["points"]: row for row in read(out / "table_lenses.csv") if row["k1"] == "-0.05"}
    assert float(rows["4 corners"]["error (mm)"]) > 20
    for layout in ("4 x 4", "5 x 4"):
        assert float(rows[layout]["lens calibrated (%)"]) == 100
        assert float(rows[layout]["error (mm)"]) < 5


def test_no_marker_is_wrong_or_lost_silently_in_troubles(out: Path) -> None:
    rows = read(out / "table_troubles.csv")
    assert len(rows) == 5
    for row in rows:
        assert (row["lost without"], row["wrong number, front or phantom"]) == ("0", "0")
        assert float(row["found (%)"]) > 70
