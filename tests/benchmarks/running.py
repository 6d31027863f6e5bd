"""Runs a script of `benchmarks/` in a process of its own, warnings as errors."""

import csv
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[2]
PNG = b"\x89PNG\r\n\x1a\n"


def quick(script: str, out: Path, *arguments: str) -> str:
    """What a script prints with --quick, seed 1, and results in `out`; it must succeed, and silently otherwise."""
    path = ROOT / "benchmarks" / script
    command = [
        sys.executable,
        "-W",
        "error",
        str(path),
        "--quick",
        "--seed",
        "1",
        "--out",
        str(out),
        *arguments,
    ]
    # Another folder than the repository's: a script must not lean on where it is started.
    finished = subprocess.run(command, capture_output=True, text=True, cwd=out.parent, timeout=300)
    assert finished.returncode == 0, finished.stderr
    assert finished.stderr == ""
    return finished.stdout


def help_of(script: str) -> str:
    """What a script says of itself."""
    command = [sys.executable, "-W", "error", str(ROOT / "benchmarks" / script), "--help"]
    return subprocess.run(command, capture_output=True, text=True, check=True).stdout


def read(path: Path) -> list[dict[str, str]]:
    """The rows of a CSV file with a heading."""
    with path.open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def is_picture(path: Path) -> bool:
    """Whether there is a PNG of some size."""
    data = path.read_bytes()
    return data.startswith(PNG) and len(data) > 10_000
