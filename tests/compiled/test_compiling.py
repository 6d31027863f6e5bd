"""Compilation: numba's options, the collector, late optimisation and the key of the cache."""

import gc
import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numba
import numpy as np
import pytest
from numba.core import codegen, event

import khepera_forage
from khepera_forage.compilation import decorators, late_optimization
from khepera_forage.compilation.cache_key import sources_of
from khepera_forage.compilation.decorators import inline, kernel
from khepera_forage.sim.compiled.numbers import upper


class _Thresholds(event.Listener):
    """The collector's thresholds when the compilation of a function starts."""

    def __init__(self) -> None:
        self.seen: list[tuple[int, int, int]] = []

    def on_start(self, event: Any) -> None:
        self.seen.append(gc.get_threshold())

    def on_end(self, event: Any) -> None:
        pass


def compiled(function: Callable[..., Any]) -> Any:
    """A function compiled like an entrance, but not kept on disk."""
    return numba.njit(**decorators._OPTIONS)(function)


def thresholds_while_compiling(function: Callable[..., Any], argument: Any) -> set[tuple[int, int, int]]:
    listener = _Thresholds()
    with event.install_listener("numba:compile", listener):
        function(argument)
    return set(listener.seen)


def test_collector_runs_less_often_only_while_a_function_of_the_package_compiles() -> None:
    usual = gc.get_threshold()
    (meanwhile,) = thresholds_while_compiling(compiled(upper), np.uint64(1))
    assert meanwhile[0] > usual[0]
    assert gc.get_threshold() == usual
    foreign = numba.njit(lambda x: x + 1.0)
    foreign.py_func.__module__ = "somewhere"
    assert thresholds_while_compiling(foreign, 1.0) == {usual}


def test_compiled_functions_cannot_make_an_array() -> None:
    def makes_one(n: int) -> float:
        return float(np.zeros(n)[0])

    with pytest.raises(numba.core.errors.NumbaError):
        compiled(makes_one)(3)


def _square(x: float) -> float:
    return x * x


def _sum_of_squares(x: float, y: float) -> float:
    return _square(x) + _square(y)


def _distance(x: float, y: float) -> float:
    return float(_sum_of_squares(x, y) ** 0.5)


# Only functions of the package are optimised late.
for _function in (_square, _sum_of_squares, _distance):
    _function.__module__ = "khepera_forage.test"
inline(_square)
kernel(_sum_of_squares)


def finalized(monkeypatch: pytest.MonkeyPatch, call: Callable[[], Any]) -> tuple[Any, list[str]]:
    """The result of a call, and the libraries for which numba emits machine code meanwhile."""
    names: list[str] = []
    usual = codegen.CPUCodeLibrary._finalize_final_module

    def record(library: Any) -> None:
        names.append(library.name)
        usual(library)  # type: ignore[no-untyped-call]

    with monkeypatch.context() as patch:
        patch.setattr(codegen.CPUCodeLibrary, "_finalize_final_module", record)
        return call(), names


def test_inner_functions_have_no_machine_code_of_their_own(monkeypatch: pytest.MonkeyPatch) -> None:
    usual = codegen.CPUCodeLibrary._finalize_final_module
    result, names = finalized(monkeypatch, lambda: compiled(_distance)(3.0, 4.0))
    assert result == 5.0
    assert sum("_distance" in name for name in names) == 1
    assert not [name for name in names if "_square" in name]
    assert codegen.CPUCodeLibrary._finalize_final_module is usual


def test_only_the_entrance_has_a_name_in_its_machine_code() -> None:
    """Names of other functions depend on what else a process has compiled."""
    function = compiled(_distance)
    function(3.0, 4.0)
    (result,) = function.overloads.values()
    functions = [one for one in result.library._final_module.functions if not one.is_declaration]
    named = {one.name for one in functions if one.linkage.name != "internal"}
    assert named == {result.fndesc.llvm_func_name, result.fndesc.llvm_cpython_wrapper_name}


def test_without_its_internals_numba_compiles_as_usual(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(late_optimization, "_is_available", lambda: False)
    result, names = finalized(monkeypatch, lambda: compiled(_distance)(6, 8))
    assert result == 10.0
    assert [name for name in names if "_square" in name]


def test_numba_methods_are_restored_after_an_error() -> None:
    def fails(x: float) -> Any:
        return _sum_of_squares(x, "text")  # type: ignore[arg-type]

    fails.__module__ = "khepera_forage.test"
    usual = codegen.CPUCodeLibrary._optimize_final_module
    with pytest.raises(numba.core.errors.NumbaError):
        compiled(fails)(1.0)
    assert codegen.CPUCodeLibrary._optimize_final_module is usual


ENTRANCES = "khepera_forage.sim.compiled.stepping"


def test_cache_key_changes_with_every_source_of_an_entrance(tmp_path: Path) -> None:
    package = Path(khepera_forage.__file__).parent
    shutil.copytree(package, tmp_path / package.name, ignore=shutil.ignore_patterns("__pycache__"))

    def key() -> str:
        code = f"from khepera_forage.compilation.cache_key import cache_key; print(cache_key({ENTRANCES!r}))"
        run = subprocess.run(
            [sys.executable, "-c", code], cwd=tmp_path, capture_output=True, text=True, check=True
        )
        return run.stdout

    before = key()
    assert key() == before
    sources = {path.relative_to(package) for path in sources_of(ENTRANCES)}
    for name in ("vision/association.py", "sim/compiled/drive.py", "robots/khepera.py"):
        assert Path(name) in sources
        source = tmp_path / package.name / name
        source.write_text(source.read_text(encoding="utf-8") + "# changed\n", encoding="utf-8")
        after = key()
        assert after != before
        before = after
    other = tmp_path / package.name / "thesis/design.py"
    other.write_text(other.read_text(encoding="utf-8") + "# changed\n", encoding="utf-8")
    assert key() == before, "no kernel is made of that module"
