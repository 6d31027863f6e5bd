"""`benchmarks/kheperax.py` without Kheperax itself, which needs JAX, an environment of its own and the network."""

import sys
from pathlib import Path

import pytest

from tests.benchmarks.running import refused

pytest.importorskip("numba")
from kheperax import SETTINGS, TASKS, Timed, page

RATES = {SETTINGS["noise"]: 0.5e6, TASKS["rectangle"][0]: 4e6}


def test_numbers_of_worlds_are_checked() -> None:
    assert "'0'; allowed: a whole number of at least 1" in refused("kheperax", "--worlds", "64", "0")


def test_a_folder_that_is_no_environment_is_left_alone(tmp_path: Path) -> None:
    (tmp_path / "mine.txt").write_text("mine")
    told = refused("kheperax", "--out", str(tmp_path / "out"), "--venv", str(tmp_path))
    assert f"--venv is {str(tmp_path)!r}, which is no virtual environment" in told
    assert [path.name for path in tmp_path.iterdir()] == ["mine.txt"]


def test_an_environment_without_kheperax_is_reported(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "bin").mkdir()
    (tmp_path / "bin" / "python").symlink_to(Path(sys.base_prefix) / "bin" / "python3")
    told = refused("kheperax", "--out", str(tmp_path / "out"), "--venv", str(tmp_path))
    assert "ended with status 1" in told
    assert "delete it" in told
    assert "ModuleNotFoundError" in capfd.readouterr().err


def test_ratios_are_taken_within_repeats() -> None:
    """The second repeat is twice as fast for both sides."""
    rows = [
        Timed(line, worlds, repeat, round(RATES.get(line, 1e6) * speed), 1.0, 2.5)
        for repeat, speed in enumerate((1.0, 2.0, 1.1))
        for line in (*SETTINGS.values(), *(name for name, *_ in TASKS.values()))
        for worlds in (256, 1024)
    ]
    (table,) = page(rows).tables
    lines = {(str(line[0]), line[1]): line for line in table.rows}
    assert lines[TASKS["rectangle"][0], 256][3] == pytest.approx((8, 8, 8))
    assert lines[TASKS["rectangle"][0], 1024][2] == pytest.approx((4.4, 4, 8))
    assert "| 8.0 [8.0, 8.0] |" in table.markdown()
