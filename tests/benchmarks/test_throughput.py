"""`benchmarks/throughput.py`: cases can be measured, lines and errors are right. No test depends on speed."""

import os
import subprocess
import time
from importlib.util import find_spec
from pathlib import Path

import pytest
import throughput
from throughput import BY_NAME, CASES, Case, line, measure

from tests.benchmarks.running import ROOT, command_of, quick, read, refused

in_a_checkout = pytest.mark.skipif(not (ROOT / ".git").exists(), reason="needs a git checkout")


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_case_measures_this_version(case: Case) -> None:
    if case.name not in ("pymunk", "import", "paired") and find_spec("numba") is None:
        pytest.skip("compiled worlds need numba, the extra `fast`")
    assert case.measure(case.quick, 1) > 0


@in_a_checkout
def test_both_checkouts_are_measured_written_and_printed(tmp_path: Path) -> None:
    options = ("--beside", "HEAD", "--only", "pymunk", "--repeats", "2")
    printed = quick("throughput", tmp_path / "out", *options)
    head = throughput.git("rev-parse", "--short", "HEAD")
    rows = read(tmp_path / "out" / "rows.csv")
    assert [row["checkout"] for row in rows] == [head, "here", "here", head]
    assert all(float(row["value"]) > 0 for row in rows)
    page = (tmp_path / "out" / "throughput.md").read_text(encoding="utf-8")
    tables = [section.partition("\n")[0] for section in page.split("\n## ")[1:] if "\n| " in section]
    assert tables
    assert all(title in printed for title in tables)
    assert "python benchmarks/throughput.py " in page


@pytest.mark.parametrize(
    ("name", "pairs", "cells"),
    [
        ("make_vec", [(8e6, 4e6), (8e6, 3e6), (8e6, 5e6)], "8 M|4 M|0.50 [0.38, 0.62]|≥ 0.35; ≥ 2 M|yes"),
        ("make_vec", [(4e7, 4e6)], "40 M|4 M|0.10 [0.10, 0.10]|≥ 0.35; ≥ 2 M|no"),
        ("pymunk", [(9000, 9000), (9000, 9000), (9000, 18_000)], "9,000|9,000|1.00 [1.00, 2.00]|≥ 0.6; ≥ 10 k|no"),
        ("first_make_vec", [(10, 7)], "10|7|0.70 [0.70, 0.70]|≤ 0.8; ≤ 45|yes"),
        ("first_make_vec", [(10, 8.5)], "10|8.5|0.85 [0.85, 0.85]|≤ 0.8; ≤ 45|no"),
    ],
)
def test_line_compares_medians_with_target_and_goal(name: str, pairs: list[tuple[float, float]], cells: str) -> None:
    before, now = zip(*pairs, strict=True)
    assert "|".join(line(BY_NAME[name], 1, now, before)[1:]) == cells


def test_line_without_a_commit_compares_with_the_goal() -> None:
    told = ("Corridor-v1 on pymunk, steps/s", "12.3 k [9,000, 20 k]", "≥ 10 k", "yes")
    assert line(BY_NAME["pymunk"], 1, (12_345.0, 9_000.0, 20_000.0)) == told


def test_mistakes_are_one_line() -> None:
    for options, told in (
        (("--beside", "no-such-commit"), "commit 'no-such-commit' is unknown; allowed: one of a git clone"),
        (("--only", "nothing"), "'nothing'"),
        (("--repeats", "0"), "allowed: a whole number of at least 1"),
    ):
        error = refused("throughput", *options)
        assert error.startswith("throughput.py: ")
        assert told in error
        assert error.count("\n") == 1


def test_case_that_fails_or_measures_another_package_is_refused(tmp_path: Path) -> None:
    with pytest.raises(RuntimeError, match="case pymunk measured the package in "):
        measure(BY_NAME["pymunk"], tmp_path, 10, 0, "")
    (tmp_path / "khepera_forage").mkdir()
    (tmp_path / "khepera_forage" / "__init__.py").touch()
    with pytest.raises(RuntimeError, match=f"case pymunk failed in {tmp_path.name}: "):
        measure(BY_NAME["pymunk"], tmp_path, 10, 0, "")


@in_a_checkout
def test_checkouts_are_removed_after_a_signal(tmp_path: Path) -> None:
    command = command_of("throughput", "--beside", "HEAD", "--only", "pymunk", "--out", str(tmp_path / "out"))
    (tmp_path / "temporary").mkdir()
    running = subprocess.Popen(command, env={**os.environ, "TMPDIR": str(tmp_path / "temporary")})
    until = time.monotonic() + 60
    while not list(tmp_path.glob("temporary/throughput-*/here/khepera_forage")) and time.monotonic() < until:
        time.sleep(0.05)
    running.terminate()
    assert running.wait(timeout=60) == 128 + 15
    assert not list((tmp_path / "temporary").iterdir())
