"""`benchmarks/tracker.py`: its tables are complete and consistent, and the tracker meets its requirements."""

from pathlib import Path

import pytest

from tests.benchmarks.conftest import QuickRun
from tests.benchmarks.running import read

SCENES, TRAININGS, ROUNDS = 30, 2, 150
KINDS = {"food": 2, "1 hole": 1, "2 holes": 1}
"""And how many of each there are."""


@pytest.fixture(scope="module")
def out(quick_run: QuickRun) -> Path:
    return quick_run("tracker")


@pytest.fixture(scope="module")
def accuracy(out: Path) -> dict[tuple[str, str], dict[str, str]]:
    return {(row["appearance"], row["region"]): row for row in read(out / "table_accuracy.csv")}


@pytest.fixture(scope="module")
def model(out: Path) -> dict[str, dict[str, str]]:
    return {row["quantity"]: row for row in read(out / "table_model.csv")}


@pytest.fixture(scope="module")
def trainings(out: Path) -> list[dict[str, str]]:
    return [row for row in read(out / "observations.csv") if row["source"] == "training"]


def test_every_appearance_has_its_lines(accuracy: dict[tuple[str, str], dict[str, str]]) -> None:
    appearances = {appearance for appearance, _ in accuracy}
    assert {"laboratory", "laboratory, no cables", "nothing but quantisation"} < appearances
    assert set(accuracy) == {(appearance, kind) for appearance in appearances for kind in KINDS}
    for (_, kind), row in accuracy.items():
        assert int(row["frames"]) == SCENES * KINDS[kind]
        assert 0 <= int(row["under a cable"]) <= int(row["frames"])


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("appearance", ["nothing but quantisation", "laboratory", "blur 1.2 pixels"])
def test_the_tracker_meets_its_requirements(
    accuracy: dict[tuple[str, str], dict[str, str]], appearance: str, kind: str
) -> None:
    row = accuracy[appearance, kind]
    assert float(row["found (%)"]) > 90
    assert float(row["within 1 px (%)"]) >= 99
    assert float(row["99 % (px)"]) <= 1
    if kind != "food":
        assert float(row["within 3 deg (%)"]) >= 99
        assert int(row["reversed"]) == 0


def test_uncorrected_parallax_moves_centres(accuracy: dict[tuple[str, str], dict[str, str]]) -> None:
    corrected, not_corrected = (
        accuracy[f"camera at 2.7 m, {how}", "food"] for how in ("parallax corrected", "not corrected")
    )
    assert float(corrected["centre: median (px)"]) < 0.2 < float(not_corrected["centre: median (px)"])


def test_all_cameras_observe_the_same_trainings(trainings: list[dict[str, str]]) -> None:
    for camera in ("tracker", "model", "threshold"):
        own = [row for row in trainings if row["camera"] == camera]
        assert len(own) == TRAININGS * ROUNDS * sum(KINDS.values())
    tracker, model, threshold = (
        [(r["training"], r["frame"], r["kind"], r["thing"]) for r in trainings if r["camera"] == camera]
        for camera in ("tracker", "model", "threshold")
    )
    assert tracker == model == threshold
    assert all(
        (row["label"] == "-1") == (row["found"] == "0") for row in trainings if row["camera"] != "threshold"
    )
    assert all(row["turn"] == "" for row in trainings if row["camera"] == "threshold")


def test_measured_parameters_of_the_model_are_its_own(model: dict[str, dict[str, str]]) -> None:
    """The measurement that is applied to the tracker finds the parameters of the model."""
    for kind in KINDS:
        row = model[f"position_jitter (px), {kind}"]
        assert float(row["model, measured"]) == pytest.approx(float(row["Noise.laboratory()"]), rel=0.15)
    for kind in ("1 hole", "2 holes"):
        row = model[f"heading_jitter (deg), {kind}"]
        told = float(row["Noise.laboratory()"])
        assert float(row["model, measured"]) == pytest.approx((told**2 + 1 / 12) ** 0.5, rel=0.2)


def test_the_tracker_swaps_no_labels_and_reports_no_regions_of_nothing(
    model: dict[str, dict[str, str]],
) -> None:
    tracker = "tracker on rendered frames"
    assert float(model["labels that changed things"][tracker]) == 0
    assert float(model["regions of nothing, a round"][tracker]) < 0.01
    assert float(model["rounds"][tracker]) == TRAININGS * ROUNDS


def test_speed_has_its_goal(out: Path) -> None:
    rows = {row["part"]: row for row in read(out / "table_speed.csv")}
    assert set(rows) == {"tracker", "tracker, each marker under a cable", "renderer"}
    assert [row["goal"] for row in rows.values()] == ["at least 300", "at least 300", ""]
    for row in rows.values():
        assert 0 < float(row["lowest"]) <= float(row["frames/s"]) <= float(row["highest"])


# ---------------------------------------------------------------- up to failure


@pytest.fixture(scope="module")
def limits(out: Path) -> dict[tuple[str, str, float], dict[str, str]]:
    rows = read(out / "table_limits.csv")
    return {(row["disturbance"], row["curve"], float(row["value"])): row for row in rows}


def test_markers_and_food_are_found_under_moderate_disturbances(
    limits: dict[tuple[str, str, float], dict[str, str]],
) -> None:
    for point in (
        ("width", "dark grey cable", 6.0),
        ("blur", "no cable", 0.3),
        ("exposure", "no cable", 0.75),
    ):
        row = limits[point]
        assert float(row["markers found (%)"]) >= 95
        assert float(row["food found (%)"]) == 100
        assert float(row["stray markers (per 1000)"]) == float(row["stray food (per 1000)"]) == 0
        assert float(row["warning (%)"]) == 0


def test_every_curve_of_the_picture_ends_in_failure_or_a_warning(
    limits: dict[tuple[str, str, float], dict[str, str]],
) -> None:
    for point in (("exposure", "no cable", 2.5), ("floor", "no cable", 155.0), ("noise", "no cable", 30.0)):
        assert float(limits[point]["warning (%)"]) == 100
    assert float(limits["exposure", "no cable", 2.5]["markers found (%)"]) < 50


def test_lens_is_calibrated_from_enough_points(out: Path) -> None:
    rows = {(row["points"], row["k1"]): row for row in read(out / "table_lenses.csv")}
    for layout in ("4 corners", "4 corners and the middle"):
        assert float(rows[layout, "-0.05"]["error (mm)"]) > 20
    for layout in ("4 x 4", "5 x 4"):
        assert float(rows[layout, "-0.05"]["lens calibrated (%)"]) == 100
        assert float(rows[layout, "-0.05"]["error (mm)"]) < 5
    assert (out / "limits.png").stat().st_size > 10_000
