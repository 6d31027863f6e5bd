"""Machine code that entries keep on disk: found again, replaced when it is out of date, never needed.

Most tests run programs with a throw-away package that has the name and the compiling module of the real one.
"""

import os
import re
import shutil
import subprocess
import sys
import time
from multiprocessing import get_context
from pathlib import Path

import numba
import pytest

from khepera_forage import compilation, extras
from khepera_forage.compilation import share_out

BEFORE = """
import sys, numpy as np, numba
from numba.core import event

class Compiled(event.Listener):
    names = []
    def on_start(self, event):
        self.names.append(event.data["dispatcher"].py_func.__name__)
    def on_end(self, event):
        pass

event.register("numba:compile", Compiled())

from khepera_forage import compilation
compilation._SLOW = 1e9  # on a busy machine every compilation is a long one
"""
KERNEL = """
import numpy as np
from khepera_forage.compilation import entry, rule
from khepera_forage.sim.rules import double, first

@entry
def add(numbers, amount):
    for i in range(numbers.shape[0]):
        numbers[i] += double(amount)
    if amount < 0:
        raise ValueError("a negative amount")

@entry
def left(points):
    return first(points[0], 3) + first(points[1], 3)

@entry
def right(points):
    return first(points[0], 3) + first(points[1], 3)

LEFT = np.array([(1.0, 100.0)] * 2, [("x", "f8"), ("y", "f8")])
RIGHT = np.array([(100.0, 1.0)] * 2, [("y", "f8"), ("x", "f8")])
"""
LONG = """
        total += np.sin(point.x * i) + np.exp(-point.x * i) * np.cos(total) + np.tan(point.x + i)"""
RULES = f"""
import numpy as np
from khepera_forage.compilation import rule

@rule
def double(amount):
    return 2 * amount

@rule
def first(point, rounds):
    total = 0.0
    for i in range(rounds):  # too long to become part of the caller on its own account{12 * LONG}
    return point.x + 1e-30 * total
"""
ADD = """
from khepera_forage.sim.kernel import add
numbers = np.zeros(2)
add(numbers, 1.5)
print(numbers[0], "add" in Compiled.names)
"""
COMPILED, LOADED = "3.0 True\n", "3.0 False\n"
NOT_KEPT = "khepera_forage: machine code on disk cannot be used, .*\n"


class Package:
    """A throw-away package, and the environment of the programs that use it."""

    def __init__(self, folder: Path) -> None:
        self.cache = folder / "cache"
        self.sources = folder / "package" / "khepera_forage"
        (self.sources / "sim").mkdir(parents=True)
        for module in (compilation, extras):
            shutil.copy(str(module.__file__), self.sources)
        for name, text in (("__init__", ""), ("sim/__init__", ""), ("sim/kernel", KERNEL), ("sim/rules", RULES)):
            (self.sources / f"{name}.py").write_text(text)
        path = os.pathsep.join([str(self.sources.parent), os.environ.get("PYTHONPATH", "")])
        self.environment = {k: v for k, v in os.environ.items() if k != "NUMBA_CACHE_DIR"}
        self.environment |= {"PYTHONPATH": path, "XDG_CACHE_HOME": str(self.cache)}

    def run(self, code: str, **environment: str | None) -> tuple[str, str]:
        """What a program writes to its two streams; a variable that is None does not exist."""
        values = {k: v for k, v in {**self.environment, **environment}.items() if v is not None}
        done = subprocess.run(
            [sys.executable, "-W", "ignore", "-c", BEFORE + code],
            cwd=self.sources.parent.parent,
            env=values,
            capture_output=True,
            text=True,
        )
        assert done.returncode == 0, done.stderr
        return done.stdout, done.stderr

    def files(self, pattern: str) -> list[Path]:
        return sorted(self.cache.rglob(pattern))


@pytest.fixture
def package(tmp_path: Path) -> Package:
    return Package(tmp_path)


def test_machine_code_is_kept_for_other_processes_until_a_rule_changes(package: Package) -> None:
    output, announced = package.run("compilation._SLOW = 0.02\n" + ADD)
    assert output == COMPILED
    assert announced == "khepera_forage: compiling kernels, once for this version: about half a minute ...\n"
    assert package.run(ADD) == (LOADED, "")
    assert [path.suffix for path in package.files("*.nb?")] == [".nbc", ".nbi"]
    assert not list(package.sources.rglob("*.nb?"))
    assert package.run(ADD, NUMBA_DISABLE_JIT="1") == (LOADED, ""), "also where numba is switched off"
    # Python itself overlooks a change within a second that keeps the size of a file.
    (package.sources / "sim" / "rules.py").write_text(RULES.replace("2 * amount", "4 * amount  # no longer 2"))
    assert package.run(ADD) == ("6.0 True\n", "")


def test_folder_of_numba_comes_first_and_loses_machine_code_of_other_sources_that_was_long_unused(
    package: Package, tmp_path: Path
) -> None:
    names = ("khepera_forage-" + "0" * 16, "khepera_forage-" + "1" * 16, "khepera_forage-notes")
    old, used, foreign = (tmp_path / "of numba" / name for name in names)
    for folder in (old, used, foreign):
        (folder / "sim").mkdir(parents=True)
        (folder / "sim" / "file").touch()
    month = time.time() - 31 * 24 * 3600
    for folder in (old, foreign):
        os.utime(folder, (month, month))
    assert package.run(ADD, NUMBA_CACHE_DIR=str(tmp_path / "of numba"))[0] == COMPILED
    assert len(list((tmp_path / "of numba").rglob("*.nb?"))) == 2
    assert not package.cache.exists()
    assert [folder.exists() for folder in (old, used, foreign)] == [False, True, True]


USE = """
from khepera_forage.sim.kernel import LEFT, RIGHT, left, right
for function, points in {calls}:
    print(function(points), function.__name__ in Compiled.names)
"""


def test_functions_of_two_processes_are_not_mixed_up(package: Package) -> None:
    """Without `forceinline`, `right` would call what `first` became for `left`, and return 200."""
    for calls in ("[(left, LEFT)]", "[(right, RIGHT)]"):
        package.run(USE.format(calls=calls))
    both = package.run(USE.format(calls="[(left, LEFT), (right, RIGHT)]"))  # which no process has compiled together
    assert both == ("2.0 False\n2.0 False\n", "")


def test_damaged_files_are_replaced(package: Package) -> None:
    package.run(ADD)
    for suffix, part in (("nbi", 0.0), ("nbc", 0.5)):
        (file,) = package.files(f"*.{suffix}")
        whole = file.read_bytes()
        file.write_bytes(whole[: int(part * len(whole))])
        output, error = package.run(ADD)
        assert output == COMPILED
        assert re.fullmatch(NOT_KEPT, error)
        assert package.files(f"*.{suffix}")[0].stat().st_size == pytest.approx(len(whole), rel=0.1)


@pytest.mark.parametrize(
    ("before", "environment", "said"),
    [
        ("sys.stderr = None; compilation._SLOW = 0.02\n", {"NUMBA_CACHE_DIR": "/dev/null/x"}, ""),
        ("import os.path; os.path.expanduser = str\n", {"XDG_CACHE_HOME": None, "HOME": None}, NOT_KEPT),
        ("import resource; resource.setrlimit(resource.RLIMIT_FSIZE, (200, 200))\n", {}, NOT_KEPT),
    ],
    ids=["nothing to say it to", "no home folder", "full disk"],
)
def test_without_a_place_for_files_code_is_compiled_in_memory(
    package: Package, before: str, environment: dict[str, str | None], said: str
) -> None:
    output, error = package.run(before + ADD, **environment)
    assert output == COMPILED
    assert re.fullmatch(said, error)
    assert not list(package.sources.parent.parent.rglob("*.nb?"))


def test_threads_may_compile_at_the_same_time_also_in_a_deleted_folder(package: Package) -> None:
    code = """
import os, tempfile
from concurrent.futures import ThreadPoolExecutor
os.chdir(tempfile.mkdtemp())
os.rmdir(os.getcwd())
from khepera_forage.sim.kernel import add, left, LEFT
numbers = np.zeros(3)
with ThreadPoolExecutor(6) as pool:
    calls = [pool.submit(add, numbers[i:i + 1], 1.0) for i in range(3)]
    print([call.result() for call in [pool.submit(left, LEFT) for _ in range(3)]])
    assert [call.result() for call in calls] == [None] * 3
print(numbers, Compiled.names.count("add"), Compiled.names.count("left"))
"""
    assert package.run(code) == ("[2.0, 2.0, 2.0]\n[2. 2. 2.] 1 1\n", "")


@pytest.mark.parametrize(("count", "threads", "parts"), [(1000, 1, 1), (1000, 2, 2), (127, 2, 1), (0, 2, 1)])
def test_ranges_are_equal_cover_everything_and_raise_their_errors(
    monkeypatch: pytest.MonkeyPatch, count: int, threads: int, parts: int
) -> None:
    """Also in a forked process, which has none of the threads."""
    monkeypatch.setattr(numba, "get_num_threads", lambda: threads)

    def check() -> None:
        ranges: list[tuple[int, int]] = []
        share_out(lambda first, last: ranges.append((first, last)), count)
        assert sorted(ranges) == [(count * part // parts, count * (part + 1) // parts) for part in range(parts)]
        for bad, _ in ranges:
            with pytest.raises(ZeroDivisionError):
                share_out(lambda first, last, bad=bad: 1 // (first - bad), count)

    check()
    process = get_context("fork").Process(target=check)
    process.start()
    process.join()
    assert process.exitcode == 0
