"""Sets that evolve: each generation is simulated, and the sets that fit best have children."""

import sys
from collections.abc import Sequence
from contextlib import suppress
from typing import NamedTuple

import numpy as np
from joblib import Parallel, delayed
from numpy.typing import NDArray
from tqdm import tqdm

from khepera_forage.experiments.arguments import Arguments
from khepera_forage.experiments.tables import Column, Table
from khepera_forage.noise import Noise
from khepera_forage.task.decisions import Decisions
from khepera_forage.thesis.inference.admissible import check
from khepera_forage.thesis.inference.evolution import child, natural
from khepera_forage.thesis.inference.laboratory_text import laboratory_from_text
from khepera_forage.thesis.inference.moments import Moments
from khepera_forage.thesis.inference.prior import PRIOR, Laboratory
from khepera_forage.thesis.inference.simulate import Simulated, replicate
from khepera_forage.thesis.inference.table import Contents, Sets, read_chunk, sets_of, write_chunk

Floats = NDArray[np.float64]


class Candidate(NamedTuple):
    """An admissible set.

    Attributes:
        decisions: The set.
        statistics: Of its experiments, shape (experiments, statistics).
    """

    decisions: Decisions
    statistics: Floats


def simulated(decisions: Decisions, seed: Sequence[int], experiments: int, effort: int) -> Simulated:
    """A set under the laboratory's noise: checked, and replicated if it is admissible.

    Args:
        decisions: The set.
        seed: Of the check and the replications.
        experiments: Replications of the thesis's design.
        effort: Of the check, as a multiple of that of `khepera-forage infer`.
    """
    laboratory = Laboratory(decisions, Noise.laboratory())
    first = int(np.random.default_rng(seed).integers(2**62))
    found = check(laboratory, first, effort)
    statistics = np.zeros((0, 0)) if found.reason else replicate(laboratory, first + 1, experiments)
    return Simulated(laboratory, found, statistics)


def generation(given: Arguments, number: int, candidates: Sequence[Decisions], contents: Contents) -> Sets:
    """Simulate candidates, or read them if an earlier run has done so."""
    known = read_chunk(given.out, number, contents)
    if known is not None:
        return known
    done = Parallel(n_jobs=given.jobs, return_as="generator", batch_size=1)(
        delayed(simulated)(decisions, (given.seed, number, k), contents.experiments, given.effort)
        for k, decisions in enumerate(candidates)
    )
    silent = not sys.stderr.isatty()
    sets = sets_of(
        number * contents.chunk,
        list(tqdm(done, f"generation {number}", len(candidates), disable=silent)),
        contents.experiments,
    )
    write_chunk(given.out, number, contents, sets)
    return sets


def admissible(sets: Sets) -> list[Candidate]:
    """The admissible sets among some."""
    return [
        Candidate(laboratory_from_text(str(text)).decisions, statistics.astype(np.float64))
        for text, reason, statistics in zip(sets.laboratories, sets.reasons, sets.statistics, strict=True)
        if not reason
    ]


def best(found: Sequence[Candidate], count: int, moments: Moments) -> list[Candidate]:
    """The sets that fit best, each once, the best first."""
    different = {one.decisions: one for one in found}.values()
    return sorted(different, key=lambda one: moments.misfit(one.statistics))[:count]


def evolve(given: Arguments, first: Sequence[Decisions], moments: Moments) -> tuple[list[Candidate], Table]:
    """Let sets evolve.

    Args:
        given: Counts and folder.
        first: The first generation.
        moments: Judges sets.

    Returns:
        The best sets, the best first, and how the generations went.

    Raises:
        ValueError: No set of the first generation is admissible.
    """
    contents = Contents(
        given.seed,
        given.experiments,
        given.children,
        f"natural children of {PRIOR!r}, checked {given.effort} times",
    )
    candidates = list(first)
    alive: list[Candidate] = []
    rows = []
    for number in range(given.generations + 1):
        new = admissible(generation(given, number, candidates, contents))
        alive = best([*alive, *new], given.population, moments)
        if not alive:
            raise ValueError("no set of the first generation is admissible; give --children more sets")
        misfits = [moments.misfit(one.statistics) for one in alive]
        rows.append(
            (
                number,
                100.0 * len(new) / len(candidates),
                misfits[0],
                float(np.median(misfits)),
                misfits[-1],
            )
        )
        rng = np.random.default_rng((given.seed, number))
        candidates = [child(PRIOR, [one.decisions for one in alive], rng) for _ in range(given.children)]
    columns = ("generation", "admissible (%)", "best misfit", "median misfit", "worst misfit")
    note = "Misfit of the sets that live on after each generation."
    return alive, Table("generations", "Generations", note, tuple(map(Column, columns)), rows)


def natural_sets(found: Sequence[Candidate]) -> list[Decisions]:
    """The sets with natural values, each once, without those that then break a rule between decisions."""
    sets = list[Decisions]()
    for one in found:
        with suppress(ValueError):
            sets.append(natural(one.decisions, PRIOR))
    return list(dict.fromkeys(sets))
