"""`benchmarks/kheperax.py` without Kheperax itself, which needs JAX and a gigabyte."""

import sys
from pathlib import Path

import pytest

from tests.benchmarks.running import refused

pytest.importorskip("numba")
from kheperax import NAMES, NOISY, Timed, page

FAST = NAMES[-1]
RATES = {NOISY: 0.5e6, FAST: 4e6}


def test_mistakes_are_one_line(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    assert "'0'; allowed: a whole number of at least 1" in refused("kheperax", "--repeats", "0")
    monkeypatch.setitem(sys.modules, "jax", None)
    told = refused("kheperax", "--out", str(tmp_path))
    assert "pip install kheperax==0.2.0 jax" in told
    assert told.count("\n") == 1


def test_ratios_are_taken_within_repeats() -> None:
    """And with the same number of worlds; the second repeat is twice as fast for both sides."""
    rows = [
        Timed(line, worlds, repeat, round(RATES.get(line, 1e6) * speed * worlds / 256), 1.0)
        for repeat, speed in enumerate((1.0, 2.0, 1.1))
        for line in NAMES
        for worlds in (256, 1024)
    ]
    (table,) = page(rows).tables
    lines = {(str(line[0]), line[1]): line for line in table.rows}
    assert lines[FAST, 1024][3] == pytest.approx((8, 8, 8))
    assert lines[FAST, 1024][2] == pytest.approx((4 * 4.4, 4 * 4, 4 * 8))
    assert "| 8.0 [8.0, 8.0] |" in table.markdown()
