"""Studies: rows of runs that were killed, values with intervals, and pages."""

import gzip
import os
import re
import signal
import subprocess
import sys
import time
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import pytest

from khepera_forage import figures, study
from khepera_forage.estimates import Column, Table
from khepera_forage.study import UNITS, Arguments, Count, Job, Page, Picture, RowStore, collect, parse, write
from tests.limited_disk import largest_file


@dataclass(frozen=True, slots=True)
class Step:
    unit: str
    number: int


@dataclass(frozen=True, slots=True)
class Fall:
    unit: str
    replication: int
    height: float


@dataclass(frozen=True, slots=True)
class Leap:
    unit: str
    heights: tuple[float, ...]
    height: int | None
    done: bool


class Walk(NamedTuple):
    name: str

    @property
    def key(self) -> str:
        return self.name

    def run(self) -> list[Step | Fall]:
        return [Step(self.name, 0), Fall(self.name, 0, 0.5), Step(self.name, 1)]


TABLES = {Step: "steps", Fall: "falls"}


def given(out: Path, *more: str) -> Arguments:
    counts = Count("walks", 9, 3, "walks", adds_units=True), Count("length", 5, 2, "steps of a walk")
    return parse("walking", "Walks.", *counts, given=["--out", str(out), "--jobs", "1", *more])


def walk(out: Path, names: str, *more: str) -> list[str]:
    rows = collect(given(out, *more), [Walk(name) for name in names], TABLES)
    assert [row.unit for row in rows.of(Fall)] == list(names)
    return [row.unit for row in rows.of(Step)]


def test_processes_are_counted_as_joblib_does() -> None:
    assert parse("walking", "", given=["--jobs", "-1"]).jobs == -1
    timed = parse("walking", "", jobs=None, given=[])
    assert (timed.jobs, timed.fresh) == (1, True)
    with pytest.raises(SystemExit):
        parse("walking", "", jobs=None, given=["--jobs", "1"])


def test_finished_units_are_not_done_again_unless_fresh_and_rows_come_in_the_order_of_the_units(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    walk(tmp_path, "c")
    assert walk(tmp_path, "abc") == list("aabbcc")
    assert f"1 of 3 units are done already, in {tmp_path}" in capsys.readouterr().out
    walk(tmp_path, "ab")
    assert (tmp_path / "falls.csv").read_text() == "unit,replication,height\na,0,0.5\nb,0,0.5\n", "rows of this run"
    walk(tmp_path, "a", "--fresh", "--seed", "2")
    assert (tmp_path / "steps.csv").read_text() == "unit,number\na,0\na,1\n"


def test_a_process_that_dies_ends_the_run_in_one_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        collect(given(tmp_path, "--jobs", "2"), [Job("a", os._exit, (7,)), Job("b", os._exit, (7,))], TABLES)
    assert "walking.py: a process of the work was killed, or died" in capsys.readouterr().err


def test_a_run_that_was_killed_at_any_byte_continues(tmp_path: Path) -> None:
    walk(tmp_path, "abc")
    store, wanted = tmp_path / UNITS, (tmp_path / "steps.csv").read_text()
    whole = store.read_bytes()
    first_bytes = [part.start() + 1 for part in re.finditer(b"\x1f\x8b", whole)][1:]
    for length in (*range(0, len(whole), 7), *first_bytes):
        store.write_bytes(whole[:length])
        assert walk(tmp_path, "abc") == list("aabbcc")
        assert (tmp_path / "steps.csv").read_text() == wanted


def test_rows_are_read_as_they_were_written(tmp_path: Path) -> None:
    rows = [Leap("a", (1.5, float("inf")), None, True), Leap("b", (), 2, False)]
    RowStore(tmp_path, {Leap: "leaps"}, {}).add("a", rows)
    assert RowStore(tmp_path, {Leap: "leaps"}, {}).finished == {"a": rows}


def test_rows_of_other_settings_are_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    walk(tmp_path, "a")
    with pytest.raises(ValueError, match="with seed '0', and this run has '2'; allowed: the same"):
        RowStore(tmp_path, TABLES, {"seed": "2"})
    RowStore(tmp_path, TABLES, {"tree": "tree()"})
    with pytest.raises(ValueError, match=r"with tree 'tree\(\)', and this run has 'tree\(max_depth=3\)'"):
        RowStore(tmp_path, TABLES, {"tree": "tree(max_depth=3)"})
    with pytest.raises(SystemExit, match="2"):
        walk(tmp_path, "a", "--length", "6")
    assert re.match(r"walking\.py: .* with length '5', and this run has '6'", capsys.readouterr().err)
    monkeypatch.setattr(study, "__version__", "9.0")
    with pytest.raises(ValueError, match=r"with version '\d.*', and this run has '9\.0'"):
        RowStore(tmp_path, TABLES, {})


def test_a_file_of_another_kind_is_named(tmp_path: Path) -> None:
    store = tmp_path / UNITS
    walk(tmp_path, "a")
    whole = store.read_bytes()
    other_version = gzip.compress(b'{}\n{"unit": "a", "rows": {"steps": [[1, 2, 3]], "falls": []}}\n')
    for damaged in (b"unit,number\n", whole[:10] + b"\x07" + whole[11:], other_version):
        store.write_bytes(damaged)
        with pytest.raises(ValueError, match=r"units\.jsonl\.gz: .*; allowed: as this version wrote it"):
            RowStore(tmp_path, TABLES, {})


def test_a_full_disk_keeps_whole_units(tmp_path: Path) -> None:
    walk(tmp_path, "a")
    size = (tmp_path / UNITS).stat().st_size
    with largest_file(size + 1), pytest.raises(OSError, match=r"units\.jsonl\.gz"):
        RowStore(tmp_path, TABLES, {}).add("b", [])
    assert (tmp_path / UNITS).stat().st_size <= size
    assert set(RowStore(tmp_path, TABLES, {}).finished) == {"a"}


SLEEP = """
import os, sys, time
from pathlib import Path
from khepera_forage.study import Job, in_processes

def sleep(folder):
    Path(folder, str(os.getpid())).touch()
    time.sleep(100)

if __name__ == "__main__":
    list(in_processes(2)([Job(name, sleep, (sys.argv[1],)) for name in "ab"]))
"""


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT])
def test_workers_end_with_a_run_that_a_signal_ends(number: signal.Signals, tmp_path: Path) -> None:
    (tmp_path / "pids").mkdir()
    (tmp_path / "sleep.py").write_text(SLEEP)
    command = [sys.executable, str(tmp_path / "sleep.py"), str(tmp_path / "pids")]
    with subprocess.Popen(command, stderr=subprocess.DEVNULL) as run:
        while len(pids := [int(path.name) for path in (tmp_path / "pids").iterdir()]) < 2:
            assert run.poll() is None
            time.sleep(0.1)
        run.send_signal(number)
        assert run.wait(timeout=50) == (128 + number if number == signal.SIGTERM else -number)
    for pid in pids:
        with pytest.raises(ProcessLookupError):
            os.kill(pid, 0)


def test_a_page_has_its_parts_in_order(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    table = Table("heights", "Heights", "A note.", (Column("m"),), [(1,)])
    more = Table("more", "More", "", (Column("m"),), [(2,)])
    parts: list[str | Table | Picture] = [
        "A paragraph.",
        table,
        Picture("falls", "how they fell", figures.new_figure(2, 2)),
    ]
    monkeypatch.setattr("sys.argv", ["benchmarks/walking.py", "--out", "a f\udcf6lder"])  # not UTF-8
    write(tmp_path, "walking", Page("Walking", parts, (more,)))
    lines = (tmp_path / "walking.md").read_text().split("\n\n")
    assert lines[:4] == ["# Walking", "A paragraph.", "## Heights", "A note."]
    assert lines[4:7] == ["| m |\n| ---: |\n| 1 |", "![how they fell](falls.png)", "## Command"]
    assert lines[7] == "    python benchmarks/walking.py --out 'a f?lder'"
    assert (tmp_path / "table_heights.csv").read_text() == "m\n1\n"
    assert (tmp_path / "table_more.csv").exists()
    assert (tmp_path / "falls.png").read_bytes().startswith(b"\x89PNG")
