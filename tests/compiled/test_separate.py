"""Separate functions: called by their address, and compiled in another process meanwhile."""

import sys
from pathlib import Path
from typing import Any

import numba
import numpy as np
import pytest
from numpy.typing import NDArray

import khepera_forage
from khepera_forage.compilation.addresses import call_at
from khepera_forage.compilation.decorators import entrance
from khepera_forage.compilation.separate import address_of, compile_for, is_on_disk, machine_code, meanwhile
from khepera_forage.sim.compiled import stepping
from khepera_forage.sim.compiled.records import LANES

EXAMPLE = (np.zeros(3), 1.0)


@entrance
def add(numbers: NDArray[np.float64], amount: float) -> None:
    for i in range(numbers.shape[0]):
        numbers[i] += amount


@entrance
def call(address: int, numbers: NDArray[np.float64]) -> None:
    call_at(address, numbers, 2.0)


def test_function_is_called_by_its_address() -> None:
    numbers = np.arange(3.0)
    call(address_of(add, EXAMPLE), numbers)
    assert numbers.tolist() == [2.0, 3.0, 4.0]


def test_machine_code_does_what_the_entrance_does() -> None:
    numbers = np.arange(3.0)
    function = machine_code(add, EXAMPLE)
    assert EXAMPLE[0].tolist() == [0.0, 0.0, 0.0]
    function(numbers, 2.0)
    assert numbers.tolist() == [2.0, 3.0, 4.0]
    with pytest.raises(TypeError):
        function(numbers)


def test_compiling_for_examples_calls_nothing() -> None:
    numbers = np.zeros(3)
    compile_for(add, (numbers, 1.0))
    assert numbers.tolist() == [0.0, 0.0, 0.0]
    assert is_on_disk(add, (numbers, 1.0))
    assert not is_on_disk(add, (np.zeros((3, 3)), 1.0))


def test_other_process_has_ended_after_the_block(tmp_path: Path) -> None:
    file = tmp_path / "result"
    code = f"import time, khepera_forage; time.sleep(0.2); open({str(file)!r}, 'w').write('done')"
    with meanwhile(code):
        assert not file.exists()
    assert file.read_text() == "done"


def test_other_process_finds_the_modules_of_this_one(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """And not those of a copy of the package in the current folder."""
    copy, file = tmp_path / "khepera_forage", tmp_path / "result"
    copy.mkdir()
    (copy / "__init__.py").write_text("")
    monkeypatch.chdir(tmp_path)
    with meanwhile(f"import khepera_forage; open({str(file)!r}, 'w').write(khepera_forage.__file__)"):
        pass
    assert file.read_text() == khepera_forage.__file__


def test_other_process_ends_with_an_error_in_the_block(tmp_path: Path) -> None:
    file = tmp_path / "result"
    with (
        pytest.raises(RuntimeError),
        meanwhile(f"import time; time.sleep(60); open({str(file)!r}, 'w').write('done')"),
    ):
        raise RuntimeError
    assert not file.exists()


@pytest.mark.parametrize(
    ("owner", "name", "value"),
    [(numba.config, "NUMBA_NUM_THREADS", 1), (sys, "executable", ""), (sys, "frozen", True)],
)
def test_without_processor_or_interpreter_there_is_no_other_process(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, owner: Any, name: str, value: Any
) -> None:
    monkeypatch.setattr(owner, name, value, raising=False)
    file = tmp_path / "result"
    with meanwhile(f"open({str(file)!r}, 'w').write('done')"):
        pass
    assert not file.exists()


def test_bodies_are_compiled_in_another_process_while_the_caller_compiles(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    codes: list[str] = []

    def record(code: str) -> Any:
        codes.append(code)
        return meanwhile("")

    monkeypatch.setattr(stepping, "_addresses", {})
    monkeypatch.setattr(stepping, "is_on_disk", lambda *_: False)
    monkeypatch.setattr(stepping, "meanwhile", record)
    address = stepping.advance_address(LANES, add, *EXAMPLE)
    assert address == stepping.advance_address(LANES, add, *EXAMPLE)
    (code,) = codes
    compiled: list[tuple[int, bool]] = []
    monkeypatch.setattr(stepping, "compile_advance", lambda *kind: compiled.append(kind))
    exec(code)
    assert compiled == [(LANES, False)]
