"""`khepera-forage lab`: a laboratory is set up and checked, with virtual cubes and a virtual e-puck2."""

from pathlib import Path

import pytest

from khepera_forage.cli.lab.new import lab_text
from khepera_forage.cli.main import main
from khepera_forage.envs.laboratories import load_settings
from khepera_forage.robots.epuck.virtual import EPuckFirmware
from khepera_forage.robots.virtual.virtual_khepera import VirtualKhepera
from tests.robots.rig import make_rig

pytest.importorskip("cv2")


def test_new_writes_a_file_that_check_accepts(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    pytest.importorskip("toio")
    file = tmp_path / "lab.toml"
    answers = iter(["toio", "virtual:t1 virtual:l1", "virtual:f1 virtual:f2"])
    monkeypatch.setattr("builtins.input", lambda question: next(answers))
    assert main(["lab", "new", "--out", str(file)]) == 0
    out = capsys.readouterr().out
    assert out.count(" pass ") == 4
    assert f"khepera-forage train --lab {file}" in out
    settings = load_settings(file)
    assert [robot.port for robot in settings.robots] == ["virtual:t1", "virtual:l1"]
    assert settings.food_cubes == ("virtual:f1", "virtual:f2")
    assert main(["lab", "check", str(file)]) == 0
    assert "all is well" in capsys.readouterr().out
    assert main(["lab", "new", "--out", str(file)]) == 2
    assert "is there already; allowed: another --out" in capsys.readouterr().err


def test_check_says_what_is_wrong_in_order(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "lab.toml"
    with make_rig() as rig, VirtualKhepera(EPuckFirmware(rig.robots[0], rig.lock), baud=None) as port:
        ports = ["/dev/nowhere", port.url]
        file.write_text(lab_text("e-puck2", ports, (), str(tmp_path / "none.avi"), None, "corridor"))
        assert main(["lab", "check", str(file)]) == 1
    lines = capsys.readouterr().out.splitlines()[1:]
    assert [line.split()[0] for line in lines] == ["robot", "robot", "camera", "2"]
    assert "FAIL   /dev/nowhere cannot be opened" in lines[0]
    assert " pass   e-puck2 at " in lines[1]
    assert "FAIL" in lines[2]
    assert "none.avi" in lines[2]
    assert lines[3] == "2 to repair; begin with the first"


def test_errors_of_users_are_one_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["lab", "check", str(tmp_path / "none.toml")]) == 2
    file = tmp_path / "lab.toml"
    file.write_text(lab_text("khepera", ["/dev/a"], (), "0", None, "corridor").replace("port", "prt"))
    assert main(["lab", "check", str(file)]) == 2
    errors = capsys.readouterr().err.splitlines()
    assert len(errors) == 2
    assert "none.toml" in errors[0]
    assert "robots[0].prt is unknown (did you mean port?)" in errors[1]
