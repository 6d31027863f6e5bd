"""`benchmarks/tracker.py`: what it measures is there, adds up, and meets what was asked of the tracker."""

from pathlib import Path

import pytest

from tests.benchmarks.running import help_of, is_picture, quick, read

SCENES, DRIVES, ROUNDS = 30, 2, 150
KINDS = {"food": 2, "1 hole": 1, "2 holes": 1}
"""And how many of each there are."""


@pytest.fixture(scope="module")
def out(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("run") / "tracker"
    (folder.parent / "printed").write_text(quick("tracker.py", folder), encoding="utf-8")
    return folder


@pytest.fixture(scope="module")
def accuracy(out: Path) -> dict[tuple[str, str], dict[str, str]]:
    return {(row["look"], row["region"]): row for row in read(out / "tracker_accuracy.csv")}


@pytest.fixture(scope="module")
def model(out: Path) -> dict[str, dict[str, str]]:
    return {row["quantity"]: row for row in read(out / "tracker_model.csv")}


@pytest.fixture(scope="module")
def drives(out: Path) -> list[dict[str, str]]:
    return read(out / "drives.csv")


def test_every_look_has_its_lines(accuracy: dict[tuple[str, str], dict[str, str]]) -> None:
    looks = {look for look, _ in accuracy}
    assert {"laboratory", "laboratory, no cables", "nothing but quantisation"} < looks
    assert set(accuracy) == {(look, kind) for look in looks for kind in KINDS}
    for (_, kind), row in accuracy.items():
        assert int(row["frames"]) == SCENES * KINDS[kind]
        assert 0 <= int(row["under a cable"]) <= int(row["frames"])


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("look", ["nothing but quantisation", "laboratory", "blur 1.2 pixels"])
def test_what_was_asked_of_the_tracker(
    accuracy: dict[tuple[str, str], dict[str, str]], look: str, kind: str
) -> None:
    row = accuracy[look, kind]
    assert float(row["found (%)"]) > 90
    assert float(row["within 1 px (%)"]) >= 99
    assert float(row["99 % (px)"]) <= 1
    if kind != "food":
        assert float(row["within 3 deg (%)"]) >= 99
        assert int(row["reversed"]) == 0


def test_parallax_that_is_not_corrected_shows(accuracy: dict[tuple[str, str], dict[str, str]]) -> None:
    corrected, not_corrected = (
        accuracy[f"camera at 2.7 m, {how}", "food"] for how in ("parallax corrected", "not corrected")
    )
    assert float(corrected["centre: median (px)"]) < 0.2 < float(not_corrected["centre: median (px)"])


def test_all_cameras_saw_the_same_drives(drives: list[dict[str, str]]) -> None:
    for camera in ("tracker", "model", "bare threshold"):
        own = [row for row in drives if row["camera"] == camera]
        assert len(own) == DRIVES * ROUNDS * sum(KINDS.values())
    tracker, model, bare = (
        [(r["drive"], r["frame"], r["kind"], r["thing"]) for r in drives if r["camera"] == camera]
        for camera in ("tracker", "model", "bare threshold")
    )
    assert tracker == model == bare
    assert all(
        (row["label"] == "-1") == (row["found"] == "0") for row in drives if row["camera"] != "bare threshold"
    )
    assert all(row["turn"] == "nan" for row in drives if row["camera"] == "bare threshold")


def test_the_model_measures_as_it_was_told(model: dict[str, dict[str, str]]) -> None:
    """The same measurement that judges the tracker finds in the model what is put into it."""
    for kind in KINDS:
        row = model[f"position_jitter (px), {kind}"]
        assert float(row["model, measured"]) == pytest.approx(float(row["Noise.laboratory()"]), rel=0.15)
    for kind in ("1 hole", "2 holes"):
        row = model[f"heading_jitter (deg), {kind}"]
        told = float(row["Noise.laboratory()"])
        assert float(row["model, measured"]) == pytest.approx((told**2 + 1 / 12) ** 0.5, rel=0.2)


def test_no_identity_is_swapped_and_nothing_is_seen_that_is_not_there(
    model: dict[str, dict[str, str]],
) -> None:
    tracker = "tracker on rendered frames"
    assert float(model["labels that changed things"][tracker]) == 0
    assert float(model["regions of nothing, a round"][tracker]) < 0.01
    assert float(model["rounds"][tracker]) == DRIVES * ROUNDS


def test_speed_has_its_goal(out: Path) -> None:
    rows = {row["part"]: row for row in read(out / "tracker_speed.csv")}
    assert set(rows) == {"tracker", "renderer"}
    assert rows["tracker"]["goal"] == "at least 500"
    for row in rows.values():
        assert 0 < float(row["lowest"]) <= float(row["frames/s"]) <= float(row["highest"])


def test_tables_are_printed_and_written_with_their_pictures(out: Path) -> None:
    page = (out / "tracker.md").read_text(encoding="utf-8")
    printed = (out.parent / "printed").read_text(encoding="utf-8")
    for line in page.splitlines():
        if line.startswith("| "):
            assert line in printed
    assert is_picture(out / "tracker.png")
    assert is_picture(out / "frame.png")


def test_same_rows_on_any_number_of_processes(out: Path, tmp_path: Path) -> None:
    arguments = ("--scenes", "10", "--drives", "2", "--rounds", "20")
    for jobs in ("1", "2"):
        quick("tracker.py", tmp_path / jobs, *arguments, "--jobs", jobs)
    names = ["drives.csv", "scenes_laboratory.csv", "tracker_model.csv", "frame.png"]
    for name in names:
        assert (tmp_path / "1" / name).read_bytes() == (tmp_path / "2" / name).read_bytes(), name


def test_help_names_every_argument() -> None:
    told = help_of("tracker.py")
    for argument in (
        "--seed",
        "--out",
        "--quick",
        "--scenes",
        "--drives",
        "--rounds",
        "--jobs",
        "results/tracker",
    ):
        assert argument in told
