"""Quick runs of the benchmark scripts, each done once for all tests and all test processes."""

import fcntl
import os
from collections.abc import Callable
from pathlib import Path

import pytest

from tests.benchmarks.running import quick, quick_here

QuickRun = Callable[..., Path]
APART = ("lab_faults", "virtual_lab", "wire")
"""Scripts with a process of their own: threads that are late, or times, depend on what else a process holds. All others
run in a process of the tests, which does not import everything again."""


@pytest.fixture(scope="session")
def quick_run(tmp_path_factory: pytest.TempPathFactory) -> QuickRun:
    """A function that returns the results' folder of a quick run; `printed` beside it has what the script printed,
    and `pictures` what is wrong with its pictures."""
    base = tmp_path_factory.getbasetemp()
    root = (base.parent if "PYTEST_XDIST_WORKER" in os.environ else base) / "quick_runs"

    def run(script: str, *arguments: str) -> Path:
        folder = root / "-".join((script, *arguments)).replace("/", "_")
        folder.mkdir(parents=True, exist_ok=True)
        printed = folder / "printed"
        with (folder / "lock").open("w") as lock:
            fcntl.flock(lock, fcntl.LOCK_EX)
            if not printed.exists():
                start = quick if script in APART else quick_here
                text = start(script, folder / "out", *arguments, notes=folder / "pictures")
                printed.write_text(text, encoding="utf-8")
        return folder / "out"

    return run
