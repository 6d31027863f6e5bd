"""`examples/imitation.py`: rows, a figure, and a learner that brings food home."""

from pathlib import Path

import pytest

from khepera_forage.rollouts.row_files import read_rows
from khepera_forage.rollouts.rows import RecallRow
from tests.benchmarks.running import is_picture
from tests.examples.running import refused, run_example

pytest.importorskip("matplotlib")
FOODS = (("corridor", 1), ("rectangle", 2))


def test_imitator_brings_food_home_in_both_arenas_and_a_wrong_number_is_refused(tmp_path: Path) -> None:
    printed = run_example("imitation", tmp_path, "--replications", "1", "--recalls", "3", "--out", "out")
    rows = read_rows(tmp_path / "out" / "recalls.csv", RecallRow)
    assert [(row.arena, row.episodes) for row in rows[::3]] == [
        (arena, amount) for arena in ("corridor", "rectangle") for amount in (1, 3, 5, 10)
    ]
    trained = [row for row in rows if row.episodes == 10]
    for arena in ("corridor", "rectangle"):
        assert sum(row.delivered for row in rows if row.arena == arena) > 0
    assert len({row.experience_size for row in rows}) == 4
    assert is_picture(tmp_path / "out" / "food.png")
    shares = [f"{100 * sum(row.delivered for row in trained if row.arena == a) / n / 3:.1f}" for a, n in FOODS]
    assert f"10 training episodes: corridor {shares[0]:>5}, rectangle {shares[1]:>5}" in printed
    message = "--recalls: '0'; allowed: a whole number of at least 1"
    assert message in refused("imitation", tmp_path, "--recalls", "0")
