"""`benchmarks/throughput.py`: cases can be measured, tables and errors are right. No test depends on speed."""

import os
import subprocess
import time
from importlib.util import find_spec
from pathlib import Path

import pytest
import throughput
from throughput import CASES, Case, line, measure

from tests.benchmarks.running import ROOT, command_of, help_of, is_picture, read
from tests.figure_checks import check_readable, lay_out

BY_NAME = {case.name: case for case in CASES}
in_a_checkout = pytest.mark.skipif(not (ROOT / ".git").exists(), reason="needs a git checkout")


def test_help_names_every_option_and_case() -> None:
    told = help_of("throughput")
    options = ("--beside COMMIT", "--only", "--repeats", "--quick", "--seed", "--out", "results/throughput")
    assert all(word in told for word in (*options, *BY_NAME))


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_case_measures_this_version(case: Case) -> None:
    if case.name not in ("pymunk", "import", "paired") and find_spec("numba") is None:
        pytest.skip("compiled worlds need numba, the extra `fast`")
    assert case.measure(case.quick, 1) > 0


@in_a_checkout
def test_both_checkouts_are_measured_written_and_printed(tmp_path: Path) -> None:
    temporary, out = tmp_path / "temporary", tmp_path / "out"
    temporary.mkdir()
    options = ("--beside", "HEAD", "--only", "pymunk", "--quick", "--repeats", "2", "--out", str(out))
    environment = {**os.environ, "TMPDIR": str(temporary)}
    command = command_of("throughput", *options)
    done = subprocess.run(command, env=environment, cwd=tmp_path, capture_output=True, text=True, check=True)
    assert done.stderr == ""
    assert not list(temporary.iterdir())
    head = throughput.git("rev-parse", "--short", "HEAD")
    rows = read(out / "beside.csv")
    assert {(row["repeat"], row["checkout"]) for row in rows} == {
        (n, name) for n in "01" for name in (head, "here")
    }
    assert all(float(row["value"]) > 0 for row in rows)
    page = (out / "beside.md").read_text(encoding="utf-8")
    tables = [text for text in page.splitlines() if text.startswith("| ")]
    assert all(text in done.stdout and len(text) <= 100 for text in tables)
    assert f"python benchmarks/throughput.py {' '.join(options)}" in page
    assert is_picture(out / "beside.png")


@pytest.mark.parametrize(
    ("name", "pairs", "cells"),
    [
        ("make_vec", [(8e6, 4e6), (8e6, 3e6), (8e6, 5e6)], "8 M|4 M|0.50 [0.38, 0.62]|≥ 0.35; ≥ 2 M|yes"),
        ("make_vec", [(4e7, 4e6)], "40 M|4 M|0.10 [0.10, 0.10]|≥ 0.35; ≥ 2 M|no"),
        ("pymunk", [(9000, 9000)], "9,000|9,000|1.00 [1.00, 1.00]|≥ 0.6; ≥ 10 k|no"),
        ("first_make_vec", [(10, 7)], "10|7|0.70 [0.70, 0.70]|≤ 0.8; ≤ 45|yes"),
        ("first_make_vec", [(10, 8.5)], "10|8.5|0.85 [0.85, 0.85]|≤ 0.8; ≤ 45|no"),
        ("procedural_recalls", [(0, 0.6)], "|0.6||≥ 0.5|yes"),
    ],
)
def test_line_compares_medians_with_target_and_goal(
    name: str, pairs: list[tuple[float, float]], cells: str
) -> None:
    values = [{"a0e33ed": before, "here": now} for before, now in pairs]
    assert "|".join(line(BY_NAME[name], 1, values, "a0e33ed")[0][1:]) == cells


def test_line_without_a_commit_compares_with_the_goal() -> None:
    values = [{"here": value} for value in (12_345.0, 9_000.0, 20_000.0)]
    row, factors = line(BY_NAME["pymunk"], 1, values, None)
    assert row == ["Corridor-v1 on pymunk, steps/s", "12.3 k [9,000, 20 k]", "≥ 10 k", "yes"]
    assert factors == pytest.approx([1.2345, 0.9, 2.0])


def test_table_fits_a_terminal_and_picture_is_readable() -> None:
    values = {case.name: [{"a0e33ed": 1.234 * case.goal, "here": 2.345 * case.goal}] for case in CASES}
    done = [line(case, case.size, values[case.name], "a0e33ed") for case in CASES]
    columns = ["case", "a0e33ed", "here", "ratio", "target; goal", "met"]
    table = throughput.markdown([columns, *(row for row, _ in done)])
    assert max(map(len, table.splitlines())) <= 100
    check_readable(lay_out(throughput.picture([row[0] for row, _ in done], [own for _, own in done])))


@pytest.mark.parametrize(
    ("options", "told"),
    [
        (("--beside", "nowhere"), "commit 'nowhere' is unknown; allowed: "),
        (("--only", "nothing"), "--only: invalid choice: 'nothing' (choose from "),
        (("--repeats", "0"), "--repeats 0, --seed 0; allowed: "),
    ],
)
def test_mistakes_are_one_line_with_status_2(options: tuple[str, str], told: str) -> None:
    done = subprocess.run(command_of("throughput", *options), capture_output=True, text=True)
    assert (done.returncode, done.stderr.count("\n")) == (2, 1)
    assert done.stderr.startswith("throughput.py: ")
    assert told in done.stderr


def test_case_that_fails_or_measures_another_package_is_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit, match="2"):
        measure(BY_NAME["pymunk"], tmp_path, 10, 0, "")
    assert "case pymunk measured the package in " in capsys.readouterr().err
    (tmp_path / "khepera_forage").mkdir()
    (tmp_path / "khepera_forage" / "__init__.py").touch()
    with pytest.raises(SystemExit, match="2"):
        measure(BY_NAME["pymunk"], tmp_path, 10, 0, "")
    assert f"case pymunk failed in {tmp_path.name}: " in capsys.readouterr().err


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
