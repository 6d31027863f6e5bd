"""Every script of `benchmarks/` imports all that it needs itself, in an order that works without other imports."""

import subprocess
import sys
from pathlib import Path

import pytest

from tests.benchmarks.conftest import APART
from tests.benchmarks.running import ROOT

STARTED = APART
"""Scripts that other tests start as a user does."""
OTHERS = sorted({path.stem for path in (ROOT / "benchmarks").glob("*.py")} - {*STARTED, "kheperax_steps"})


@pytest.fixture(scope="module")
def printed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of what scripts print and of their errors."""
    folder = tmp_path_factory.mktemp("alone")
    command = [sys.executable, "-W", "error", "-m", "tests.benchmarks.start_alone", str(folder), *OTHERS]
    subprocess.run(command, cwd=ROOT, capture_output=True, timeout=300)
    return folder


@pytest.mark.parametrize("script", OTHERS)
def test_script_starts_alone(script: str, printed: Path) -> None:
    assert (printed / f"{script}.errors").read_text(encoding="utf-8") == ""
    assert (printed / f"{script}.txt").read_text(encoding="utf-8").startswith("usage: ")
