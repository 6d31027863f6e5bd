"""A counter that all threads share: how they divide among them what there is to do."""

from typing import Any

import numpy as np
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic
from numpy.typing import NDArray

from khepera_forage.compilation.decorators import stand_in


def take(counter: NDArray[np.int64]) -> int:
    """How often this counter was asked before, by all threads together; each answer is given once.

    Args:
        counter: One number, 0 at first.
    """
    before = int(counter[0])
    counter[0] = before + 1
    return before


@intrinsic
def _add_one(typing_context: Any, counter: Any) -> Any:
    """Compiled: one indivisible addition, which numba has for graphics cards alone."""

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        array = context.make_array(signature.args[0])(context, builder, arguments[0])
        return builder.atomic_rmw("add", array.data, cgutils.intp_t(1), "monotonic")

    return types.int64(counter), generate


@stand_in(take)
def _take(counter: NDArray[np.int64]) -> int:
    return _add_one(counter)  # type: ignore[call-arg]
