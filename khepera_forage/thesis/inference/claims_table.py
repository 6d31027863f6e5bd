"""The claims of the thesis under many laboratories: a table on disk, shares of verdicts, and the table of a page."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from joblib import Parallel, delayed
from numpy.typing import NDArray

from khepera_forage.estimates import Column, Estimate, Table, Value, wilson
from khepera_forage.rollouts.training import IncompleteTrainingError
from khepera_forage.thesis.claims import Claim, Verdict, claims
from khepera_forage.thesis.inference.chunks import SUFFIX, read_arrays, write_arrays
from khepera_forage.thesis.inference.laboratory_claims import RESAMPLES, claims_of
from khepera_forage.thesis.inference.laboratory_text import laboratory_from_text, laboratory_text
from khepera_forage.thesis.inference.prior import Laboratory

BATCH = 10
"""Laboratories in one unit of work, which is one file."""
CLAIMS = tuple(claims([], [], [], np.random.default_rng(0), resamples=1))
"""Every claim without rows: its words, section and unit."""


@dataclass(frozen=True, slots=True)
class ClaimsContents:
    """What all files of a folder must have in common.

    Attributes:
        seed: Of all laboratories.
        replications: Of the thesis's design under each laboratory.
        resamples: For each interval.
        claims: Their names.
    """

    seed: int
    replications: int
    resamples: int = RESAMPLES
    claims: tuple[str, ...] = tuple(claim.name for claim in CLAIMS)


class MeasuredClaims(NamedTuple):
    """The claims under some laboratories, one element or row each.

    Attributes:
        numbers: Of the laboratories.
        laboratories: As text (`laboratory_text`).
        reasons: Why the claims could not be measured; empty if they were.
        verdicts: Shape (laboratories, claims), values of `Verdict`; empty if not measured.
        effects: Value, lower and upper end of its interval, in the unit of the claim; shape (laboratories, claims, 3).
            Not a number if not measured, and where the rows are not enough.
    """

    numbers: NDArray[np.int64]
    laboratories: NDArray[np.str_]
    reasons: NDArray[np.str_]
    verdicts: NDArray[np.str_]
    effects: NDArray[np.float64]

    def select(self, numbers: Sequence[int]) -> "MeasuredClaims":
        """The rows of some laboratories, in this order; a number that occurs twice has two rows.

        Args:
            numbers: Of the laboratories.

        Raises:
            ValueError: A laboratory that is not here.
        """
        rows = {number: row for row, number in enumerate(self.numbers.tolist())}
        missing = [number for number in numbers if number not in rows]
        if missing:
            raise ValueError(f"laboratory {missing[0]} is not measured; allowed: {len(rows)} other numbers")
        return _rows(self, np.array([rows[number] for number in numbers], dtype=np.intp))


def measure(
    folder: Path,
    laboratories: Mapping[int, Laboratory],
    contents: ClaimsContents,
    jobs: int = 1,
    batch: int = BATCH,
) -> Iterator[MeasuredClaims]:
    """The claims under some laboratories, from the folder or measured and written to it.

    Args:
        folder: Of the files. Other laboratories may be in it, too.
        laboratories: By number; the claims depend on the laboratory, its number, seed and replications alone.
        contents: What all files of the folder have in common.
        jobs: Processes; -1 uses all cores.
        batch: Laboratories in one file.

    Yields:
        Some laboratories: first those of each file in the folder, then each batch when it is finished. Every
        laboratory occurs once; `chunks.joined` makes one table of all.

    Raises:
        ValueError: The folder has a damaged file, a file of another run, or another laboratory of the same number. Or
            robot or food does not fit on a mark of a laboratory.
    """
    missing = dict(laboratories)
    for path in _paths(folder):
        known = _known(path, missing, contents)
        if len(known.numbers):
            yield known
        for number in known.numbers.tolist():
            del missing[number]
    numbers = list(missing)
    batches = [numbers[first : first + batch] for first in range(0, len(numbers), batch)]
    running = Parallel(n_jobs=jobs, return_as="generator", batch_size=1)(
        delayed(_measured)({number: missing[number] for number in some}, contents) for some in batches
    )
    for measured in running:
        # A number is measured once, so that no two files of a folder begin with the same one.
        path = folder / f"claims_{measured.numbers[0]:06d}{SUFFIX}"
        write_arrays(path, contents, measured._asdict())
        yield measured


def delete_claims(folder: Path) -> None:
    """Delete all files of a folder that `measure` has written."""
    for path in _paths(folder):
        path.unlink()


def verdict_table(prior: MeasuredClaims, posterior: MeasuredClaims) -> Table:
    """In what share of laboratories each claim holds.

    Args:
        prior: Under a sample of admissible laboratories of the prior.
        posterior: Under an unweighted sample of the posterior. The intervals are those of independent draws: they are
            too narrow if few different laboratories make up the sample.
    """
    samples = [_rows(sample, np.flatnonzero(sample.reasons == "")) for sample in (prior, posterior)]
    rows: list[tuple[Value, ...]] = []
    for k, claim in enumerate(CLAIMS):
        holds = [_percent_supported(sample.verdicts[:, k]) for sample in samples]
        effects = samples[1].effects[:, k, 0]
        effects = effects[~np.isnan(effects)]
        median = claim.unit(float(np.median(effects))) if len(effects) else "-"
        rows.append((claim.name, claim.thesis_section, *holds, median))
    return Table(
        "claims",
        "In which laboratories the thesis's claims hold",
        f"Share of {len(samples[0].numbers)} admissible laboratories of the prior, and of {len(samples[1].numbers)} "
        "laboratories of the posterior, in which a claim is supported, with Wilson's 95 % interval. In the other "
        "laboratories it is not supported, or undecided. The effect is its median over the laboratories of the "
        "posterior.",
        (
            Column("claim"),
            Column("section"),
            Column("holds, prior (%)", 0, estimate=True),
            Column("holds, posterior (%)", 0, estimate=True),
            Column("median effect, posterior"),
        ),
        rows,
    )


def _rows(measured: MeasuredClaims, chosen: NDArray[np.intp]) -> MeasuredClaims:
    """Some rows."""
    arrays: list[NDArray[Any]] = [array[chosen] for array in measured]
    return MeasuredClaims(*arrays)


def _percent_supported(verdicts: NDArray[np.str_]) -> Estimate:
    share = wilson(int((verdicts == Verdict.SUPPORTED).sum()), len(verdicts))
    return Estimate(*(100.0 * value for value in share))


def _measured(laboratories: Mapping[int, Laboratory], contents: ClaimsContents) -> MeasuredClaims:
    """Measure the claims under each laboratory, with a seed of its own."""
    reasons, found = [], []
    for number, laboratory in laboratories.items():
        sequence = np.random.SeedSequence(contents.seed, spawn_key=(number,))
        reason, own = "", list[Claim]()
        try:
            own = claims_of(laboratory, int(sequence.generate_state(1)[0]), contents.replications)
        except IncompleteTrainingError as error:
            reason = str(error)
        reasons.append(reason)
        found.append(own)
    return MeasuredClaims(
        np.array(list(laboratories), dtype=np.int64),
        np.array([laboratory_text(laboratory) for laboratory in laboratories.values()]),
        np.array(reasons),
        np.array([[claim.verdict.value for claim in own] or [""] * len(CLAIMS) for own in found]),
        np.array([[(c.value, c.low, c.high) for c in own] or [(np.nan,) * 3] * len(CLAIMS) for own in found]),
    )


def _known(path: Path, laboratories: Mapping[int, Laboratory], contents: ClaimsContents) -> MeasuredClaims:
    """The rows of a file that belong to some laboratories.

    Raises:
        ValueError: The file is damaged, of another run, or has another laboratory of the same number.
    """
    arrays = read_arrays(path, contents, MeasuredClaims._fields, "claims under laboratories")
    measured = MeasuredClaims(*arrays)
    numbers = measured.numbers.tolist()
    for number, text in zip(numbers, measured.laboratories.tolist(), strict=True):
        if number in laboratories and laboratory_from_text(text) != laboratories[number]:
            raise ValueError(
                f"{path}: laboratory {number} is another one; allowed: the same laboratories as in this run, another "
                "folder (--out), or --fresh, which deletes the file"
            )
    return _rows(measured, np.flatnonzero([number in laboratories for number in numbers]))


def _paths(folder: Path) -> list[Path]:
    return sorted(folder.glob(f"claims_*{SUFFIX}"))
