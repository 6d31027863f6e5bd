"""What all scripts of `benchmarks/` have in common: help, page, tables, pictures, rows, and continued runs."""

import gzip
import re
import shutil
import subprocess
import sys
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path

import pytest

from khepera_forage.study import UNITS
from tests.benchmarks.conftest import APART, QuickRun
from tests.benchmarks.running import ROOT, is_picture, quick, quick_here, read, refused

EXPERIMENTS = (
    *("push_and_avoid", "attribute_weights", "spatial_variety", "state_vector", "action_level", "different_robots"),
    *("chains_of_learners", "human_teacher", "alternatives", "several_learners"),
)
"""Of `further_work.py`."""
LEARNERS_RUN = tuple(
    part for name in ("teacher", "random", "imitator", "tree", "dagger_tree") for part in ("--only", name)
)
STARTED = (*APART, "backends", "throughput")
"""Scripts that other tests start as a user does."""


@dataclass(frozen=True)
class Script:
    """A script of `benchmarks/`.

    Attributes:
        rows: Names of its row files.
        run: Arguments of the quick run that tests share.
        repeatable: Arguments of a quick run with the same rows on any number of processes; None if rows are times.
        page: Where the page is, in the results' folder.
        needs: Modules without which it cannot run.
        subcommand: Of `khepera-forage`, if the script does the same.
    """

    rows: tuple[str, ...]
    run: tuple[str, ...] = ()
    repeatable: tuple[str, ...] | None = None
    page: str = ""
    needs: tuple[str, ...] = ()
    subcommand: str = ""


SCRIPTS = {
    "backends": Script(("recalls", "trainings"), needs=("numba",)),
    "decisions": Script((), needs=("numba",), subcommand="infer"),
    "further_work": Script(
        ("trainings", "recalls"),
        repeatable=("--only", "spatial_variety", "--replications", "2"),
        page="spatial_variety/spatial_variety.md",
    ),
    "lab_faults": Script(("faults", "trainings"), needs=("serial", "cv2")),
    "learners": Script(("rows",), run=LEARNERS_RUN, repeatable=LEARNERS_RUN, subcommand="compare"),
    "tracker": Script(
        ("observations", "limits", "calibrations", "troubles"), repeatable=("--only", "scenes"), needs=("cv2",)
    ),
    "virtual_lab": Script(("recalls", "trainings"), run=("--jobs", "1"), needs=("serial", "cv2")),
    "wire": Script(("measurements",), needs=("serial",)),
}


def available(*names: str) -> list[object]:
    """Scripts as parameters, skipped where a module is missing."""
    return [
        pytest.param(
            name,
            marks=[
                pytest.mark.skipif(find_spec(module) is None, reason=f"needs {module}")
                for module in SCRIPTS[name].needs
            ],
        )
        for name in names
    ]


all_scripts = pytest.mark.parametrize("script", available(*SCRIPTS))
same_rows = pytest.mark.parametrize(
    "script", available(*(name for name in SCRIPTS if SCRIPTS[name].repeatable is not None))
)


def program(script: str) -> str:
    """What error messages begin with."""
    subcommand = SCRIPTS[script].subcommand
    return f"khepera-forage {subcommand}" if subcommand else f"{script}.py"


def page_of(script: str, out: Path) -> Path:
    return out / (SCRIPTS[script].page or f"{script}.md")


@pytest.mark.parametrize("path", sorted((ROOT / "benchmarks").glob("*.py")), ids=lambda path: path.stem)
def test_script_imports_all_that_it_needs_itself(path: Path) -> None:
    if path.stem not in STARTED:
        command = [sys.executable, "-W", "error", str(path), "--help"]
        done = subprocess.run(command, capture_output=True, text=True)
        assert (done.returncode, done.stderr) == (0, "")
        assert f"results/{path.stem}" in done.stdout


@all_scripts
def test_quick_run_leaves_page_tables_pictures_and_rows(script: str, quick_run: QuickRun) -> None:
    out = quick_run(script, *SCRIPTS[script].run)
    page = page_of(script, out)
    text, printed = page.read_text(encoding="utf-8"), (out.parent / "printed").read_text(encoding="utf-8")
    assert text.startswith("# ")
    tables = [part.partition("\n")[0] for part in text.split("\n## ")[1:] if "\n| " in part]
    assert tables
    assert all(title in printed.splitlines() for title in tables[: 1 if script == "learners" else None])
    assert "\n| " not in printed, "Markdown is for the page"
    assert list(page.parent.glob("table_*.csv"))
    assert all(read(page.parent / f"{name}.csv") for name in SCRIPTS[script].rows)
    command, machine = text.split("## Command\n\n    ")[1].strip().split("\n\n")[:2]
    launched = program(script) if SCRIPTS[script].subcommand else f"python benchmarks/{script}.py"
    assert command.startswith(f"{launched} ")
    assert "--quick --seed 1" in command
    assert "numpy" in machine
    pictures = re.findall(r"\]\((\w+\.png)\)", text)
    assert pictures
    assert all(is_picture(page.parent / picture) for picture in pictures)
    checked = [line.split("\t") for line in (out.parent / "pictures").read_text(encoding="utf-8").splitlines()]
    assert checked
    assert [(name, fault) for name, fault in checked if fault] == [], "readable, and shading is explained"


def rows_of(script: str, out: Path) -> dict[str, list[str]]:
    """The lines of all row files but for wall times, which come last in the rows of learners."""
    folder = page_of(script, out).parent
    names = [f"{name}.csv" for name in SCRIPTS[script].rows]
    lines = {name: (folder / name).read_text(encoding="utf-8").splitlines() for name in names}
    if script == "learners":
        lines["rows.csv"] = [line.rsplit(",", 1)[0] for line in lines["rows.csv"]]
    return lines


@same_rows
def test_killed_run_is_continued_with_the_same_rows_by_two_processes(
    script: str, quick_run: QuickRun, tmp_path: Path
) -> None:
    """The run that tests share has one process."""
    arguments = SCRIPTS[script].repeatable or ()
    whole = quick_run(script, *arguments)
    shutil.copytree(whole, tmp_path / "killed")
    folder = page_of(script, tmp_path / "killed").parent
    page_of(script, tmp_path / "killed").unlink()
    with gzip.open(folder / UNITS) as file:
        units = [gzip.compress(line) for line in file]
    done = len(units) // 2
    assert 1 <= done < len(units) - 1
    # As a kill in the middle of a write leaves it.
    (folder / UNITS).write_bytes(b"".join(units[: 1 + done]) + units[1 + done][: len(units[1 + done]) // 2])
    # One script in a process of its own, whose workers must not print errors; the others import nothing again.
    run = quick if script == "tracker" else quick_here
    printed = run(script, tmp_path / "killed", *arguments, "--jobs", "2")
    counts = re.findall(r"(\d+) of (\d+) units are done already", printed)
    assert [sum(map(int, part)) for part in zip(*counts, strict=True)] == [done, len(units) - 1]
    assert rows_of(script, whole) == rows_of(script, tmp_path / "killed")
    assert page_of(script, tmp_path / "killed").exists()
    if script == "tracker":
        assert (whole / "frame.png").read_bytes() == (tmp_path / "killed" / "frame.png").read_bytes()


@same_rows
def test_rows_of_another_seed_are_refused(script: str, quick_run: QuickRun) -> None:
    arguments = SCRIPTS[script].repeatable or ()
    out = quick_run(script, *arguments)
    told = refused(script, "--seed", "2", "--out", str(out), *arguments)
    assert told.startswith(f"{program(script)}: ")
    assert "made with seed '1', and this run has '2'; allowed: the same, another folder" in told


def test_counts_are_checked() -> None:
    assert "'0'; allowed: a whole number of at least 1" in refused("backends", "--forages", "0")
    assert "'0'; allowed: a whole number of at least 1, or -1" in refused("backends", "--jobs", "0")
