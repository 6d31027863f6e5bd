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
from tests.benchmarks.running import ROOT, is_picture, quick, read

EXPERIMENTS = (
    *("push_and_avoid", "attribute_weights", "spatial_variety", "state_vector", "action_level", "different_robots"),
    *("chains_of_learners", "human_teacher", "alternatives", "several_learners"),
)
"""Of `further_work.py`."""
LEARNERS_RUN = tuple(
    part for name in ("teacher", "random", "imitator", "tree", "dagger_tree") for part in ("--only", name)
)
TRACKER_ROWS = ("observations", "limits", "troubles")
STARTED = (*APART, "backends", "throughput")
"""Scripts that other tests start as a user does."""


@dataclass(frozen=True)
class Script:
    """A script of `benchmarks/`, or a subcommand that does the same.

    It has row files and a page, `run` in the run that tests share, and `needs` modules.
    """

    rows: tuple[str, ...]
    run: tuple[str, ...] = ()
    page: str = ""
    needs: tuple[str, ...] = ()
    subcommand: str = ""


SCRIPTS = {
    "backends": Script(("recalls", "trainings"), needs=("numba",)),
    "decisions": Script((), needs=("numba",), subcommand="infer"),
    "further_work": Script(("trainings", "recalls"), page="spatial_variety/spatial_variety.md"),
    "lab_faults": Script(("faults",), needs=("serial", "cv2")),
    "learners": Script(("rows",), run=LEARNERS_RUN, subcommand="compare"),
    "tracker": Script(TRACKER_ROWS, needs=("cv2",)),
    "varied_arenas": Script(("recalls",), needs=("numba",)),
    "virtual_lab": Script(("recalls", "trainings"), run=("--jobs", "1"), needs=("serial", "cv2")),
    "wire": Script(("rounds", "openings"), needs=("serial",)),
}


all_scripts = pytest.mark.parametrize(
    "script",
    [
        pytest.param(
            name,
            marks=[pytest.mark.skipif(find_spec(module) is None, reason=f"needs {module}") for module in script.needs],
        )
        for name, script in SCRIPTS.items()
    ],
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


@pytest.mark.skipif(find_spec("cv2") is None, reason="needs cv2")
def test_killed_run_is_continued_with_the_same_rows_by_two_processes(quick_run: QuickRun, tmp_path: Path) -> None:
    """In a process of its own, whose workers must not print errors. The run that tests share has one process."""
    only = ("--only", "limits")
    whole, killed = quick_run("tracker", *only), tmp_path / "killed"
    shutil.copytree(whole, killed)
    (killed / "tracker.md").unlink()
    with gzip.open(killed / UNITS) as file:
        units = [gzip.compress(line) for line in file]
    done = len(units) // 2
    assert 1 <= done < len(units) - 1
    # As a kill in the middle of a write leaves it.
    (killed / UNITS).write_bytes(b"".join(units[: 1 + done]) + units[1 + done][: len(units[1 + done]) // 2])
    printed = quick("tracker", killed, *only, "--jobs", "2")
    assert f"{done} of {len(units) - 1} units are done already" in printed
    assert (killed / "tracker.md").exists()
    for name in ("limits.png", *(f"{name}.csv" for name in TRACKER_ROWS)):
        assert (whole / name).read_bytes() == (killed / name).read_bytes()
