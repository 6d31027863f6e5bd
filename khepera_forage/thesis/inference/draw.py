"""Sets of decisions from the prior: simulated in processes, in chunks that are kept on disk."""

import sys
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
from joblib import Parallel, delayed, effective_n_jobs
from numpy.typing import NDArray
from tqdm import tqdm

from khepera_forage.study import Arguments
from khepera_forage.thesis.inference.laboratory_text import laboratory_from_text
from khepera_forage.thesis.inference.parameters import Parameter, parameters_of
from khepera_forage.thesis.inference.prior import PRIOR, Laboratory
from khepera_forage.thesis.inference.simulate import simulate
from khepera_forage.thesis.inference.table import (
    Contents,
    Sets,
    contents_of,
    delete_chunks,
    first,
    joined,
    read_chunk,
    sets_of,
    write_chunk,
)

CHUNK, QUICK_CHUNK = 100, 4
"""Sets drawn in one unit of work."""
CHUNKS_A_PROCESS = 4
"""Chunks that a process simulates before it is asked whether the sets are enough."""


@dataclass(frozen=True)
class Drawn:
    """Sets in the order in which they were drawn.

    Attributes:
        sets: Up to the last admissible one that was wanted.
    """

    sets: Sets

    @cached_property
    def admissible(self) -> NDArray[np.intp]:
        """Places of the admissible sets."""
        return np.flatnonzero(self.sets.reasons == "")

    @cached_property
    def statistics(self) -> NDArray[np.float32]:
        """Of the admissible sets, shape (sets, experiments, statistics)."""
        return self.sets.statistics[self.admissible]

    @cached_property
    def laboratories(self) -> list[Laboratory]:
        """The admissible sets."""
        return [laboratory_from_text(text) for text in self.sets.laboratories[self.admissible].tolist()]

    @cached_property
    def parameters(self) -> list[Parameter]:
        """What was drawn, of the admissible sets."""
        return parameters_of(PRIOR, self.laboratories)


def draw(given: Arguments, wanted: int, experiments: int) -> Drawn:
    """Draw sets until as many as wanted are admissible.

    Raises:
        SystemExit: The folder holds sets of another run.
    """
    contents = Contents(given.seed, experiments, QUICK_CHUNK if given.quick else CHUNK, repr(PRIOR))
    if given.fresh:
        delete_chunks(given.out)
    parts: list[Sets] = []
    found = 0
    try:
        with tqdm(total=wanted, desc="admissible sets", disable=not sys.stderr.isatty()) as bar:
            for sets in chunks(given.out, contents, given.jobs):
                parts.append(sets)
                new = int((sets.reasons == "").sum())
                bar.update(min(new, wanted - found))
                found += new
                if found >= wanted:
                    break
    except ValueError as error:
        given.refuse(str(error))
    whole = joined(parts)
    last = int(np.flatnonzero(whole.reasons == "")[wanted - 1])
    return Drawn(first(whole, last + 1))


def kept(folder: Path) -> Drawn:
    """The sets that a folder holds.

    Raises:
        ValueError: It holds none, or sets of another prior or version.
    """
    contents = contents_of(folder, repr(PRIOR))
    parts: list[Sets] = []
    while (sets := read_chunk(folder, len(parts), contents)) is not None:
        parts.append(sets)
    return Drawn(joined(parts))


def chunks(folder: Path, contents: Contents, jobs: int) -> Iterator[Sets]:
    """All chunks in order, from the folder or simulated and written to it; there is no end."""
    number = 0
    while True:
        known = read_chunk(folder, number, contents)
        if known is not None:
            yield known
            number += 1
            continue
        coming = range(number, number + effective_n_jobs(jobs) * CHUNKS_A_PROCESS)
        running = Parallel(n_jobs=jobs, return_as="generator", batch_size=1)(
            delayed(simulated_chunk)(k, contents) for k in coming
        )
        for k, sets in zip(coming, running, strict=True):
            write_chunk(folder, k, contents, sets)


def simulated_chunk(number: int, contents: Contents) -> Sets:
    """Simulate all sets of a chunk, which are counted from 0 over all chunks."""
    start = number * contents.chunk
    simulated = [
        simulate(PRIOR, contents.seed, start + k, contents.experiments) for k in range(contents.chunk)
    ]
    return sets_of(start, simulated, contents.experiments)
