"""What compiling does beside compiling."""

import gc
from collections.abc import Callable
from typing import Any

import numba
import numpy as np
import pytest
from numba.core import event

from khepera_forage.compilation.decorators import kernel
from khepera_forage.sim.compiled.numbers import upper


class _Thresholds(event.Listener):
    """The collector's thresholds when something begins to be compiled."""

    def __init__(self) -> None:
        self.seen: list[tuple[int, int, int]] = []

    def on_start(self, event: Any) -> None:
        self.seen.append(gc.get_threshold())

    def on_end(self, event: Any) -> None:
        pass


def _while_compiling(compiled: Callable[..., Any], argument: Any) -> set[tuple[int, int, int]]:
    watching = _Thresholds()
    with event.install_listener("numba:compile", watching):
        compiled(argument)
    return set(watching.seen)


def test_python_collects_seldom_while_a_kernel_compiles_and_as_usual_afterwards() -> None:
    usual = gc.get_threshold()
    (meanwhile,) = _while_compiling(kernel(upper), np.uint64(1))
    assert meanwhile[0] > usual[0]
    assert gc.get_threshold() == usual
    assert _while_compiling(numba.njit(lambda x: x + 1.0), 1.0) == {usual}


def test_a_kernel_can_make_no_array() -> None:
    def makes_one(n: int) -> float:
        return float(np.zeros(n)[0])

    with pytest.raises(numba.core.errors.NumbaError):
        kernel(makes_one)(3)
