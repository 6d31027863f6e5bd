"""The claims of the thesis under many laboratories: measured, kept, and in what share of laboratories each holds."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from khepera_forage.envs.backends import COMPILED
from khepera_forage.estimates import Floats, Table, Value, percent, table_of
from khepera_forage.rollouts.rows import RecallRow, TrainingRow
from khepera_forage.rollouts.training import IncompleteTrainingError
from khepera_forage.study import Arguments, Job, Rows, collect
from khepera_forage.task.decisions import decisions_text
from khepera_forage.thesis.claims import Claim, Verdict, claims, gather
from khepera_forage.thesis.design import NO_LOSSES
from khepera_forage.thesis.inference.prior import LabModel, laboratory_text
from khepera_forage.thesis.replication import UntrainedRow, job_counts, jobs

RESAMPLES = 500
"""For each interval."""
LABORATORIES, QUICK_LABORATORIES = 80, 2
"""Drawn from the prior, and as many from the posterior."""
REPLICATIONS, QUICK_REPLICATIONS = 50, 5
"""Of the thesis's design under each."""
CLAIMS = tuple(claims(gather([], [], np.random.default_rng(0))))
"""Every claim without rows: its words, section and unit."""


@dataclass(frozen=True, slots=True)
class LaboratoryClaims:
    """The claims under one laboratory.

    Attributes:
        reason: Why they could not be measured; empty if they were.
        verdicts: One a claim; empty if not measured.
        effects: One a claim, in its unit; not a number where the rows are not enough.
    """

    number: int
    laboratory: str
    reason: str
    verdicts: tuple[str, ...]
    effects: tuple[float, ...]


def claims_of(laboratory: LabModel, seed: int, replications: int) -> list[Claim]:
    """Measure every claim of the thesis under one laboratory, by a reproduction on the compiled backend.

    Of the other noise conditions only the laboratory without tracking losses is needed, and of that only the training
    files. The seed is that of all experiments and of the intervals.

    Raises:
        IncompleteTrainingError: No attempt at some training episode was complete.
        ValueError: A mark where robot or food does not fit.
    """
    counts = job_counts(replications, COMPILED)._replace(
        noise_replications=replications, noise_conditions=(NO_LOSSES,), noise_cells=()
    )
    made = jobs(seed, counts, laboratory.decisions, COMPILED, laboratory.noise)
    rows = Rows(row for job in made for row in job.run())
    for row in rows.of(UntrainedRow):
        raise IncompleteTrainingError(f"{row.reason}, with the noise {row.noise!r}")
    rng = np.random.default_rng(seed)
    return claims(gather(rows.of(RecallRow), rows.of(TrainingRow), rng, RESAMPLES))


def measure(seed: int, number: int, laboratory: LabModel, replications: int) -> list[LaboratoryClaims]:
    """The claims of one laboratory, with a seed of its own."""
    own = int(np.random.SeedSequence(seed, spawn_key=(number,)).generate_state(1)[0])
    reason, found = "", list[Claim]()
    try:
        found = claims_of(laboratory, own, replications)
    except IncompleteTrainingError as error:
        reason = f"{error}; seed {own}, decisions: {decisions_text(laboratory.decisions)}"
    verdicts, effects = tuple(one.verdict.value for one in found), tuple(one.estimate.value for one in found)
    return [LaboratoryClaims(number, laboratory_text(laboratory), reason, verdicts, effects)]


def measured(
    given: Arguments, laboratories: Sequence[LabModel], weights: Floats
) -> tuple[list[LaboratoryClaims], list[LaboratoryClaims]]:
    """The claims under a sample of admissible laboratories, and under an unweighted sample of the posterior."""
    count = min(QUICK_LABORATORIES if given.quick else LABORATORIES, len(laboratories))
    rng = np.random.default_rng(given.seed)
    prior = rng.choice(len(laboratories), count, replace=False).tolist()
    inferred = rng.choice(len(laboratories), count, p=weights / weights.sum()).tolist()
    replications = QUICK_REPLICATIONS if given.quick else REPLICATIONS
    # The key has the laboratory, too, which depends on the sets that are drawn.
    units = [
        Job(f"{k} {laboratory_text(laboratories[k])}", measure, (given.seed, k, laboratories[k], replications))
        for k in sorted({*prior, *inferred})
    ]
    settings = {"replications": str(replications), "claims": "; ".join(claim.name for claim in CLAIMS)}
    rows = collect(given, units, {LaboratoryClaims: "claims"}, settings=settings, file="claims.jsonl.gz")
    by_number = {row.number: row for row in rows.of(LaboratoryClaims)}
    return [by_number[number] for number in prior], [by_number[number] for number in inferred]


def claim_table(*samples: Sequence[LaboratoryClaims]) -> Table:
    """In what share of laboratories each claim holds: of a sample of the prior, and of one of the posterior.

    The intervals are those of independent draws: they are too narrow if few different laboratories make up a sample.
    """
    known = [[row for row in rows if not row.reason] for rows in samples]
    lines: list[dict[str, Value]] = []
    for k, claim in enumerate(CLAIMS):
        prior, inferred = (
            percent(sum(row.verdicts[k] == Verdict.SUPPORTED for row in rows), len(rows)) for rows in known
        )
        effects = [row.effects[k] for row in known[1] if not np.isnan(row.effects[k])]
        lines.append(
            {
                "claim": claim.name,
                "section": claim.thesis_section,
                "holds, prior (%)": prior,
                "holds, posterior (%)": inferred,
                "median effect, posterior": claim.unit(float(np.median(effects))) if effects else "-",
            }
        )
    return table_of(
        "claims",
        "In which laboratories the thesis's claims hold",
        f"Share of {len(known[0])} admissible laboratories of the prior, and of {len(known[1])} laboratories "
        "of the posterior, in which a claim is supported, with Wilson's 95 % interval. In the others it is not "
        "supported, or undecided. The effect is its median over the laboratories of the posterior. Left out, because "
        f"training was never complete: {len(samples[0]) - len(known[0])} and {len(samples[1]) - len(known[1])}.",
        lines,
        {"holds, prior (%)": 0, "holds, posterior (%)": 0},
    )
