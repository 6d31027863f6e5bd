"""Files: those of other tools can be read, errors name the file, and a replaced one stays until the new is complete."""

import codecs
import errno
import os
import shutil
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from io import FileIO
from pathlib import Path


def utf8(data: bytes) -> bytes:
    """The content of a text file in UTF-8, without the byte order mark of some editors.

    UTF-16 with such a mark, which `>` of PowerShell writes, is converted.
    """
    if data.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        data = data.decode("utf-16", errors="replace").encode()
    return data.removeprefix(codecs.BOM_UTF8)


def has_utf8_name(path: str | os.PathLike[str]) -> bool:
    """Whether OpenCV can open a file; with another name it crashes."""
    return str(path).encode(errors="ignore").decode() == str(path)


@contextmanager
def naming_file(path: str | os.PathLike[str], partial: Path | None = None) -> Iterator[None]:
    """A block whose errors of the operating system name a file, as that of a full disk does not.

    Args:
        path: The file that the block writes.
        partial: What the block writes in its place first; errors name `path` instead.
    """
    try:
        yield
    except OSError as error:
        if error.errno is None or str(error.filename) not in ("None", str(partial)):
            raise
        raise OSError(error.errno, error.strerror, str(path)) from error


def write_all(file: FileIO, data: bytes, path: Path) -> None:
    """Write whole lines at the end of a file without a buffer or, after an error, which names its path, nothing.

    A pipe or a device keeps what it has taken.
    """
    end: int | None = None
    with suppress(OSError):
        end = file.tell()
    try:
        with naming_file(path):
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

    A symbolic link stays, and its target is replaced. The new file has the mode of the other one.

    Args:
        path: The file to be written or replaced; its folder must exist.

    Yields:
        The path to write to, with the same ending.
    """
    target = Path(os.path.realpath(path))
    partial = target.with_name(f".{target.stem}.{os.getpid()}.part{path.suffix}")
    try:
        with naming_file(path, partial):
            yield partial
            with suppress(FileNotFoundError):
                shutil.copymode(target, partial)
            os.replace(partial, target)
    finally:
        with suppress(OSError):
            partial.unlink()
