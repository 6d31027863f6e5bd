"""Writing files: errors name the file, and a file that is replaced is there until the new one is complete."""

import errno
import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from io import FileIO
from pathlib import Path
from types import TracebackType


class NamingFile:
    """A block whose errors of the operating system name a file, as that of a full disk does not.

    Args:
        path: The file that the block writes.
    """

    def __init__(self, path: str | os.PathLike[str]) -> None:
        self._path = Path(path)

    def __enter__(self) -> None:
        pass

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if isinstance(error, OSError) and error.errno is not None and error.filename is None:
            raise OSError(error.errno, error.strerror, str(self._path)) from error


def write_all(file: FileIO, data: bytes, path: Path) -> None:
    """Write all bytes at the end of a file or, after an error, none, so that the file ends with a complete line.

    A pipe or a device keeps what it has taken.

    Args:
        file: The file, without a buffer.
        data: Whole lines.
        path: Its path, for the error.

    Raises:
        OSError: The bytes cannot be written. The error names the file.
    """
    end: int | None = None
    with suppress(OSError):
        end = file.tell()
    try:
        with NamingFile(path):
            if file.write(data) != len(data):  # what is left of a full disk
                raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
    except BaseException:
        if end is not None:
            with suppress(OSError):
                file.truncate(end)
                file.seek(end)
        raise


@contextmanager
def replacing(path: Path) -> Iterator[Path]:
    """A file beside another that takes its place at the end of the block; after an error the other one is unchanged.

    Args:
        path: The file to be written or replaced; its folder must exist.

    Yields:
        The path to write to, with the same ending.
    """
    partial = path.with_name(f".{path.stem}.{os.getpid()}.part{path.suffix}")
    try:
        with NamingFile(path):
            yield partial
            os.replace(partial, path)
    finally:
        partial.unlink(missing_ok=True)
