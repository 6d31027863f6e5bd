"""Parts of arrays, without the checks of a slice: in many arenas each round of each world takes several."""

from typing import Any

from numba import types
from numba.extending import intrinsic
from numba.np import arrayobj


@intrinsic
def _part_of(typing_context: Any, array: Any, first: Any, count: Any) -> Any:
    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        whole = arrayobj.make_array(array)(context, builder, arguments[0])  # type: ignore[no-untyped-call]
        part = arrayobj.make_array(array)(context, builder)  # type: ignore[no-untyped-call]
        arrayobj.populate_array(  # type: ignore[no-untyped-call]
            part,
            data=builder.gep(whole.data, [arguments[1]]),
            shape=[arguments[2]],
            strides=whole.strides,
            itemsize=whole.itemsize,
            meminfo=None,
        )
        return part._getvalue()

    return array(array, types.intp, types.intp), generate


part_of: Any = _part_of
"""Compiled: `array[first : first + count]` of a C-contiguous array with one dimension, `part_of(array, first, count)`.
Both ends must lie in the array, which the caller keeps alive."""
