"""A counter from which several threads take the numbers of pieces of work."""

from typing import Any

import numpy as np
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic
from numpy.typing import NDArray

from khepera_forage.compilation.decorators import stand_in


def take(counter: NDArray[np.int64]) -> int:
    """The next number; each number is given once to one thread.

    Args:
        counter: One number, 0 at first.
    """
    before = int(counter[0])
    counter[0] = before + 1
    return before


@intrinsic
def _add_one(typing_context: Any, counter: Any) -> Any:
    """Compiled: one atomic addition, which numba offers for graphics cards only."""

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        array = context.make_array(signature.args[0])(context, builder, arguments[0])
        return builder.atomic_rmw("add", array.data, cgutils.intp_t(1), "monotonic")

    return types.int64(counter), generate


@stand_in(take)
def _take(counter: NDArray[np.int64]) -> int:
    return _add_one(counter)  # type: ignore[call-arg]
