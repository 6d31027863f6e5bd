"""Sets of decisions from the prior, and the thesis's design replicated under each: what its tables would say."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from joblib import effective_n_jobs
from numpy.typing import NDArray

from khepera_forage.option_values import progress
from khepera_forage.rollouts.compiled.training import train_learners
from khepera_forage.study import Arguments, RowStore, in_processes
from khepera_forage.thesis.compiled_replications import recalls_of
from khepera_forage.thesis.design import THESIS, files_needed
from khepera_forage.thesis.inference.admissible import Check, check
from khepera_forage.thesis.inference.posterior import Parameter, parameters_of
from khepera_forage.thesis.inference.prior import (
    PRIOR,
    Laboratory,
    Prior,
    laboratory_from_text,
    laboratory_text,
)
from khepera_forage.thesis.inference.summary import NAMES, SLOPES, CellRecalls, of_recalls, with_slopes

CHUNK, QUICK_CHUNK = 100, 4
"""Sets drawn in one unit of work."""
CHUNKS_A_PROCESS = 4
"""Units that a process does before it is seen whether the sets are enough."""
FILE = "sets.jsonl.gz"


@dataclass(frozen=True, slots=True)
class SetRow:
    """One set of decisions from the prior.

    Attributes:
        number: Of the set, from 0.
        laboratory: Decisions and noise as text.
        reason: Why it is not admissible; empty if it is.
        statistics: Of the experiments under it, one after the other; empty if it is not admissible.
    """

    number: int
    laboratory: str
    reason: str
    statistics: tuple[float, ...]


class Chunk(NamedTuple):
    """Some sets, one after the other."""

    seed: int
    number: int
    size: int
    experiments: int

    @property
    def key(self) -> str:
        """The number."""
        return str(self.number)

    def run(self) -> list[SetRow]:
        """Simulate all sets; they are counted over all chunks."""
        return [
            set_row(number, simulate(PRIOR, self.seed, number, self.experiments))
            for number in range(self.number * self.size, (self.number + 1) * self.size)
        ]


def set_row(number: int, simulated: "Simulated") -> SetRow:
    """A set as a row; its statistics have the precision of 32-bit floats."""
    short = simulated.statistics.astype(np.float32).astype(str).ravel()
    return SetRow(
        number,
        laboratory_text(simulated.laboratory),
        simulated.check.reason,
        tuple(map(float, short.tolist())),
    )


@dataclass(frozen=True)
class Drawn:
    """Sets in the order in which they were drawn, up to the last admissible one that was wanted."""

    rows: Sequence[SetRow]
    experiments: int

    @cached_property
    def admissible(self) -> list[SetRow]:
        """The admissible sets."""
        return [row for row in self.rows if not row.reason]

    @cached_property
    def statistics(self) -> NDArray[np.float32]:
        """Of the admissible sets, shape (sets, experiments, statistics)."""
        flat = np.array([row.statistics for row in self.admissible], np.float32)
        return flat.reshape(len(flat), self.experiments, len(NAMES) + len(SLOPES))

    @cached_property
    def laboratories(self) -> list[Laboratory]:
        """The admissible sets."""
        return [laboratory_from_text(row.laboratory) for row in self.admissible]

    @cached_property
    def parameters(self) -> list[Parameter]:
        """What was drawn, of the admissible sets."""
        return parameters_of(PRIOR, self.laboratories)


def draw(given: Arguments, wanted: int, experiments: int) -> Drawn:
    """Draw sets until as many as wanted are admissible; a run that was killed continues.

    Raises:
        SystemExit: The folder holds sets of another run.
    """
    settings = {**given.settings, "experiments": str(experiments), "prior": repr(PRIOR)}
    settings["statistics"] = " ".join((*NAMES, *SLOPES))
    try:
        store = RowStore(given.out, {SetRow: "sets"}, settings, given.fresh, FILE)
    except ValueError as error:
        given.refuse(str(error))
    size = QUICK_CHUNK if given.quick else CHUNK
    rows: list[SetRow] = []
    found = number = 0
    with progress(total=wanted, desc="admissible sets") as bar:
        while found < wanted:
            coming = range(number, number + effective_n_jobs(given.jobs) * CHUNKS_A_PROCESS)
            missing = [k for k in coming if str(k) not in store.finished]
            if str(number) not in store.finished:
                for key, made in in_processes(given.jobs)(
                    [Chunk(given.seed, k, size, experiments) for k in missing]
                ):
                    store.add(key, made)
            for row in store.finished[str(number)]:
                if found < wanted:
                    rows.append(row)
                    found += not row.reason
                    bar.update(not row.reason)
            number += 1
    return Drawn(rows, experiments)


class Simulated(NamedTuple):
    """One set of decisions from the prior.

    Attributes:
        laboratory: Decisions and noise.
        check: Whether it is admissible.
        statistics: Of each experiment, shape (experiments, statistics of `summary`); empty if it is not admissible.
    """

    laboratory: Laboratory
    check: Check
    statistics: NDArray[np.float64]


def simulate(prior: Prior, seed: int, number: int, experiments: int) -> Simulated:
    """Draw a set from the prior, check it, and replicate the thesis under it if it is admissible.

    Args:
        prior: To draw from.
        seed: Of all sets.
        number: Of this set: it depends on seed and number alone.
        experiments: Replications of the whole design.
    """
    rng = np.random.default_rng((seed, number))
    laboratory = prior.draw(rng)
    first = int(rng.integers(2**62))
    found = check(laboratory, first)
    if found.reason:
        return Simulated(laboratory, found, np.zeros((0, 0)))
    return Simulated(laboratory, found, replicate(laboratory, first + 1, experiments))


def replicate(laboratory: Laboratory, seed: int, experiments: int) -> NDArray[np.float64]:
    """The statistics of some experiments of the thesis's size, shape (experiments, statistics).

    Args:
        laboratory: Decisions and noise.
        seed: Of the experiments.
        experiments: How many.
    """
    cells = recalls_under(laboratory, seed, experiments)
    return with_slopes([of_recalls(cell, recalls) for cell, recalls in zip(THESIS, cells, strict=True)])


def recalls_under(laboratory: Laboratory, seed: int, experiments: int) -> list[CellRecalls]:
    """The recalls of some experiments of the thesis's size, one element a cell of `THESIS`.

    Args:
        laboratory: Decisions and noise.
        seed: Of the experiments.
        experiments: How many.
    """
    decisions, noise = laboratory
    training, recalling = np.random.SeedSequence(seed).spawn(2)
    trained = train_learners(
        experiments,
        seed=int(training.generate_state(1)[0]),
        noise=noise,
        episodes=files_needed(THESIS),
        decisions=decisions,
    )
    cells = []
    for cell, seeds in zip(THESIS, recalling.spawn(len(THESIS)), strict=True):
        numbers = seeds.generate_state(experiments * cell.size).astype(np.int64)
        played = recalls_of(cell, trained, experiments, numbers, noise, decisions)
        shape = (experiments, len(cell.subsets), cell.recalls)
        arrays = (played.correct, played.steps, played.delivered, played.penalty)
        cells.append(CellRecalls(*(array.astype(np.float64).reshape(shape) for array in arrays)))
    return cells
