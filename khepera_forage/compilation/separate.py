"""Separate functions: compiled once for all entrances, which call them by their address.

Whatever else an entrance calls becomes a part of it and is compiled again with every entrance. A separate function also
shortens the first call: another process compiles it while this one compiles the entrance.
"""

import os
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import numba
from numba.core.typing.typeof import Purpose, typeof


def compile_for(entrance: Any, arguments: tuple[Any, ...]) -> None:
    """Compile an entrance for arguments of these types, or load it from disk; nothing is called."""
    entrance.compile(_types(arguments))


def address_of(entrance: Any, arguments: tuple[Any, ...]) -> int:
    """Address of the machine code of an entrance for arguments of these types, valid in this process.

    Args:
        entrance: It is compiled if it is not in memory or on disk.
        arguments: Examples. A record of an array stands for any of its type.
    """
    compile_for(entrance, arguments)
    result = entrance.overloads[_types(arguments)]
    address: int = result.library.get_pointer_to_function(result.fndesc.llvm_func_name)
    return address


def machine_code(entrance: Any, arguments: tuple[Any, ...]) -> Callable[..., Any]:
    """An entrance for arguments of these types, as a function of Python that does not look at types.

    Numba compares the types of all arguments at every call, which takes about 20 µs for the records of many worlds.
    Arguments of other types than these crash the process.

    Args:
        entrance: It is compiled if it is not in memory or on disk.
        arguments: Examples.
    """
    compile_for(entrance, arguments)
    function: Callable[..., Any] = entrance.overloads[_types(arguments)].entry_point
    return function


def is_on_disk(entrance: Any, arguments: tuple[Any, ...]) -> bool:
    """Whether the machine code of an entrance for arguments of these types is kept on disk."""
    return entrance._cache.load_overload(_types(arguments), entrance.targetctx) is not None


@contextmanager
def meanwhile(code: str) -> Iterator[None]:
    """Run Python code in another process; at the end, wait for it.

    Without a second processor, and in a program without an interpreter of its own, nothing is run. Nor is it known
    whether the code succeeds. So it must be something that this process can do itself if it finds it undone.

    Args:
        code: It finds the modules that this process finds.
    """
    if numba.config.NUMBA_NUM_THREADS < 2 or not sys.executable or getattr(sys, "frozen", False):  # type: ignore[attr-defined]
        yield
        return
    # The current folder, which `-P` leaves out, may contain another copy of the package.
    path = os.pathsep.join(folder or os.getcwd() for folder in sys.path)
    environment = {**os.environ, "PYTHONPATH": path}
    silent = subprocess.DEVNULL
    process = subprocess.Popen(
        [sys.executable, "-P", "-c", code], env=environment, stdin=silent, stdout=silent, stderr=silent
    )
    try:
        yield
        process.wait()
    finally:
        process.kill()
        process.wait()


def _types(arguments: tuple[Any, ...]) -> tuple[Any, ...]:
    return tuple(
        typeof(argument, Purpose.argument)  # type: ignore[no-untyped-call]
        for argument in arguments
    )
