"""What a learner records: its state vector beside the behaviour it heard (section 4.5), in memory and in files."""

import os
import uuid
from collections.abc import Iterable, Iterator, Sequence
from os import PathLike
from pathlib import Path
from types import TracebackType
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from khepera_forage.experience.reader import read
from khepera_forage.experience.text_format import (
    ExperienceError,
    ExperienceWarning,
    checked_header,
    checked_row,
    closing,
    line_of,
    opening,
)
from khepera_forage.task.states import Behaviour, StateVector

__all__ = ["Experience", "ExperienceError", "ExperienceWarning", "ExperienceWriter"]


class Experience:
    """Experience vectors of one arena, in the order in which they were recorded.

    Args:
        vectors: State vectors: five integers each, in the order of `StateVector`; also an array of five columns.
        behaviours: The behaviour heard with each, as its number; never WAIT, which is silence.
        arena: Name of the arena.
        seed: Of the training, if known.
        episodes: How many training episodes the vectors are of; at least 1.

    Attributes:
        vectors: The state vectors.
        behaviours: The behaviours.
        arena: As given.
        seed: As given; None where experience of different seeds was put together.
        episodes: As given; the sum where experience was put together.

    Raises:
        ExperienceError: Not as many behaviours as vectors, or a value out of range.
    """

    vectors: tuple[StateVector, ...]
    behaviours: tuple[Behaviour, ...]

    def __init__(
        self,
        vectors: Iterable[Sequence[int]] | NDArray[np.integer[Any]],
        behaviours: Iterable[int] | NDArray[np.integer[Any]],
        arena: str = "corridor",
        seed: int | None = None,
        episodes: int = 1,
    ) -> None:
        self.arena, self.seed, self.episodes = checked_header(arena, seed, episodes)
        vectors, behaviours = list(vectors), list(behaviours)
        if len(vectors) != len(behaviours):
            raise ExperienceError(
                f"{len(vectors)} vectors with {len(behaviours)} behaviours; allowed: as many"
            )
        rows = []
        for number, (vector, behaviour) in enumerate(zip(vectors, behaviours, strict=True)):
            try:
                rows.append(checked_row(vector, behaviour))
            except ExperienceError as error:
                raise ExperienceError(f"experience vector {number}: {error}") from None
        self.vectors = tuple(vector for vector, _ in rows)
        self.behaviours = tuple(behaviour for _, behaviour in rows)

    @classmethod
    def load(cls, *paths: str | PathLike[str], arena: str | None = None, recover: bool = False) -> Self:
        """Read files and put them together in the order given: g1, g2 and g3 are the thesis' g123.

        Args:
            paths: Of one file or more.
            arena: The arena that all must be of; by default that of the first.
            recover: Keep the whole rows of files that a killed recording left without closing line, with an
                `ExperienceWarning`. By default such a file is an error.

        Raises:
            ExperienceError: Not an experience file, an incomplete one, or one of another arena.
            OSError: A file cannot be read.
            TypeError: No path.
        """
        if not paths:
            raise TypeError("no path to load; allowed: one or more")
        whole = None
        for path in paths:
            (name, seed, episodes), rows = read(path, recover)
            wanted = arena if arena is not None else name if whole is None else whole.arena
            if name != wanted:
                source = "asked for" if arena is not None else f"that of {paths[0]}"
                raise ExperienceError(f"{path}, line 3: arena is {name!r}; allowed: {wanted!r}, {source}")
            part = cls([vector for vector, _ in rows], [heard for _, heard in rows], name, seed, episodes)
            whole = part if whole is None else whole + part
        assert whole is not None
        return whole

    def save(self, path: str | PathLike[str]) -> None:
        """Write a file, complete or not at all; one that is there is replaced.

        Raises:
            OSError: It cannot be written; what was there is untouched.
        """
        text = opening(checked_header(self.arena, self.seed, self.episodes))
        text += "".join(line_of(*row) for row in self) + closing(len(self))
        beside = Path(path).with_name(
            f".{uuid.uuid4().hex}.tmp"
        )  # the same file system, or replace could not be atomic
        try:
            with open(beside, "xb") as file:
                file.write(text.encode())
                file.flush()
                os.fsync(file.fileno())
            os.replace(beside, path)
        except BaseException:
            beside.unlink(missing_ok=True)
            raise

    def arrays(self) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """X of shape (n, 5) and y of shape (n,), as learners take them; fresh at every call."""
        return np.array(self.vectors, np.int64).reshape(-1, 5), np.array(self.behaviours, np.int64)

    def __add__(self, other: "Experience") -> Self:
        if not isinstance(other, Experience):
            return NotImplemented
        if other.arena != self.arena:
            raise ExperienceError(
                f"{other.arena!r} added to experience of {self.arena!r}; allowed: the same arena"
            )
        return type(self)(
            self.vectors + other.vectors,
            self.behaviours + other.behaviours,
            self.arena,
            self.seed if self.seed == other.seed else None,
            self.episodes + other.episodes,
        )

    def __len__(self) -> int:
        return len(self.vectors)

    def __iter__(self) -> Iterator[tuple[StateVector, Behaviour]]:
        return zip(self.vectors, self.behaviours, strict=True)

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Experience):
            return NotImplemented
        return self.__dict__ == other.__dict__

    def __repr__(self) -> str:
        return f"<Experience: {len(self)} vectors, arena={self.arena!r}, seed={self.seed}, episodes={self.episodes}>"


class ExperienceWriter:
    """Writes an experience file as the experience is made.

    Every vector is handed to the operating system before `append` returns: a killed process leaves all of them but
    for, at most, a cut last line. A file becomes complete with `close`. As a context manager it closes at the end
    of the block; an exception leaves the file incomplete (`Experience.load(..., recover=True)` reads it).

    Args:
        path: Of the file.
        arena: Name of the arena.
        seed: Of the training, if known.
        episodes: How many training episodes are recorded.
        overwrite: Whether a file that is there is replaced. By default it is an error.

    Attributes:
        path: As given.
        count: Experience vectors written so far.

    Raises:
        FileExistsError: There is a file at `path`.
        ExperienceError: A value that cannot be written.
    """

    def __init__(
        self,
        path: str | PathLike[str],
        arena: str,
        seed: int | None = None,
        episodes: int = 1,
        *,
        overwrite: bool = False,
    ) -> None:
        header = checked_header(arena, seed, episodes)
        self.path = Path(path)
        self.count = 0
        try:
            self._file = open(path, "wb" if overwrite else "xb")  # noqa: SIM115 - close() closes it
        except FileExistsError:
            raise FileExistsError(f"{path} exists; overwrite=True replaces it") from None
        self._write(opening(header))

    def append(self, vector: Sequence[int], behaviour: int) -> None:
        """Write one experience vector.

        Args:
            vector: What the learner perceived; see `StateVector`.
            behaviour: What it heard; never WAIT: in silence nothing is recorded.

        Raises:
            ExperienceError: A value out of range, or a closed writer. Nothing is written then.
        """
        if self._file.closed:
            raise ExperienceError(f"{self.path} is closed; allowed: append before close")
        self._write(line_of(*checked_row(vector, behaviour)))
        self.count += 1

    def close(self) -> None:
        """Write the closing line; a second call does nothing."""
        if self._file.closed:
            return
        with self._file:
            self._write(closing(self.count))
            os.fsync(self._file.fileno())

    def _write(self, text: str) -> None:
        self._file.write(text.encode())
        self._file.flush()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if kind is None:
            self.close()
        self._file.close()
