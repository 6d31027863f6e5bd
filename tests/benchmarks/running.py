"""Runs a script of `benchmarks/`, warnings as errors: in a process of its own, or in that of the tests.

python -m tests.benchmarks.running NOTES SCRIPT ARGUMENTS    # with `checked_pictures`
"""

import csv
import io
import os
import re
import runpy
import subprocess
import sys
import warnings
from collections.abc import Callable, Iterator
from contextlib import chdir, contextmanager, nullcontext, redirect_stderr, redirect_stdout
from pathlib import Path
from typing import TYPE_CHECKING
from unittest import mock

from khepera_forage.cli.main import main
from khepera_forage.figures import save

if TYPE_CHECKING:
    from matplotlib.figure import Figure

ROOT = Path(__file__).parents[2]
_COMPILING = re.compile(r"^khepera_forage: compiling kernels.*\n", re.MULTILINE)
"""What the first script that needs kernels says."""


@contextmanager
def checked_pictures(notes: Path) -> Iterator[None]:
    """Check that each picture of a page can be read at the size at which pages show it, and explains its shading.

    Args:
        notes: File that gets a line for each picture: its name, a tab, and what is wrong with it, if anything.
    """

    def checked(figure: "Figure", path: Path) -> None:
        from tests.figure_checks import check_readable, check_shading_is_explained

        save(figure, path)  # before the check, which needs the layout of the file
        fault = ""
        try:
            check_readable(figure)
            check_shading_is_explained(figure)
        except AssertionError as error:
            fault = str(error).splitlines()[0]
        with notes.open("a", encoding="utf-8") as file:
            file.write(f"{path.name}\t{fault}\n")

    with mock.patch("khepera_forage.study.save", checked):
        yield


COMMANDS = {"learners": "compare", "decisions": "infer"}
"""Studies that are subcommands of `khepera-forage`, and no scripts."""


def command_of(script: str, *arguments: str) -> list[str]:
    """The command line of a script, or of a study that is a subcommand."""
    started = [str(ROOT / "benchmarks" / f"{script}.py")]
    if script in COMMANDS:
        started = ["-m", "khepera_forage.cli.main", COMMANDS[script]]
    return [sys.executable, "-W", "error", *started, *arguments]


def quick(script: str, out: Path, *arguments: str, notes: Path | None = None) -> str:
    """What a script prints with --quick, seed 1 and results in `out`, started as a user starts it.

    It must succeed without any error output, but for a notice that kernels are compiled. With a file for notes, its
    pictures are checked on the way (`checked_pictures`).
    """
    out.parent.mkdir(parents=True, exist_ok=True)
    command = command_of(script, "--quick", "--seed", "1", "--out", str(out), *arguments)
    # One process unless --jobs says otherwise: the other cores run other tests.
    environment = {**os.environ, "LOKY_MAX_CPU_COUNT": "1"}
    if notes is not None:
        command[3:3] = ["-m", "tests.benchmarks.running", str(notes)]
        # For this process and those that it starts.
        environment["PYTHONPATH"] = os.pathsep.join([str(ROOT), str(ROOT / "benchmarks")])
    # Not the repository's folder: a script must not depend on the folder it is started in.
    finished = subprocess.run(command, capture_output=True, text=True, cwd=out.parent, env=environment, timeout=900)
    assert finished.returncode == 0, finished.stderr
    assert _COMPILING.sub("", finished.stderr) == ""
    return finished.stdout


def quick_here(script: str, out: Path, *arguments: str, notes: Path | None = None) -> str:
    """As `quick`, but in this process, which has imported most modules already."""
    out.parent.mkdir(parents=True, exist_ok=True)
    pictures = nullcontext() if notes is None else checked_pictures(notes)
    with mock.patch.dict(os.environ, LOKY_MAX_CPU_COUNT="1"), chdir(out.parent), pictures:
        status, output, errors = _run_here(script, "--quick", "--seed", "1", "--out", str(out), *arguments)
    assert not status, errors
    assert _COMPILING.sub("", errors) == ""
    return output


def refused(script: str, *arguments: str) -> str:
    """The error output of a quick run that fails without a traceback."""
    status, _, errors = _run_here(script, "--quick", *arguments)
    assert status
    return errors


def _run_here(script: str, *arguments: str) -> tuple[object, str, str]:
    if script in COMMANDS:
        return run_here(main, "khepera-forage", COMMANDS[script], *arguments)
    return run_file(ROOT / "benchmarks" / f"{script}.py", *arguments)


def run_file(path: Path, *arguments: str) -> tuple[object, str, str]:
    """Run a script in this process, see `run_here`."""

    def program() -> None:
        runpy.run_path(str(path), run_name="__main__")

    return run_here(program, str(path), *arguments)


def run_here(program: Callable[[], object], *command: str) -> tuple[object, str, str]:
    """Run a program in this process, with warnings as errors.

    An error other than `SystemExit`, for which Python prints a traceback, is raised here.

    Returns:
        The exit status, what it printed, and its error output.
    """
    output, errors = io.StringIO(), io.StringIO()
    with (
        mock.patch("sys.argv", list(command)),
        redirect_stdout(output),
        redirect_stderr(errors),
        warnings.catch_warnings(action="error"),
    ):
        try:
            status = program()
        except SystemExit as end:
            status = end.code
    if isinstance(status, str):  # which Python prints at the end
        errors.write(f"{status}\n")
        status = 1
    return status, output.getvalue(), errors.getvalue()


def read(path: Path) -> list[dict[str, str]]:
    """The rows of a CSV file with a heading."""
    with path.open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def is_picture(path: Path) -> bool:
    """Whether the file is a PNG of some size."""
    data = path.read_bytes()
    return data.startswith(b"\x89PNG\r\n\x1a\n") and len(data) > 10_000


if __name__ == "__main__":
    _, notes, script, *arguments = sys.argv
    sys.argv = [script, *arguments]
    sys.path[0] = str(Path(script).parent)
    with checked_pictures(Path(notes)):
        runpy.run_path(script, run_name="__main__")
