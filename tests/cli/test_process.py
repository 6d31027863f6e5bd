"""What the commands assume about their process: streams, pipes, encodings, and the system."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from tests.cli.running import Run

COMMAND = f"{sys.executable} -m khepera_forage"


def shell(command: str, **environment: str) -> subprocess.CompletedProcess[str]:
    run = ["bash", "-o", "pipefail", "-c", command]
    return subprocess.run(run, capture_output=True, text=True, env={**os.environ, **environment}, timeout=120)


@pytest.mark.parametrize(("command", "unbuffered"), [("decisions", "1"), ("decisions", ""), ("--help", "")])
def test_closed_pipe_ends_in_silence(command: str, unbuffered: str) -> None:
    done = shell(f"{COMMAND} {command} | true", PYTHONUNBUFFERED=unbuffered)
    assert (done.returncode, done.stderr) == (141, "")


@pytest.mark.parametrize(
    ("command", "file"),
    [
        ("train --episodes 1 --seed 1 --out g >&- 2>&-", "g/attempts.csv"),
        ("watch recall --every 100 --out film.gif 2>&-", "film.gif"),
        ("recall --experience nowhere.csv 2>&-", None),
    ],
)
def test_command_without_output_streams_does_its_work(command: str, file: str | None) -> None:
    done = shell(f"{COMMAND} {command}")
    assert (done.returncode, done.stderr) == (0 if file else 2, "")
    assert file is None or Path(file).stat().st_size > 100


def test_output_in_a_narrow_encoding_replaces_characters() -> None:
    Path("wände.toml").write_text("")
    done = shell(f"{COMMAND} arena show wände.toml", PYTHONIOENCODING="ascii")
    assert done.returncode == 2
    assert "w?nde.toml" in done.stderr


def test_commands_work_without_docstrings() -> None:
    done = shell(f"{sys.executable} -OO -m khepera_forage arena list")
    assert (done.returncode, done.stderr) == (0, "")
    assert "rectangle" in done.stdout


def test_virtual_laboratory_without_pseudo_terminals_says_so(monkeypatch: pytest.MonkeyPatch, run: Run) -> None:
    monkeypatch.setitem(sys.modules, "tty", None)  # as on Windows
    error = run.refused("train --lab virtual --episodes 1")
    assert "pseudo-terminal, which this system does not have; allowed: Linux, macOS" in error


def test_help_of_all_commands_imports_only_what_it_needs() -> None:
    done = shell(f"{sys.executable} -X importtime -m khepera_forage --help")
    assert "be the teacher yourself, with keys in a window" in done.stdout
    imported = {line.rpartition("|")[2].strip() for line in done.stderr.splitlines()}
    assert "khepera_forage.cli.main" in imported
    heavy = "cv2 joblib matplotlib numba pygame pymunk scipy shapely sklearn tqdm"
    assert not imported & set(heavy.split()), "the package itself loads none of them, either"
