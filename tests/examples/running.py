"""Runs a file of `examples/` as users do: in a process of its own, and warnings as errors."""

import os
import subprocess
import sys
from contextlib import chdir
from importlib import util
from pathlib import Path
from typing import Any
from unittest import mock

from tests.benchmarks.running import run_file

EXAMPLES = Path(__file__).parents[2] / "examples"


def run_example(name: str, folder: Path, *arguments: str) -> str:
    """What an example prints in a folder; it must succeed and say nothing else, but that it compiles."""
    command = [sys.executable, "-W", "error", str(EXAMPLES / f"{name}.py"), *arguments]
    # Matplotlib and others must not start a thread for each core: other tests run beside.
    environment = {**os.environ, "OMP_NUM_THREADS": "1"}
    finished = subprocess.run(command, capture_output=True, text=True, cwd=folder, env=environment, timeout=300)
    assert finished.returncode == 0, finished.stderr
    said = [line for line in finished.stderr.splitlines() if "compiling kernels" not in line]
    assert not said, finished.stderr
    return finished.stdout


def refused(name: str, folder: Path, *arguments: str) -> str:
    """The one line with which an example ends that cannot begin; in this process, which has imported most modules."""
    with mock.patch("sys.path", [str(EXAMPLES), *sys.path]), chdir(folder):
        ended, _, errors = run_file(EXAMPLES / f"{name}.py", *arguments)
    assert ended == 2
    assert errors.count("\n") == 1
    return errors


def module_of(name: str) -> Any:
    """An example as a module."""
    spec = util.spec_from_file_location(f"example_{name}", EXAMPLES / f"{name}.py")
    assert spec is not None
    assert spec.loader is not None
    module = util.module_from_spec(spec)
    sys.modules[spec.name] = module  # dataclasses look their module up
    spec.loader.exec_module(module)
    return module
