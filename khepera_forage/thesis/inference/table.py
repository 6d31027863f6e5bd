"""The table of simulated sets, on disk: compressed arrays, one file a chunk, so that a killed run can be continued."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from khepera_forage.thesis.inference.chunks import SUFFIX, joined, read_arrays, read_header, write_arrays
from khepera_forage.thesis.inference.laboratory_text import laboratory_text
from khepera_forage.thesis.inference.simulate import Simulated
from khepera_forage.thesis.inference.summary import NAMES, SLOPES

__all__ = [
    "Contents",
    "Sets",
    "contents_of",
    "delete_chunks",
    "first",
    "joined",
    "read_chunk",
    "sets_of",
    "write_chunk",
]
_WHAT = "a chunk of simulated sets"


@dataclass(frozen=True, slots=True)
class Contents:
    """What all chunks of a folder must have in common.

    Attributes:
        seed: Of all sets.
        experiments: Replications of the design under each admissible set.
        chunk: Sets in a chunk.
        prior: The prior as text.
        statistics: Names of the statistics.
    """

    seed: int
    experiments: int
    chunk: int
    prior: str
    statistics: tuple[str, ...] = (*NAMES, *SLOPES)


class Sets(NamedTuple):
    """Sets of decisions, one element or row each.

    Attributes:
        numbers: Of the sets, from 0.
        laboratories: What differs from the defaults, as JSON.
        reasons: Why a set is not admissible; empty if it is.
        delivered: Share of the food that the teacher brings home: corridor, rectangle.
        fastest: Steps of the teacher's fastest forage: corridor, rectangle.
        complete: Share of complete attempts at a training episode.
        statistics: Shape (sets, experiments, statistics), float32; not a number of sets that are not admissible.
    """

    numbers: NDArray[np.int64]
    laboratories: NDArray[np.str_]
    reasons: NDArray[np.str_]
    delivered: NDArray[np.float64]
    fastest: NDArray[np.float64]
    complete: NDArray[np.float64]
    statistics: NDArray[np.float32]


def sets_of(first: int, simulated: Sequence[Simulated], experiments: int) -> Sets:
    """Arrays of some sets, counted from `first`."""
    statistics = np.full((len(simulated), experiments, len(NAMES) + len(SLOPES)), np.nan, np.float32)
    for row, one in zip(statistics, simulated, strict=True):
        if one.statistics.size:
            row[:] = one.statistics
    checks = [one.check for one in simulated]
    return Sets(
        np.arange(first, first + len(simulated)),
        np.array([laboratory_text(one.laboratory) for one in simulated]),
        np.array([check.reason for check in checks]),
        np.array([check.delivered for check in checks]),
        np.array([check.fastest for check in checks]),
        np.array([check.complete for check in checks]),
        statistics,
    )


def write_chunk(folder: Path, number: int, contents: Contents, sets: Sets) -> None:
    """Write one chunk; a process that is killed meanwhile leaves no file of that name."""
    write_arrays(folder / _name(number), contents, sets._asdict())


def read_chunk(folder: Path, number: int, contents: Contents) -> Sets | None:
    """One chunk, or None if the folder has none of this number.

    Raises:
        ValueError: The file is damaged, or was made with another prior, seed, number of experiments or version.
    """
    path = folder / _name(number)
    if not path.exists():
        return None
    return Sets(*read_arrays(path, contents, Sets._fields, _WHAT))


def contents_of(folder: Path, prior: str) -> Contents:
    """What the chunks of a folder have in common, from the first of them.

    Args:
        folder: Where chunks are.
        prior: The prior as text.

    Raises:
        ValueError: There is no first chunk, it is damaged, or it was made with another prior.
    """
    path = folder / _name(0)
    if not path.exists():
        raise ValueError(f"{folder} has no {path.name}; allowed: a folder of simulated sets")
    known = read_header(path, _WHAT)
    if known.get("prior") != prior:
        raise ValueError(f"{path}: made with another prior; allowed: the prior of this version")
    return Contents(known["seed"], known["experiments"], known["chunk"], prior)


def first(sets: Sets, count: int) -> Sets:
    """The first sets of some."""
    arrays: tuple[Any, ...] = sets
    return Sets(*(array[:count] for array in arrays))


def delete_chunks(folder: Path) -> None:
    """Delete all chunks of a folder."""
    for path in folder.glob(f"sets_*{SUFFIX}"):
        path.unlink()


def _name(number: int) -> str:
    return f"sets_{number:05d}{SUFFIX}"
