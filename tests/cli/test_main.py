"""The `khepera-forage` command and its subcommands for simulations."""

import subprocess
import sys
from pathlib import Path

import pytest

from khepera_forage.cli.main import main
from khepera_forage.rollouts.row_files import read_rows
from khepera_forage.rollouts.rows import RecallRow, TrainingRow


@pytest.mark.parametrize("command", ["reproduce", "train", "teach", "recall", "watch"])
def test_help_has_the_common_options(command: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as stop:
        main([command, "--help"])
    assert stop.value.code == 0
    out = capsys.readouterr().out
    assert "--seed" in out
    assert "--out" in out


def test_train_recall_and_watch_work_together(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    folder = tmp_path / "experience"
    assert main(["train", "--episodes", "2", "--out", str(folder), "--seed", "1"]) == 0
    files = [str(folder / "g1.csv"), str(folder / "g2.csv")]
    assert len(read_rows(folder / "attempts.csv", TrainingRow)) >= 2
    rows = tmp_path / "rows.csv"
    assert main(["recall", "--experience", *files, "--episodes", "2", "--out", str(rows), "--seed", "1"]) == 0
    assert [row.learner for row in read_rows(rows, RecallRow)] == ["imitator"] * 2
    assert "mean score" in capsys.readouterr().out
    film = tmp_path / "film.gif"
    assert main(["watch", "training", "--out", str(film), "--every", "20"]) == 0
    assert film.read_bytes().startswith(b"GIF")
    assert main(["watch", "recall", "--experience", *files, "--out", str(film), "--every", "50"]) == 0


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["recall", "--experience", "nowhere.csv"], "nowhere.csv"),
        (["recall", "--episodes", "0"], "--episodes is 0; allowed: at least 1"),
        (["recall", "--food-type", "CHEESE"], "'CHEESE' is unknown; allowed: PICKABLE"),
        (["train", "--episodes", "-1"], "--episodes is -1; allowed: at least 1"),
        (["train", "--num-learners", "0"], "num_learners is 0"),
        (["watch", "recall", "--out", "film.mp4"], "'film.mp4'; allowed: a name that ends in .gif"),
        (["reproduce", "--replications", "0"], "--replications is 0; allowed: at least 1"),
        (["watch", "recall", "--every", "0"], "--every is 0; allowed: at least 1"),
    ],
)
def test_user_error_is_reported_in_one_line(
    arguments: list[str],
    message: str,
    capsys: pytest.CaptureFixture[str],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(arguments) == 2
    err = capsys.readouterr().err
    assert message in err
    assert err.count("\n") == 1


def test_installed_command_prints_its_version() -> None:
    command = Path(sys.executable).with_name("khepera-forage")
    done = subprocess.run([command, "--version"], capture_output=True, text=True, check=True)
    assert done.stdout.startswith("khepera-forage 0.")
