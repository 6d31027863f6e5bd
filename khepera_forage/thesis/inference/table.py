"""The table of simulated sets, on disk: compressed arrays, one file a chunk, so that a killed run can be continued."""

import json
import os
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, NamedTuple
from zipfile import BadZipFile

import numpy as np
from numpy.typing import NDArray

from khepera_forage.thesis.inference.simulate import Simulated
from khepera_forage.thesis.inference.summary import NAMES, SLOPES

_SUFFIX = ".npz"


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
        laboratories: All decisions and sizes of noise, as JSON.
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
        np.array([_as_json(one) for one in simulated]),
        np.array([check.reason for check in checks]),
        np.array([check.delivered for check in checks]),
        np.array([check.fastest for check in checks]),
        np.array([check.complete for check in checks]),
        statistics,
    )


def write_chunk(folder: Path, number: int, contents: Contents, sets: Sets) -> None:
    """Write one chunk; a process that is killed meanwhile leaves no file of that name."""
    folder.mkdir(parents=True, exist_ok=True)
    part = folder / f"{_name(number)}.part"
    with part.open("wb") as file:
        arrays: dict[str, Any] = dict(sets._asdict())
        np.savez_compressed(file, contents=np.array(_text(contents)), **arrays)
    os.replace(part, folder / _name(number))


def read_chunk(folder: Path, number: int, contents: Contents) -> Sets | None:
    """One chunk, or None if the folder has none of this number.

    Raises:
        ValueError: The file is damaged, or was made with another prior, seed, number of experiments or version.
    """
    path = folder / _name(number)
    if not path.exists():
        return None
    try:
        with path.open("rb") as opened, np.load(opened, allow_pickle=False) as file:
            found, sets = str(file["contents"]), Sets(*(file[name] for name in Sets._fields))
    except (ValueError, KeyError, OSError, EOFError, BadZipFile) as error:
        raise ValueError(
            f"{path}: {error}; allowed: a chunk of simulated sets; delete the file, or give --out"
        ) from None
    if found != _text(contents):
        raise ValueError(
            f"{path}: made with {_difference(found, contents)}; allowed: the same as in this run, another folder "
            "(--out), or --fresh, which deletes it"
        )
    return sets


def delete_chunks(folder: Path) -> None:
    """Delete all chunks of a folder."""
    for path in folder.glob(f"sets_*{_SUFFIX}"):
        path.unlink()


def joined(parts: Sequence[Sets]) -> Sets:
    """Some chunks as one."""
    return Sets(*(np.concatenate(arrays) for arrays in zip(*parts, strict=True)))


def _name(number: int) -> str:
    return f"sets_{number:05d}{_SUFFIX}"


def _text(contents: Contents) -> str:
    return json.dumps(asdict(contents))


def _difference(found: str, contents: Contents) -> str:
    """Which of the contents differ, for people."""
    theirs, ours = json.loads(found), json.loads(_text(contents))
    return ", ".join(
        f"{name} {theirs[name]!r}" if type(value) is int else f"another {name}"
        for name, value in ours.items()
        if theirs[name] != value
    )


def _as_json(simulated: Simulated) -> str:
    decisions, noise = simulated.laboratory
    return json.dumps({"decisions": asdict(decisions), "noise": asdict(noise)})
