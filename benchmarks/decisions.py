"""What the thesis leaves open, drawn from a justified prior: which laboratories could have been, and their results.

    python benchmarks/decisions.py --help

Each set of decisions is drawn from `khepera_forage.thesis.inference.prior.PRIOR`. It is admissible if the teacher can
do under it what the thesis says of it. Under each admissible set, the thesis's whole design is replicated. The thesis's
tables are not looked at before the last table, which compares them with what the admissible sets predict.

Needs numba (the extra `fast`). Ten thousand sets take some hours; a run that was killed continues.
"""

import sys
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from harness.arguments import Arguments, Count, parse
from harness.figures import GREY, THESIS, grid, new_figure
from harness.page import Page, Picture, finish
from joblib import Parallel, delayed, effective_n_jobs
from numpy.typing import NDArray
from tqdm import tqdm

from khepera_forage.thesis.inference.prior import PRIOR, Range
from khepera_forage.thesis.inference.simulate import simulate
from khepera_forage.thesis.inference.summary import FITTED, NAMES, SLOPES, thesis_statistics
from khepera_forage.thesis.inference.table import (
    Contents,
    Sets,
    delete_chunks,
    joined,
    read_chunk,
    sets_of,
    write_chunk,
)
from khepera_forage.thesis.statistics import Estimate, percentile_rank
from khepera_forage.thesis.tables import Column, Table

if TYPE_CHECKING:
    from matplotlib.figure import Figure

CHUNK, QUICK_CHUNK = 100, 4
"""Sets drawn in one unit of work."""
CHUNKS_A_PROCESS = 4
"""Chunks that a process simulates before it is asked whether the sets are enough."""


def simulated_chunk(number: int, contents: Contents) -> Sets:
    """Simulate all sets of a chunk, which are counted from 0 over all chunks."""
    first = number * contents.chunk
    simulated = [
        simulate(PRIOR, contents.seed, first + k, contents.experiments) for k in range(contents.chunk)
    ]
    return sets_of(first, simulated, contents.experiments)


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


def collect(given: Arguments, wanted: int, experiments: int) -> Sets:
    """Sets until as many as wanted are admissible.

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
                    return joined(parts)
    except ValueError as error:
        sys.exit(f"decisions.py: {error}")
    raise AssertionError("chunks have no end")


def page(sets: Sets, wanted: int) -> Page:
    """The prior, why sets are not admissible, and what the admissible ones predict."""
    admissible = np.flatnonzero(sets.reasons == "")[:wanted]
    drawn = int(admissible[-1]) + 1
    statistics = sets.statistics[admissible]
    return Page(
        "Laboratories that could have been the thesis's",
        [
            _prior_table(),
            _reasons_table(sets.reasons[:drawn]),
            _predictions_table(statistics),
            Picture(
                "predictions", "the thesis among the predictions of the admissible sets", _picture(statistics)
            ),
        ],
    )


def _prior_table() -> Table:
    rows = []
    for name, part in (*PRIOR.decisions.items(), *PRIOR.noise.items()):
        if isinstance(part, Range):
            values = f"{part.least:g} to {part.most:g}"
        else:
            values = "; ".join(f"{reading} ({share:.0%})" for reading, share in part.of.items())
        rows.append((name, values, part.source))
    return Table(
        "prior",
        "The prior",
        "Numbers are uniform in their range; readings have the probability in brackets. Everything else has its "
        "default. The ranges were written before anything was fitted.",
        (Column("decision or noise"), Column("values"), Column("source")),
        rows,
    )


def _reasons_table(reasons: NDArray[np.str_]) -> Table:
    counts = Counter(reason or "admissible" for reason in reasons.tolist())
    return Table(
        "admissible",
        "Which sets are admissible",
        "A set is admissible if the teacher brings home at least 98 % of the food in both arenas, its fastest forage "
        "leaves room for the fastest recalls of the thesis (65 and 205 steps), it delivers nothing with SEARCH in the "
        "place of ORIENT, and at least half of the attempts at a training episode are complete. The first reason "
        "counts.",
        (Column("outcome"), Column("sets"), Column("share (%)")),
        [(name, count, 100.0 * count / len(reasons)) for name, count in counts.most_common()],
    )


def _predictions_table(statistics: NDArray[np.float32]) -> Table:
    rows = []
    for k, (name, thesis) in enumerate(zip((*NAMES, *SLOPES), thesis_statistics().tolist(), strict=True)):
        values = statistics[:, :, k].ravel()
        values = values[np.isfinite(values)]
        if np.isnan(thesis) or not len(values):
            continue
        low, middle, high = np.percentile(values, (2.5, 50, 97.5)).tolist()
        rank = percentile_rank(thesis, values.tolist()).percentile
        rows.append((name, "fitted" if name in FITTED else "test", thesis, Estimate(middle, low, high), rank))
    return Table(
        "predictions",
        "What the admissible sets predict",
        "Each admissible set gives experiments of the thesis's size. Shown are their median and, in brackets, the "
        "central 95 %, over all sets, and the percentile of the thesis among them. Shares of correct steps and scores "
        "are in percent; food is a share. `test` marks what is never fitted.",
        (
            Column("statistic"),
            Column("use"),
            Column("thesis", 2),
            Column("admissible sets", 2, estimate=True),
            Column("percentile", 0),
        ),
        rows,
    )


def _picture(statistics: NDArray[np.float32]) -> "Figure":
    thesis = thesis_statistics()
    shown = [k for k, name in enumerate(NAMES) if name.endswith((" score", "food", "right_failed"))]
    figure = new_figure(8.8, 6.4)
    axes = figure.subplots(1, 3)
    for axis, statistic in zip(axes, ("score", "food", "right_failed"), strict=True):
        own = [k for k in shown if NAMES[k].endswith(f" {statistic}")]
        values = [statistics[:, :, k].ravel() for k in own]
        values = [column[np.isfinite(column)] for column in values]
        axis.violinplot(
            [column if len(column) else [np.nan] for column in values],
            range(len(own)),
            orientation="horizontal",
        )
        axis.plot(thesis[own], range(len(own)), "D", color=THESIS)
        axis.set_yticks(range(len(own)), [NAMES[k].removesuffix(f" {statistic}") for k in own], fontsize=8)
        axis.invert_yaxis()
        axis.set_xlabel(
            {"score": "score (%)", "food": "food (share)", "right_failed": "right in failed recalls (%)"}[
                statistic
            ]
        )
        grid(axis, "x")
    figure.supxlabel(
        "areas: experiments under all admissible sets; diamonds: the thesis", fontsize=8, color=GREY
    )
    return figure


def main() -> int:
    """Run the benchmark."""
    sets = Count("sets", 10_000, 3, "admissible sets")
    experiments = Count("experiments", 20, 2, "replications of the thesis's design under each set")
    given = parse("decisions", __doc__, sets, experiments)
    found = collect(given, given.sets, given.experiments)
    return finish(given, page(found, given.sets))


if __name__ == "__main__":
    sys.exit(main())
