"""What a learner records: its own state vectors, each with the behaviour it heard (section 4.5)."""

import os
from collections.abc import Iterator, Sequence
from os import PathLike
from pathlib import Path
from types import TracebackType
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from khepera_forage.experience_file import (
    ExperienceError,
    ExperienceWarning,
    checked_header,
    checked_row,
    closing,
    line_of,
    opening,
    read,
)
from khepera_forage.foraging.states import Behaviour, StateVector

__all__ = ["Experience", "ExperienceError", "ExperienceWarning", "ExperienceWriter"]


class Experience:
    """Experience vectors of one arena, in the order they were made.

    Args:
        vectors: State vectors, five integers each.
        behaviours: The behaviour heard with each; never WAIT, which is silence.
        arena: Name of the arena they were made in.
        seed: Of the training, if known.
        episodes: How many training episodes they are of.

    Raises:
        ExperienceError: Numbers that do not match, or something no learner can have recorded.
    """

    def __init__(
        self,
        vectors: Sequence[Sequence[Any]] | NDArray[np.integer[Any]],
        behaviours: Sequence[Any] | NDArray[np.integer[Any]],
        arena: str = "corridor",
        seed: int | None = None,
        episodes: int = 1,
    ) -> None:
        if len(vectors) != len(behaviours):
            raise ExperienceError(
                f"{len(vectors)} vectors with {len(behaviours)} behaviours; allowed: one each"
            )
        self._header = checked_header(arena, seed, episodes)
        self._rows = [checked_row(vector, heard) for vector, heard in zip(vectors, behaviours, strict=True)]

    @property
    def arena(self) -> str:
        """Name of the arena that the experience was made in."""
        return self._header.arena

    @property
    def seed(self) -> int | None:
        """Of the training; None for a combination, or if unknown."""
        return self._header.seed

    @property
    def episodes(self) -> int:
        """How many training episodes the experience is of."""
        return self._header.episodes

    @classmethod
    def load(
        cls, *paths: str | PathLike[str], arena: str | None = None, recover: bool = False
    ) -> "Experience":
        """Read one or more files and combine them, as the thesis' g135 is g1, g3 and g5.

        Args:
            *paths: At least one.
            arena: The only arena allowed; by default that of the first file.
            recover: Keep the whole rows of a file that a killed recording left, with an `ExperienceWarning`.

        Raises:
            ExperienceError: No path; a file that is no experience file, truncated, of a later version, or of
                another arena. The message names file and line.
            OSError: A file that cannot be read.
        """
        if not paths:
            raise ExperienceError("no experience files given; allowed: at least one")
        parts = []
        for path in paths:
            header, rows = read(path, recover)
            arena = header.arena if arena is None else arena
            if header.arena != arena:
                raise ExperienceError(
                    f"{path}:3: experience of arena {header.arena!r}; allowed here: {arena!r}"
                )
            vectors, behaviours = [row[0] for row in rows], [row[1] for row in rows]
            parts.append(cls(vectors, behaviours, header.arena, header.seed, header.episodes))
        whole = parts[0]
        for part in parts[1:]:
            whole = whole + part
        return whole

    def save(self, path: str | PathLike[str]) -> None:
        """Write a file, all of it or nothing; one that is there is replaced."""
        target = Path(path)
        text = opening(self._header) + "".join(line_of(*row) for row in self._rows) + closing(len(self._rows))
        beside = target.with_name(f".{target.name}.{os.getpid()}.part")
        try:
            with open(beside, "w", encoding="utf-8", newline="\n") as file:
                file.write(text)
                file.flush()
                os.fsync(file.fileno())
            os.replace(beside, target)
        finally:
            beside.unlink(missing_ok=True)

    def arrays(self) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """State vectors, shape (n, 5), and behaviours, shape (n,); fresh arrays."""
        vectors = np.array([row[0] for row in self._rows], np.int64).reshape(-1, 5)
        return vectors, np.array([row[1] for row in self._rows], np.int64)

    def __add__(self, other: "Experience") -> "Experience":
        if not isinstance(other, Experience):
            return NotImplemented
        if other.arena != self.arena:
            raise ExperienceError(f"experience of arena {other.arena!r} added to that of {self.arena!r}")
        rows = self._rows + other._rows
        vectors, behaviours = [row[0] for row in rows], [row[1] for row in rows]
        return Experience(vectors, behaviours, self.arena, None, self.episodes + other.episodes)

    def __len__(self) -> int:
        return len(self._rows)

    def __iter__(self) -> Iterator[tuple[StateVector, Behaviour]]:
        return iter(self._rows)

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Experience):
            return NotImplemented
        return (self._header, self._rows) == (other._header, other._rows)

    __hash__ = None  # type: ignore[assignment]  # mutable by its parts, compared by value

    def __repr__(self) -> str:
        return f"Experience({len(self)} vectors, arena={self.arena!r}, seed={self.seed}, episodes={self.episodes})"


class ExperienceWriter:
    """Writes experience as it happens: a process that is killed loses at most the line it was writing.

    A context manager. Left by an exception, the file has no closing line, which says that it is not complete.

    Args:
        path: A file that is not there yet.
        arena: Name of the arena.
        seed: Of the training, if known.
        episodes: How many training episodes will be in it.

    Raises:
        FileExistsError: There is such a file.
        ExperienceError: A header that cannot be written.
    """

    def __init__(
        self, path: str | PathLike[str], arena: str = "corridor", seed: int | None = None, episodes: int = 1
    ) -> None:
        header = checked_header(arena, seed, episodes)
        try:
            # Unbuffered: every line is one write to the operating system.
            self._file = open(path, "xb", buffering=0)  # noqa: SIM115  closed by close()
        except FileExistsError:
            raise FileExistsError(
                f"{path} exists; experience is never written over other experience"
            ) from None
        self._count = 0
        self._file.write(opening(header).encode())

    def append(self, vector: Sequence[Any], behaviour: Any) -> None:
        """Write one experience vector.

        Raises:
            ExperienceError: Something no learner can have recorded, silence among it.
            ValueError: The writer is closed.
        """
        row = checked_row(vector, behaviour)
        self._file.write(line_of(*row).encode())
        self._count += 1

    def close(self) -> None:
        """Write the closing line; a second call does nothing."""
        if not self._file.closed:
            self._file.write(closing(self._count).encode())
            self._file.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if kind is None:
            self.close()
        self._file.close()
