"""Settings of all tests."""

import fcntl
import gc
import os
import signal
import sys
from collections.abc import Generator
from importlib.util import find_spec
from pathlib import Path

import pytest
from hypothesis import settings
from xdist.remote import Producer
from xdist.scheduler import LoadScopeScheduling

# Waiting threads of OpenCV spin: a quarter of the processor time of all tests of pictures. Programs inherit this.
os.environ.setdefault("OPENCV_FOR_THREADS_NUM", "1")

# No random examples: a failure in the gate is one that can be seen at home. Hypothesis also takes constants from the
# modules that are loaded, so that a test alone may have other examples than with all others.
settings.register_profile("khepera_forage", derandomize=True, deadline=None)
settings.load_profile("khepera_forage")

# Tests use parts of the benchmarks.
sys.path.insert(0, str(Path(__file__).parents[1] / "benchmarks"))

# What needs torch is run by `make test-baselines`, which installs it.
collect_ignore = [] if find_spec("stable_baselines3") else ["baselines"]

# A suite that was started in the background may have been told to ignore what its tests send to robots' programs, and
# programs inherit that.
for number, usual in (
    (signal.SIGINT, signal.default_int_handler),
    (signal.SIGHUP, signal.SIG_DFL),
    (signal.SIGQUIT, signal.SIG_DFL),
):
    if signal.getsignal(number) == signal.SIG_IGN:
        signal.signal(number, usual)


SCRIPT_TESTS = "tests/benchmarks/test_scripts.py"
"""Each of its tests has a script as parameter."""
FIRST = (
    *(f"tests/benchmarks/test_{script}.py" for script in ("backends", "virtual_lab", "wire", "tracker", "lab_faults")),
    *("tests/lab/", "tests/robots/", "tests/vision/"),
)
"""What begins. Only the first compiles kernels, for more than a minute: what needs them comes after the others."""


def group_of(nodeid: str) -> str:
    """The file with whose tests a test runs."""
    file, _, test = nodeid.partition("::")
    script = test.partition("[")[2].removesuffix("]")
    if file == SCRIPT_TESTS and script:
        file = f"tests/benchmarks/test_{script}.py"
    return file


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Begin with the groups of `FIRST`; all other tests keep their order."""

    def place(item: pytest.Item) -> int:
        starts = map(group_of(item.nodeid).startswith, FIRST)
        return next((number for number, first in enumerate(starts) if first), len(FIRST))

    items.sort(key=place)


@pytest.hookimpl(wrapper=True)
def pytest_collection(session: pytest.Session) -> Generator[None, object, object]:
    """Let one process collect before the others, which then find all imported modules compiled.

    On a fresh machine each process would compile them: two thirds of the time of a collection.
    """
    if not hasattr(session.config, "workerinput"):  # there is only this process
        return (yield)
    with Path(__file__).open() as lock:
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            fcntl.flock(lock, fcntl.LOCK_SH)
            fcntl.flock(lock, fcntl.LOCK_UN)
        return (yield)


def pytest_collection_finish(session: pytest.Session) -> None:
    """Look for unreachable objects less often, and never among modules and tests, which stay until the end.

    Python would search these millions of objects again and again: a twentieth of the time of all tests.
    """
    gc.collect()
    gc.freeze()
    gc.set_threshold(20_000, 10, 20)


class FileScheduling(LoadScopeScheduling):  # type: ignore[misc] # pytest-xdist is untyped
    """Runs the tests of a file in one process, and all tests of a benchmark script.

    A file's tests share fixtures, and a script's tests share a run, for which they would otherwise wait in several
    processes.
    """

    def _split_scope(self, nodeid: str) -> str:
        return group_of(nodeid)


@pytest.hookimpl(optionalhook=True)  # there is no such hook with -p no:xdist
def pytest_xdist_make_scheduler(config: pytest.Config, log: Producer) -> FileScheduling:
    """The distribution of tests to processes."""
    return FileScheduling(config, log)
