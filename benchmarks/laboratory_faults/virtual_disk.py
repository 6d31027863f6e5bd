"""A disk that fails below Python: the operating system rejects what the process writes to its open files."""

import os
import resource
import signal
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

_OPEN_FILES = Path("/proc/self/fd")
_FULL = "/dev/full"
Restore = Callable[[], None]


def fill_up(path: Path) -> Restore:
    """Every write to an open file fails: no space left (ENOSPC)."""
    full = os.open(_FULL, os.O_WRONLY)
    return _redirected(path, full)


def break_down(path: Path) -> Restore:
    """Every write to an open file fails: input/output error (EIO)."""
    master, slave = os.openpty()
    os.close(master)
    return _redirected(path, slave)


def limit(path: Path, more: int) -> Restore:
    """The file takes a few more bytes, so that a line is cut in two; then it is too large (EFBIG).

    Args:
        path: An open file.
        more: Number of bytes.
    """
    # Python ignores the signal already; a process that resets it would end.
    signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    usual, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (path.stat().st_size + more, hard))
    return lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (usual, hard))


def unmount(folder: Path) -> Restore:
    """The folder is gone; files that are open stay open."""
    away = folder.with_name(f"{folder.name}.away")
    folder.rename(away)

    def mount() -> None:
        away.replace(folder)

    return mount


def _redirected(path: Path, target: int) -> Restore:
    """Let the open descriptors of a file refer to another one, which is closed by the returned function."""
    wanted = os.fstat(target)
    # All are found before any is copied: a copy may get the number of the descriptor of the listing.
    kept = [(descriptor, os.dup(descriptor)) for descriptor in _descriptors(path)]
    for descriptor, _ in kept:
        os.dup2(target, descriptor)

    def restore() -> None:
        for descriptor, original in kept:
            try:
                now = os.fstat(descriptor)
            except OSError:
                now = None
            # A closed descriptor may have another file by now.
            if now is not None and (now.st_dev, now.st_ino) == (wanted.st_dev, wanted.st_ino):
                os.dup2(original, descriptor)
            os.close(original)
        os.close(target)

    return restore


def _descriptors(path: Path) -> list[int]:
    """The open descriptors of a file."""
    found = []
    for name in os.listdir(_OPEN_FILES):
        with suppress(OSError):  # the descriptor of the listing itself
            if os.readlink(_OPEN_FILES / name) == str(path):
                found.append(int(name))
    return found
