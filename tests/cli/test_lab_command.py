"""`khepera-forage lab`: a laboratory is set up and checked, with virtual cubes and a virtual e-puck2."""

import argparse
import io
from pathlib import Path

import numpy as np
import pytest

from khepera_forage.cli import camera
from khepera_forage.cli.lab import lab_text
from khepera_forage.cli.options import Group
from khepera_forage.envs.laboratories import load_settings
from khepera_forage.experience import Experience
from khepera_forage.lab.settings_file import LabSettings
from khepera_forage.lab.virtual_laboratory import VirtualLaboratory
from khepera_forage.robots.epuck.firmware import EPuckFirmware
from khepera_forage.rollouts.row_files import read_rows
from khepera_forage.rollouts.rows import RecallRow, TrainingRow
from khepera_forage.sim.arenas.named import ARENAS
from khepera_forage.task.decisions import Decisions, decisions_text
from khepera_forage.vision.calibration import Calibration
from khepera_forage.vision.scene import Truth
from tests.cli.running import Run
from tests.lab.laboratories import QUIET
from tests.robots.rig import make_rig
from tests.vision.scene_renderer import render_frame, write_film


# Seeds of short recalls.
@pytest.mark.parametrize("lab", ["--lab virtual --seed 8", "--lab virtual:toio", "--lab virtual:e-puck2"])
def test_virtual_laboratories_train_and_recall(lab: str, run: Run) -> None:
    pytest.importorskip("toio")
    learners = "--num-learners 2" if "e-puck2" in lab else ""
    printed = run(f"train {lab} {learners} --episodes 1 --out files")
    assert f"virtual laboratory: {'cubes' if 'toio' in lab else 'robots at /dev/'}" in printed
    assert "0 over their time" in printed
    experience, (*_, attempt) = Experience.load("files/g1.csv"), read_rows(Path("files/attempts.csv"), TrainingRow)
    assert (len(experience), experience.seed, experience.arena) == (attempt.vectors, attempt.seed, "corridor")
    assert "mean score" in run(f"recall {lab} --episodes 1 --experience files/g1.csv --out recall.csv")
    assert read_rows(Path("recall.csv"), RecallRow)[0].experience_size == len(experience)


def test_recall_in_a_virtual_laboratory_is_filmed(run: Run) -> None:
    run("watch recall --lab virtual --seed 8 --every 50 --out film.gif")
    assert Path("film.gif").read_bytes().startswith(b"GIF")


def test_new_writes_a_file_that_check_accepts(monkeypatch: pytest.MonkeyPatch, run: Run) -> None:
    pytest.importorskip("toio")
    file = Path("lab.toml")
    answers = iter(["toio", "virtual:t1 virtual:l1", "virtual:f1 virtual:f2"])
    monkeypatch.setattr("builtins.input", lambda question: next(answers))
    out = run("lab new --out lab.toml")
    assert out.count(" pass ") == 5
    assert "khepera-forage train --lab lab.toml" in out
    settings = load_settings(file)
    assert [robot.port for robot in settings.robots] == ["virtual:t1", "virtual:l1"]
    assert settings.food_cubes == ("virtual:f1", "virtual:f2")
    assert "all is well" in run("lab check lab.toml")
    file.unlink()
    made = run("lab new --robot toio --port virtual:t1 virtual:l1 --food-cube virtual:f1", status=1)
    *_, food, last = run("lab check lab.toml", status=1).splitlines()
    assert "FAIL   1 food cubes for 2 places; allowed: one each, or for recalls alone 1" in food
    assert food in made
    assert last == "1 to repair; begin with the first"
    assert made.endswith("khepera-forage train --lab lab.toml\n")
    arms = run("lab new --robot khepera --port /dev/none --camera none.avi --out arms.toml", status=1)
    assert arms.endswith("khepera-forage train --lab arms.toml --decision lowering_speed=0\n")


def test_new_shows_the_picture_and_calibrates_by_clicks(monkeypatch: pytest.MonkeyPatch, run: Run) -> None:
    """The clicks themselves belong to `khepera-forage camera calibrate`."""
    film = write_film(Path("film.avi"), [np.full((1080, 1920, 3), 128, np.uint8)] * 60)
    places: list[tuple[float, float]] = []

    def calibrate_command(arguments: argparse.Namespace) -> int:
        places.extend(arguments.places)
        Calibration.identity(arguments.camera, arguments.size).save(arguments.out)
        return 0

    clicked = camera.calibrate_command._replace(run=calibrate_command)
    monkeypatch.setattr("khepera_forage.cli.camera.camera_command", Group("", [clicked]))
    monkeypatch.setattr("builtins.input", lambda question: "y" if "Calibrate" in question else "1000,1000,2000")
    Path("labs").mkdir()
    with make_rig(kind=EPuckFirmware) as rig:
        new = f"lab new --robot e-puck2 --port {rig.url} --camera {film} --out labs/lab.toml"
        lines = run(new, status=1).splitlines()
    assert [line.split()[2 if line.startswith("robot") else 1] for line in lines[:3]] == ["pass", "pass", "FAIL"]
    assert "no marker of teacher is seen in its arena" in lines[2]
    assert Path("labs/lab.png").stat().st_size > 0
    assert places == [(600, 600), (1250, 600), (1250, 830), (600, 830)], "the corners of the corridor"
    settings = load_settings("labs/lab.toml")
    assert settings.camera.calibration == Path("labs/lab_calibration.toml")
    assert Calibration.load(settings.camera.calibration).camera == (1000, 1000, 2000)
    assert settings.tracker.marker_height == 35, "on top of a robot that is 45 mm high, on the plan"
    assert settings.camera.size is None, "frames have the size of the calibration"
    assert settings.tracker.markers == "tags", "a larger marker would hide the food that an e-puck2 pushes"
    for name in ("lab.toml", "lab.png", "lab_calibration.toml"):  # each is kept
        assert f"{name} is there already; allowed: another --out" in run.refused(
            "lab new --robot e-puck2 --out labs/lab.toml"
        )
        Path("labs", name).rename(f"labs/other_{name}")


def test_period_of_the_file_must_be_the_decided_round_duration(monkeypatch: pytest.MonkeyPatch, run: Run) -> None:
    """With a period in the file both are compared; without one the laboratory takes the decision."""
    opened = []

    def laboratory(settings: LabSettings) -> VirtualLaboratory:
        opened.append(settings)
        return VirtualLaboratory(settings, arm_speed=40, jaw_speed=333, **QUIET)

    monkeypatch.setattr("khepera_forage.lab.laboratory.Laboratory", laboratory)
    file = '[camera]\nsource = 0\n[[robots]]\nport = "/dev/none"\nholes = 2\noffset = [600, 600]\n'
    recall = "recall --episodes 1 --out rows.csv --lab lab.toml --decision"
    Path("lab.toml").write_text("period = 0.2\n" + file)
    refused = run.refused(f"{recall} round_duration=0.1")
    assert "a round of this world lasts 0.2 s, and decision round_duration is 0.1 s" in refused
    for period in ("period = 0.2\n", ""):
        Path("lab.toml").write_text(period + file)
        run(f"{recall} round_duration=0.2 --decision food_to_home=200 --decision lowering_speed=0")
        assert opened[-1].period == 0.2
        assert opened[-1].arena.home.x - opened[-1].arena.foods[0].x == 200
        (row,) = read_rows(Path("rows.csv"), RecallRow)
        assert row.decisions == decisions_text(Decisions(round_duration=0.2, food_to_home=200, lowering_speed=0))
        assert row.delivered == 1, "although the arm takes a second"


@pytest.mark.parametrize("arena", ARENAS)
def test_arenas_of_any_size_stand_side_by_side(arena: str) -> None:
    Path("lab.toml").write_text(lab_text("khepera", ["a", "b"], (), "0", None, arena))
    first, second = load_settings("lab.toml").arenas
    assert second.bounds[1] - first.bounds[3] == 70


def test_check_says_what_is_wrong_in_order(run: Run) -> None:
    with make_rig(kind=EPuckFirmware) as rig:
        text = lab_text("e-puck2", ["/dev/nowhere", rig.url], (), "none.avi", None, "corridor")
        Path("lab.toml").write_text(text)
        lines = run("lab check lab.toml", status=1).splitlines()[1:]
    assert [line.split()[0] for line in lines] == ["robot", "robot", "camera", "2"]
    assert "FAIL   /dev/nowhere cannot be opened" in lines[0]
    assert " pass   e-puck2 at " in lines[1]
    assert "FAIL" in lines[2]
    assert "none.avi" in lines[2]
    assert lines[3] == "2 to repair; begin with the first"


def test_check_waits_for_a_camera_whose_first_frames_are_dark(run: Run) -> None:
    bright = render_frame(Truth(((800.0, 700.0, 0.5, 1),), ()))
    film = write_film(Path("film.avi"), [*[bright // 50] * 8, *[bright] * 60], 20)
    Path("lab.toml").write_text(lab_text("khepera", ["/dev/nowhere"], (), str(film), None, "corridor"))
    *_, camera, last = run("lab check lab.toml", status=1).splitlines()
    assert camera.split()[:2] == ["camera", "pass"]
    assert last == "1 to repair; begin with the first"


def test_new_without_answers_is_refused_in_one_line(run: Run) -> None:
    for stdin in (io.StringIO(), None):  # at its end, and closed
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr("sys.stdin", stdin)
            unanswered = run.refused("lab new")
        assert "Kind of robots (khepera, e-puck2, toio): no answer; allowed: an answer, or the option" in unanswered
