"""What a learner records (4.5): its state vector and the behaviour it heard, in each round with a behaviour."""

import os
import uuid
from collections.abc import Iterable, Iterator, Sequence
from os import PathLike
from pathlib import Path
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from khepera_forage.experience.reader import read
from khepera_forage.experience.text_format import (
    ExperienceError,
    checked_header,
    checked_row,
    closing_line,
    header_text,
    row_text,
)
from khepera_forage.task.states import Behaviour, StateVector


class Experience:
    """Experience vectors of one arena, in the order in which they were recorded.

    Args:
        vectors: State vectors: five integers each, in the order of `StateVector`; or an array with five columns.
        behaviours: Number of the behaviour heard with each vector; never WAIT, which means silence.
        arena: Name of the arena.
        seed: Of the training, if known.
        episodes: Number of training episodes; at least 1.

    Attributes:
        vectors: The state vectors.
        behaviours: The behaviours.
        arena: Name of the arena.
        seed: Seed of the training; None if unknown or if experience of different seeds was joined.
        episodes: Number of training episodes.

    Raises:
        ExperienceError: The numbers of vectors and behaviours differ, or a value is out of range.
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
                f"{len(vectors)} vectors with {len(behaviours)} behaviours; allowed: equal numbers"
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
        """Read files and join them in the given order: g1, g2 and g3 give the thesis's g123.

        Args:
            paths: One file or more.
            arena: The arena that all files must have; by default the arena of the first file.
            recover: Read the complete rows of a file that a killed recording left without a closing line, with an
                `ExperienceWarning`. By default such a file is an error.

        Raises:
            ExperienceError: A file is not an experience file, is incomplete, or has another arena.
            OSError: A file cannot be read.
            TypeError: There is no path.
        """
        if not paths:
            raise TypeError("no path to load; allowed: one or more")
        joined = None
        for path in paths:
            (name, seed, episodes), rows = read(path, recover)
            expected = arena if arena is not None else name if joined is None else joined.arena
            if name != expected:
                source = "the argument" if arena is not None else f"that of {paths[0]}"
                raise ExperienceError(f"{path}, line 3: arena is {name!r}; allowed: {expected!r}, {source}")
            part = cls([vector for vector, _ in rows], [heard for _, heard in rows], name, seed, episodes)
            joined = part if joined is None else joined + part
        assert joined is not None
        return joined

    def save(self, path: str | PathLike[str]) -> None:
        """Write a file, and replace an existing one; an error leaves the existing file unchanged.

        Raises:
            OSError: The file cannot be written.
        """
        text = header_text(checked_header(self.arena, self.seed, self.episodes))
        text += "".join(row_text(*row) for row in self) + closing_line(len(self))
        # In the same folder, hence on the same file system: only there is replacing a file atomic.
        temporary = Path(path).with_name(f".{uuid.uuid4().hex}.tmp")
        try:
            with open(temporary, "xb") as file:
                file.write(text.encode())
                file.flush()
                os.fsync(file.fileno())
            os.replace(temporary, path)
        except BaseException:
            temporary.unlink(missing_ok=True)
            raise

    def arrays(self) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """State vectors of shape (n, 5) and behaviours of shape (n,), as new arrays."""
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
