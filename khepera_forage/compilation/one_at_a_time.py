"""One compilation for all processes: those that need the same machine code wait for the one that makes it."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

try:
    import fcntl
except ImportError:  # Windows: every process compiles for itself
    fcntl = None  # type: ignore[assignment]


def compile_one_at_a_time(dispatcher: Any) -> None:
    """Let only one process at a time compile a function whose machine code is kept on disk.

    The others find the machine code on disk afterwards.

    Args:
        dispatcher: A function compiled by numba with `cache=True`.
    """
    compile_now = dispatcher.compile

    def compile_or_load(signature: Any) -> Any:
        with _locked(Path(dispatcher._cache.cache_path) / f"{dispatcher.py_func.__qualname__}.lock"):
            return compile_now(signature)

    dispatcher.compile = compile_or_load


@contextmanager
def _locked(path: Path) -> Iterator[None]:
    """Hold a lock file; without one, where there is no lock or the folder cannot be written to."""
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        file = path.open("w")
    except OSError:
        yield
        return
    with file:
        if fcntl is not None:
            fcntl.flock(file, fcntl.LOCK_EX)
        yield
