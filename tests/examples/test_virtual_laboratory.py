"""`examples/virtual_laboratory.py`: experience and recalls from real drivers."""

from pathlib import Path

import pytest

from khepera_forage.experience import Experience
from khepera_forage.rollouts.row_files import read_rows
from khepera_forage.rollouts.rows import RecallRow
from tests.examples.running import refused, run_example

pytest.importorskip("serial")
pytest.importorskip("cv2")


def test_training_and_recalls_leave_experience_and_rows(tmp_path: Path) -> None:
    # With this seed, one attempt of about 100 rounds is complete, and both recalls deliver.
    small = ("--episodes", "1", "--recalls", "2", "--seed", "8")
    printed = run_example("virtual_laboratory", tmp_path, *small, "--out", "out")
    experience = Experience.load(tmp_path / "out" / "g1.csv")
    rows = read_rows(tmp_path / "out" / "recalls.csv", RecallRow)
    assert [row.experience_size for row in rows] == [len(experience)] * 2
    assert all(row.score > 0 for row in rows), "chance has a negative score"
    assert f"g1.csv: {len(experience)} experience vectors" in printed
    message = refused("virtual_laboratory", tmp_path, "--out", "out")
    assert "out has experience files; allowed: another --out" in message
