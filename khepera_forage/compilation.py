"""Compilation with numba (extra `fast`): what Python calls, what compiled code calls, and threads.

`entry` compiles what Python calls and keeps the machine code in the user's cache folder; `rule` marks what entries
call. Kept machine code is a convenience: whatever goes wrong with it, an entry is compiled in memory.

Numba's own cache leaves two things to its user. It compares the source file of the entry only, so the name of the
folder is a checksum of all sources. And in the names of compiled functions it numbers record types, in the order in
which a process first uses them. So machine code of two processes may have one name for different functions, and a
process that loads both would call the wrong one. Here rules become part of the entries, and leave no names.
"""

import functools
import hashlib
import itertools
import os
import shutil
import sys
import tempfile
import threading
import time
import traceback
from collections import deque
from collections.abc import Callable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor, wait
from contextlib import contextmanager, suppress
from pathlib import Path
from types import FunctionType, ModuleType
from typing import Any, TypeVar, cast

from khepera_forage.extras import require

require("the backend 'compiled'", "fast")

import llvmlite.binding  # type: ignore[import-untyped] # noqa: E402 (after the check)
import numba  # noqa: E402
from numba.core.errors import NumbaError  # noqa: E402
from numba.extending import overload as overload  # noqa: E402
from numba.extending import register_jitable  # noqa: E402

_F = TypeVar("_F", bound=Callable[..., Any])
_COMPILED = ("geometry", "robots", "vision", "task", "sim", "envs", "policies", "rollouts")
"""Folders with functions that are compiled; so are some of the top-level modules."""
_UNUSED = 30 * 24 * 3600.0
"""Seconds without use after which machine code of other sources is removed."""
_SLOW = 2.0
"""Seconds of compilation after which the user learns what takes so long."""
_config: Any = numba.config
_options: Any = {"nogil": True, "error_model": "numpy", "_nrt": False}
"""References to arrays are not counted, which would take a quarter of a step. So compiled code can make no arrays: it
gets them as arguments. (Numba uses `_nrt` itself, but does not document it.)"""
_lock = threading.RLock()


def rule(function: _F) -> _F:
    """A function of a module (not a closure) that entries may call; Python calls the plain function.

    It is compiled into its callers.
    """
    inside = {"forceinline": True, "no_cpython_wrapper": True, "no_cfunc_wrapper": True}
    register_jitable(error_model="numpy", _nrt=False, **inside)(function)
    return function


def register(*modules: ModuleType) -> None:
    """Make every function of these modules a `rule`."""
    for module in modules:
        for function in vars(module).values():
            if isinstance(function, FunctionType) and function.__module__ == module.__name__:
                rule(function)


def entry(function: _F) -> _F:
    """A function that Python calls with all its arguments by position, always with the same record types.

    It is compiled at its first call, and runs without Python's lock.
    """
    return cast(_F, _Entry(function))


class _Entry:
    """What `entry` makes of a function."""

    def __init__(self, function: Callable[..., Any]) -> None:
        functools.update_wrapper(self, function)
        self._function = function
        self._in_memory: Any = numba.njit(**_options)(function)
        self._dispatcher: Any = None

    def __call__(self, *arguments: Any) -> Any:
        if self._dispatcher is not None:
            try:
                return self._dispatcher(*arguments)
            except Exception as error:
                frames = traceback.walk_tb(error.__traceback__)  # compiled functions have none of numba's
                if not any(str(frame.f_globals.get("__name__")).startswith("numba.") for frame, _ in frames):
                    raise
        with _lock, _compiler():
            dispatcher = self._compiled(arguments)
        return dispatcher(*arguments)

    def _compiled(self, arguments: tuple[Any, ...]) -> Any:
        """A dispatcher with machine code for these arguments, or one whose call raises the caller's error."""
        try:
            types = tuple(map(numba.typeof, arguments))
        except ValueError:
            return self._in_memory
        kept = self._dispatcher or _keeping(self._function)
        first: Exception | None = None
        for dispatcher in (kept, kept, self._in_memory) if kept else (self._in_memory,):
            error = _compile(dispatcher, types)
            first = first or error
            if types in dispatcher.signatures:  # with an error: the machine code could not be written
                self._dispatcher = dispatcher
                if first:
                    _say_not_kept(first)
                return dispatcher
            if isinstance(error, NumbaError):
                return dispatcher
            if dispatcher.stats.cache_path:  # remove what cannot be loaded, and try again
                for path in Path(dispatcher.stats.cache_path).glob(f"*.{self._function.__qualname__}-*"):
                    with suppress(OSError):
                        path.unlink()
        return self._in_memory


def _compile(dispatcher: Any, types: tuple[Any, ...]) -> Exception | None:
    """Load or compile; the error, if there is one."""
    done = threading.Event()

    def notice() -> None:
        while not done.wait(_SLOW):
            if dispatcher.stats.cache_misses[types]:  # it is compiling, not loading
                once = ", once for this version" if dispatcher.stats.cache_path else ""
                _say(f"compiling kernels{once}: about half a minute ...")
                return

    with suppress(RuntimeError):  # no thread starts while the interpreter ends
        threading.Thread(target=notice, daemon=True).start()
    try:
        with _current_folder():
            dispatcher.compile(types)
    except Exception as error:
        return error
    finally:
        done.set()
    return None


@contextmanager
def _compiler() -> Iterator[None]:
    """Numba's compiler, also with NUMBA_DISABLE_JIT: in Python, elements of arrays have no fields by name.

    More optimisation than at level 1 makes nothing faster here, and takes a quarter longer.
    """
    disabled, level = _config.DISABLE_JIT, _config.OPT
    _config.DISABLE_JIT, _config.OPT = 0, type(level)(min(level, 1))
    try:
        yield
    finally:
        _config.DISABLE_JIT, _config.OPT = disabled, level


@contextmanager
def _current_folder() -> Iterator[None]:
    """Some current folder, without which numba cannot compile, where the one of the process was deleted."""
    try:
        os.getcwd()
    except FileNotFoundError:
        deleted = os.open(".", os.O_RDONLY)
        os.chdir(os.sep)
        try:
            yield
        finally:
            os.fchdir(deleted)
            os.close(deleted)
    else:
        yield


def _keeping(function: Callable[..., Any]) -> Any:
    """A dispatcher with files in the folder of these sources, or None where nothing can be kept."""
    try:
        folder, usual = _folder(), _config.CACHE_DIR
        _config.CACHE_DIR = str(folder)
        try:
            dispatcher: Any = numba.njit(cache=True, **_options)(function)
        finally:
            _config.CACHE_DIR = usual
        if folder not in Path(dispatcher.stats.cache_path).parents:
            raise OSError(f"numba does not use {folder}")
    except Exception as error:
        _say_not_kept(error)
        return None
    return dispatcher


@functools.cache
def _folder() -> Path:
    """The folder for machine code of these sources, this compiler and this processor; it can be written to."""
    if _config.CACHE_DIR:
        root = Path(_config.CACHE_DIR).absolute()
    else:
        from platformdirs import user_cache_dir

        root = Path(user_cache_dir("khepera_forage", appauthor=False))
        if not root.is_absolute():
            raise OSError("there is no home folder")
    package = Path(__file__).parent
    folders = (path for name in _COMPILED for path in (package / name).rglob("*.py"))
    sources = [path.read_bytes() for path in sorted([*package.glob("*.py"), *folders])]
    host = (numba.__version__, llvmlite.binding.get_host_cpu_name(), _config.OPT, _config.BOUNDSCHECK)
    key = _checksum(str(host).encode() + b"".join(sources))
    folder = root / f"khepera_forage-{key}"
    folder.mkdir(parents=True, exist_ok=True)
    tempfile.TemporaryFile(dir=folder).close()
    os.utime(folder)
    for other in root.glob("khepera_forage-" + "[0-9a-f]" * len(key)):
        with suppress(OSError):
            if time.time() - other.stat().st_mtime > _UNUSED:
                shutil.rmtree(other, ignore_errors=True)
    return folder


def _checksum(data: bytes) -> str:
    return hashlib.sha256(data).hexdigest()[:16]


_said: list[str] = []


def _say_not_kept(error: Exception) -> None:
    if not _said:
        _said.append(f"machine code on disk cannot be used, compiling ({type(error).__name__}: {error})")
        _say(_said[0])


def _say(text: str) -> None:
    if sys.stderr is not None:
        with suppress(OSError, ValueError):
            print(f"khepera_forage: {text.partition(chr(10))[0]}", file=sys.stderr, flush=True)


def share_out(
    function: Callable[..., Any],
    count: int,
    *arguments: Any,
    scratch: Callable[[], tuple[Any, ...]] = tuple,
    least: int = 64,
) -> None:
    """Call `function(first, last, *arguments, *scratch())` for equal ranges that cover 0 to count, in numba's threads.

    The caller's thread takes part, and does everything where no thread can start, as at the end of the program.

    Args:
        function: An entry.
        count: Number of worlds, or of what else is shared out.
        *arguments: The other arguments, the same for all ranges.
        scratch: Makes further arguments for one range alone, such as a world to run its episodes in.
        least: The smallest range that is worth a thread: to wake one takes 25 µs.
    """
    if count < 2 * least:
        function(0, count, *arguments, *scratch())
        return
    parts = max(1, min(numba.get_num_threads(), count // least))
    ranges = deque(itertools.pairwise(count * part // parts for part in range(parts + 1)))

    def work() -> None:
        while True:
            try:
                first, last = ranges.popleft()
            except IndexError:
                return
            function(first, last, *arguments, *scratch())

    others: list[Future[None]] = []
    with suppress(RuntimeError):  # no thread starts while the interpreter ends
        for _ in range(parts - 1):
            others.append(_pool(os.getpid()).submit(work))
    try:
        work()
    finally:
        ranges.clear()
        others = [other for other in others if not other.cancel()]
        wait(others)
    for other in others:
        other.result()


@functools.cache
def _pool(process: int) -> ThreadPoolExecutor:
    """The threads of a process; a forked process needs its own."""
    return ThreadPoolExecutor(os.cpu_count(), thread_name_prefix=f"worlds of {process}")
