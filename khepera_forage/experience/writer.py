"""Writing an experience file while the experience is recorded."""

import os
from collections.abc import Sequence
from os import PathLike
from pathlib import Path
from types import TracebackType
from typing import Self

from khepera_forage.experience.text_format import (
    ExperienceError,
    checked_header,
    checked_row,
    closing_line,
    header_text,
    row_text,
)
from khepera_forage.files import write_all
from khepera_forage.task.decisions import DEFAULT_DECISIONS, Decisions


class ExperienceWriter:
    """Writes an experience file, vector by vector.

    `append` passes each vector to the operating system before it returns, so that a killed process loses at most an
    incomplete last line. `close` writes the closing line of a complete file. As a context manager the writer closes the
    file at the end of the block; after an exception the file has no closing line, and only
    `Experience.load(..., recover=True)` reads it.

    Args:
        path: The file.
        arena: Name of the arena.
        seed: Of the training, if known.
        episodes: Number of training episodes.
        decisions: Of the training; the defaults by default.
        overwrite: Replace an existing file. By default an existing file is an error.

    Attributes:
        path: The file.
        count: Number of experience vectors written so far.

    Raises:
        FileExistsError: There is a file at `path`.
        ExperienceError: A value cannot be written.
    """

    def __init__(
        self,
        path: str | PathLike[str],
        arena: str,
        seed: int | None = None,
        episodes: int = 1,
        *,
        decisions: Decisions = DEFAULT_DECISIONS,
        overwrite: bool = False,
    ) -> None:
        header = checked_header(arena, seed, episodes, decisions)
        self.path = Path(path)
        self.count = 0
        try:
            # Without a buffer, whose rest `close` would write a second time after an error.
            self._file = open(path, "wb" if overwrite else "xb", buffering=0)  # noqa: SIM115 - closed by close()
        except FileExistsError:
            raise FileExistsError(f"{path} exists; overwrite=True replaces it") from None
        try:
            self._write(header_text(header))
        except OSError:
            self._file.close()
            if not overwrite:  # without a header, it would prevent the next recording at this path
                self.path.unlink(missing_ok=True)
            raise

    def append(self, vector: Sequence[int], behaviour: int) -> None:
        """Write one experience vector.

        Args:
            vector: The learner's state vector; see `StateVector`.
            behaviour: The behaviour that it heard; never WAIT, because nothing is recorded in silence.

        Raises:
            ExperienceError: A value is out of range, or the writer is closed. Nothing is written then.
        """
        if self._file.closed:
            raise ExperienceError(f"{self.path} is closed; allowed: append before close")
        self._write(row_text(*checked_row(vector, behaviour)))
        self.count += 1

    def close(self, complete: bool = True) -> None:
        """Close the file; a second call does nothing.

        Args:
            complete: Write the closing line, without which the file counts as incomplete.
        """
        if self._file.closed:
            return
        with self._file:
            if complete:
                self._write(closing_line(self.count))
                os.fsync(self._file.fileno())

    def _write(self, text: str) -> None:
        write_all(self._file, text.encode(), self.path)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close(complete=kind is None)
