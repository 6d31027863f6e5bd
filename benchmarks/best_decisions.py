"""The single set of decisions that fits tables A.1 to A.4 best, with natural values.

    khepera-forage infer && python benchmarks/best_decisions.py

Starts from the admissible sets of `khepera-forage infer` and lets them evolve: children of the best sets, changed
within the prior, are checked and judged by their misfit (`Moments`). All values are natural ones, as a builder would
write them; a fit on a knife's edge does not survive that. Tables A.5 to A.7 are not looked at. Noise is the
laboratory's, and the check has four times as many forages, so that the set is not at the edge of the admissible. At
the end the best sets are replicated again with other seeds, so that luck is not mistaken for a fit. The best of them
then loses every change from version 0.1 that the tables do not ask for. Needs numba; a run that was killed continues.
"""

import argparse
import math
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
from decision_search.best_page import Final, page
from decision_search.evolving import Candidate, best, evolve, natural_sets, simulated
from decision_search.simpler import Judgement, Trial, simplify
from joblib import Parallel, delayed
from tqdm import tqdm

from khepera_forage.experiments.arguments import Arguments, Count, parse
from khepera_forage.experiments.page import finish
from khepera_forage.experiments.tables import Table
from khepera_forage.option_values import given_path
from khepera_forage.task.decisions import Decisions
from khepera_forage.thesis.inference.draw import kept
from khepera_forage.thesis.inference.moments import Moments, means_of
from khepera_forage.thesis.inference.posterior import infer
from khepera_forage.thesis.inference.prior import PRIOR
from khepera_forage.thesis.inference.simulate import Simulated
from khepera_forage.thesis.inference.summary import NAMES, SLOPES
from khepera_forage.thesis.inference.table import delete_chunks

START = Path("results/decisions")
QUICK_FIELDS = tuple(PRIOR.decisions)[::8]
"""Fields that are tried with simpler values with `--quick`."""


class Search(NamedTuple):
    """A search that is done.

    Attributes:
        started_from: Number of admissible sets.
        moments: Judge sets.
        alive: The best sets, the best first.
        generations: How the generations went.
    """

    started_from: int
    moments: Moments
    alive: list[Candidate]
    generations: Table


def finals(given: Arguments, alive: Sequence[Candidate], moments: Moments) -> list[Final]:
    """The best sets, replicated again with other seeds; the best first."""
    candidates = [one.decisions for one in alive[: given.finalists]]
    done = Parallel(n_jobs=given.jobs, batch_size=1)(
        delayed(simulated)(
            decisions, (given.seed, given.generations + 1, k), given.replications, given.effort
        )
        for k, decisions in enumerate(candidates)
    )
    return sorted((judged([one], moments) for one in done), key=lambda final: final.misfit)


def judged(parts: Sequence[Simulated], moments: Moments) -> Final:
    """A set that was simulated, in one or more parts."""
    reasons = [part.check.reason for part in parts if part.check.reason]
    decisions = parts[0].laboratory.decisions
    if reasons:
        return Final(decisions, np.inf, reasons[0], np.full(len(NAMES) + len(SLOPES), np.nan))
    statistics = np.concatenate([part.statistics for part in parts])
    return Final(decisions, moments.misfit(statistics), "admissible", means_of(statistics[None])[0])


def simplified(
    given: Arguments, finalists: Sequence[Final], moments: Moments
) -> tuple[Final, Final, list[Trial]]:
    """The best set without changes that the tables do not ask for.

    Returns:
        The best of the finalists that is admissible once more; the simpler set, replicated again; and what was tried.

    Raises:
        ValueError: No finalist is admissible once more.
    """
    size = max(given.replications // 2, 2)  # of a part, which is the work of one process
    parts = max(given.replications // size, 1)
    with (
        Parallel(n_jobs=given.jobs, batch_size=1) as parallel,
        tqdm(desc="simpler sets", disable=not sys.stderr.isatty()) as progress,
    ):

        def replicated(decisions: Decisions, number: int, parts: int) -> Final:
            progress.update()
            found = parallel(
                delayed(simulated)(
                    decisions,
                    (given.seed, given.generations + 2, number, k),
                    size,
                    given.effort,
                )
                for k in range(parts)
            )
            return judged(found, moments)

        def judge(decisions: Decisions, number: int) -> Judgement:
            final = replicated(decisions, number, parts)
            return Judgement(final.misfit, final.outcome)

        for start in finalists:
            first = judge(start.decisions, 0)
            if math.isfinite(first.misfit):
                chosen, trials = simplify(
                    start.decisions,
                    first.misfit,
                    PRIOR,
                    judge,
                    given.passes,
                    QUICK_FIELDS if given.quick else (),
                )
                return start, replicated(chosen, len(trials) + 1, 2 * parts), trials
    raise ValueError(f"no finalist fits; the first one: {finalists[0].outcome}")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The arguments of this script alone."""
    text = f"folder of khepera-forage infer to start from ({START})"
    parser.add_argument("--start", type=given_path, default=START, help=text)


def arguments(given: Sequence[str] | None = None) -> Arguments:
    """Read the command line.

    Args:
        given: The arguments; by default those of this process.
    """
    counts = (
        Count("generations", 10, 1, "generations after the first", adds_units=True),
        Count("children", 120, 4, "sets in each"),
        Count("population", 40, 4, "sets that live on"),
        Count("experiments", 20, 2, "replications of the thesis's design under each set"),
        Count("finalists", 40, 4, "sets that are replicated again"),
        Count("replications", 200, 2, "replications of each finalist"),
        Count(
            "passes", 3, 1, "times that every field of the best set is tried with a simpler value, at most"
        ),
        Count("effort", 4, 1, "times as many forages in the check as in khepera-forage infer"),
    )
    return parse("best_decisions", __doc__, *counts, add=add_arguments, given=given)


def evolved(given: Arguments) -> Search:
    """Let the sets of `--start` evolve.

    Raises:
        ValueError: The folder has no sets that can be used, or no set of the first generation is admissible.
    """
    drawn = kept(given.start)
    posterior = infer(drawn.parameters, drawn.statistics, given.seed)
    moments = Moments(drawn.statistics, posterior.weights)
    known = [
        Candidate(laboratory.decisions, statistics.astype(np.float64))
        for laboratory, statistics in zip(drawn.laboratories, drawn.statistics, strict=True)
    ]
    first = natural_sets(best(known, given.children, moments))
    alive, generations = evolve(given, first, moments)
    return Search(len(drawn.admissible), moments, alive, generations)


def main() -> int:
    """Run the search."""
    given = arguments()
    if given.fresh:
        delete_chunks(given.out)
    try:
        search = evolved(given)
        finalists = finals(given, search.alive, search.moments)
        start, chosen, trials = simplified(given, finalists, search.moments)
    except ValueError as error:
        given.refuse(str(error))
    return finish(
        given,
        page(chosen, start, trials, finalists, search.generations, search.started_from),
        f"--start {given.start}",
    )


if __name__ == "__main__":
    sys.exit(main())
