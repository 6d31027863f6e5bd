"""Errors of writing that name the file: the operating system does not say which one a full disk has cut short."""

import os
from pathlib import Path
from types import TracebackType


class NamingFile:
    """A block whose errors of the operating system name a file.

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
