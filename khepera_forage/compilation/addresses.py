"""Arrays and functions by their address, for kernels that are given many arrays at the price of one."""

from typing import Any

from numba import types
from numba.core import cgutils
from numba.extending import intrinsic
from numba.np import arrayobj


@intrinsic
def _array_at(typing_context: Any, address: Any, shape: Any, dtype: Any) -> Any:
    array_type = types.Array(dtype.dtype, len(shape), "C")

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        element = context.get_data_type(array_type.dtype)
        array = arrayobj.make_array(array_type)(context, builder)  # type: ignore[no-untyped-call]
        sizes = cgutils.unpack_tuple(builder, arguments[1])  # type: ignore[no-untyped-call]
        stride = itemsize = context.get_constant(types.intp, context.get_abi_sizeof(element))
        strides: list[Any] = []
        for size in reversed(sizes):
            strides.insert(0, stride)
            stride = builder.mul(stride, size)
        arrayobj.populate_array(  # type: ignore[no-untyped-call]
            array,
            data=builder.inttoptr(arguments[0], element.as_pointer()),
            shape=sizes,
            strides=strides,
            itemsize=itemsize,
            meminfo=None,
        )
        return array._getvalue()

    return array_type(types.int64, shape, dtype), generate


array_at: Any = _array_at
"""Compiled: the C-contiguous array at an address, `array_at(address, shape, dtype)`. The caller keeps it alive."""


@intrinsic
def _call_at(typing_context: Any, address: Any, first: Any, second: Any) -> Any:
    arguments = (first, second)

    def generate(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        function = context.call_conv.get_function_type(types.none, arguments)
        pointer = builder.inttoptr(values[0], function.as_pointer())
        context.call_conv.call_function(builder, pointer, types.none, arguments, values[1:])
        return context.get_dummy_value()

    return types.none(types.int64, *arguments), generate


call_at: Any = _call_at
"""Compiled: call the function of two arguments at an address, `call_at(address, first, second)`. It returns nothing."""
