"""What a learner records (4.5): its state vector and the behaviour it heard, in each round with a behaviour."""

from collections.abc import Iterable, Iterator, Sequence
from os import PathLike
from pathlib import Path
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from khepera_forage.experience.text_format import (
    ExperienceError,
    ExperienceWriter,
    checked_header,
    checked_row,
    header_decisions_text,
    read,
)
from khepera_forage.files import replacing
from khepera_forage.task.decisions import DEFAULT_DECISIONS, Decisions, differences
from khepera_forage.task.states import Behaviour, StateVector


class Experience:
    """Experience vectors of one arena, in the order in which they were recorded.

    Args:
        vectors: State vectors: five integers each, in the order of `StateVector`; or an array with five columns.
        behaviours: Number of the behaviour heard with each vector; never WAIT, which means silence.
        arena: Name of the arena.
        seed: Of the training, if known.
        episodes: Number of training episodes; at least 1.
        decisions: Of the training, such as `env.decisions`; the defaults by default; None if experience of different
            decisions was joined.

    Attributes: as the arguments; a seed is None if it is unknown, or if experience of different seeds was joined.

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
        decisions: Decisions | None = DEFAULT_DECISIONS,
    ) -> None:
        self.arena, self.seed, self.episodes, self.decisions = checked_header(arena, seed, episodes, decisions)
        vectors, behaviours = list(vectors), list(behaviours)
        if len(vectors) != len(behaviours):
            raise ExperienceError(f"{len(vectors)} vectors with {len(behaviours)} behaviours; allowed: equal numbers")
        rows = []
        for number, (vector, behaviour) in enumerate(zip(vectors, behaviours, strict=True)):
            try:
                rows.append(checked_row(vector, behaviour))
            except ExperienceError as error:
                raise ExperienceError(f"experience vector {number}: {error}") from None
        self.vectors = tuple(vector for vector, _ in rows)
        self.behaviours = tuple(behaviour for _, behaviour in rows)

    @classmethod
    def load(
        cls,
        *paths: str | PathLike[str],
        arena: str | None = None,
        decisions: Decisions | None = None,
        allow_other_decisions: bool = False,
        recover: bool = False,
    ) -> Self:
        """Read files and join them in the given order: g1, g2 and g3 give the thesis's g123.

        Args:
            paths: One file or more, or folders of g1.csv, g2.csv, ...
            arena: The arena that all files must have; by default the arena of the first file.
            decisions: The decisions that all files must have, such as `env.decisions`; by default those of the first
                file.
            allow_other_decisions: Accept files of any decisions.
            recover: Read the complete rows of a file that a killed recording left without a closing line, with an
                `ExperienceWarning`. By default such a file is an error.

        Raises:
            ExperienceError: A file is not an experience file, is incomplete, or has another arena or other decisions.
            OSError: A file cannot be read.
            TypeError: There is no path.
        """
        if not paths:
            raise TypeError("no path to load; allowed: one or more")
        others = allow_other_decisions
        parts = load_each(paths, arena=arena, decisions=decisions, allow_other_decisions=others, recover=recover)
        return cls.join(parts, allow_other_decisions=others)

    @classmethod
    def join(cls, parts: Sequence["Experience"], *, allow_other_decisions: bool = False) -> Self:
        """Join experience of one arena in the given order.

        Args:
            parts: At least one.
            allow_other_decisions: Accept parts of different decisions; the joined experience then has none.

        Raises:
            ExperienceError: There is no part, or the arenas or the decisions differ.
        """
        if not parts:
            raise ExperienceError("no experience to join; allowed: at least one")
        first = parts[0]
        for part in parts[1:]:
            if part.arena != first.arena:
                raise ExperienceError(f"{part.arena!r} added to experience of {first.arena!r}; allowed: the same arena")
            if not allow_other_decisions:
                part.require_decisions(first.decisions)
        return cls(
            [vector for part in parts for vector in part.vectors],
            [behaviour for part in parts for behaviour in part.behaviours],
            first.arena,
            first.seed if all(part.seed == first.seed for part in parts) else None,
            sum(part.episodes for part in parts),
            first.decisions if all(part.decisions == first.decisions for part in parts) else None,
        )

    def require_decisions(self, decisions: Decisions | None) -> None:
        """Raise an ExperienceError unless this was recorded under these decisions, such as `env.decisions`."""
        _require_same(self.decisions, decisions, "")

    def save(self, path: str | PathLike[str]) -> None:
        """Write a file, and replace an existing one; an OSError leaves the existing file unchanged."""
        # Overwriting what a process that was killed may have left.
        about: dict[str, Any] = {"decisions": self.decisions, "overwrite": True}
        header = self.arena, self.seed, self.episodes
        with replacing(Path(path)) as partial, ExperienceWriter(partial, *header, **about) as writer:
            for row in self:
                writer.append(*row)

    def arrays(self) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """State vectors of shape (n, 5) and behaviours of shape (n,), as new arrays."""
        return np.array(self.vectors, np.int64).reshape(-1, 5), np.array(self.behaviours, np.int64)

    def __add__(self, other: "Experience") -> Self:
        if not isinstance(other, Experience):
            return NotImplemented
        return self.join((self, other))

    def __len__(self) -> int:
        return len(self.vectors)

    def __iter__(self) -> Iterator[tuple[StateVector, Behaviour]]:
        return zip(self.vectors, self.behaviours, strict=True)

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Experience):
            return NotImplemented
        return self.__dict__ == other.__dict__

    def __repr__(self) -> str:
        return (
            f"<Experience: {len(self)} vectors, arena={self.arena!r}, seed={self.seed}, episodes={self.episodes}, "
            f"decisions={header_decisions_text(self.decisions)!r}>"
        )


def load_each(
    paths: Iterable[str | PathLike[str]],
    *,
    arena: str | None = None,
    decisions: Decisions | None,
    allow_other_decisions: bool,
    recover: bool,
) -> list[Experience]:
    """The experience of each file; arguments and errors as of `Experience.load`."""
    parts: list[Experience] = []
    files = experience_files(paths)
    for path in files:
        header, rows = read(path, recover)
        expected = arena if arena is not None else parts[0].arena if parts else header.arena
        if header.arena != expected:
            source = "the argument" if arena is not None else f"that of {files[0]}"
            raise ExperienceError(f"{path}, line 3: arena is {header.arena!r}; allowed: {expected!r}, {source}")
        part = Experience([vector for vector, _ in rows], [heard for _, heard in rows], *header)
        if not allow_other_decisions and (decisions is not None or parts):
            wanted = decisions if decisions is not None else parts[0].decisions
            _require_same(part.decisions, wanted, f"{path}: ")
        parts.append(part)
    return parts


def experience_files(paths: Iterable[str | PathLike[str]]) -> list[Path]:
    """Experience files, and in place of a folder its g1.csv, g2.csv, ... in the order of their numbers.

    Raises:
        ExperienceError: A folder has none.
    """
    files: list[Path] = []
    for path in map(Path, paths):
        own = [file for file in path.glob("g*.csv") if file.stem[1:].isdecimal()] if path.is_dir() else [path]
        if not own:
            raise ExperienceError(f"{path} has no g1.csv; allowed: experience files, or a folder of them")
        files += sorted(own, key=lambda file: int(file.stem[1:])) if path.is_dir() else own
    return files


def _require_same(decisions: Decisions | None, other: Decisions | None, where: str) -> None:
    """Check that two sets of decisions are the same; None, mixed ones, equals nothing."""
    if decisions is not None and decisions == other:
        return
    if decisions is None or other is None:
        found = "experience of mixed decisions"
    else:
        found = f"recorded under other decisions: {differences(decisions, other)}"
    raise ExperienceError(
        f"{where}{found}; allowed: the same decisions, or any with allow_other_decisions=True (--allow-other-decisions)"
    )
