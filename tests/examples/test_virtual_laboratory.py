"""`examples/virtual_laboratory.py`: experience and recalls from real drivers, and robots that stop."""

from pathlib import Path
from typing import Any

import pytest

from khepera_forage.experience import Experience
from khepera_forage.rollouts.row_files import read_rows
from khepera_forage.rollouts.rows import RecallRow
from tests.examples.running import module_of, refused, run_example
from tests.lab.laboratories import is_stopped

pytest.importorskip("serial")
pytest.importorskip("cv2")

SEED = ("--seed", "8")
"""With it, one attempt of about 100 rounds is complete, and both recalls deliver."""


def test_training_and_recalls_leave_experience_and_rows(tmp_path: Path) -> None:
    small = ("--episodes", "1", "--recalls", "2", *SEED)
    printed = run_example("virtual_laboratory", tmp_path, *small, "--out", "out")
    experience = Experience.load(tmp_path / "out" / "g1.csv")
    rows = read_rows(tmp_path / "out" / "recalls.csv", RecallRow)
    assert [row.experience_size for row in rows] == [len(experience)] * 2
    assert all(row.score > 0 for row in rows), "chance has a negative score"
    assert f"g1.csv: {len(experience)} experience vectors" in printed
    message = refused("virtual_laboratory", tmp_path, "--out", "out")
    assert "out has experience files; allowed: another --out" in message


@pytest.fixture
def example(monkeypatch: pytest.MonkeyPatch) -> Any:
    """The example as a module that keeps its laboratories in `opened`."""
    module = module_of("virtual_laboratory")
    module.opened = []
    virtual_laboratory = module.virtual_laboratory

    def opening(*arguments: Any, **options: Any) -> Any:
        module.opened.append(virtual_laboratory(*arguments, **options))
        return module.opened[-1]

    monkeypatch.setattr(module, "virtual_laboratory", opening)
    return module


def test_robots_stop_after_an_error(example: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """An error of the imitator in the tenth round of the first recall."""
    act = example.NearestNeighbourImitator.neighbours
    rounds: list[int] = []

    def failing(imitator: Any, observation: Any) -> Any:
        rounds.append(len(rounds))
        if len(rounds) == 10:
            assert not is_stopped(example.opened[1])
            raise RuntimeError("the learner failed")
        return act(imitator, observation)

    monkeypatch.setattr(example.NearestNeighbourImitator, "neighbours", failing)
    with pytest.raises(RuntimeError, match="the learner failed"):
        example.main(["--out", str(tmp_path), "--episodes", "1", "--recalls", "1", *SEED])
    assert is_stopped(example.opened[1])
