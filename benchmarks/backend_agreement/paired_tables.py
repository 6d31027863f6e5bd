"""Tables of recalls with the same seeds on both backends."""

import math
from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np
from scipy import stats

from backend_agreement.arenas import KINDS
from backend_agreement.paired import COMPILED, POLICIES, PYMUNK, PairedRecall
from backend_agreement.two_sample_tests import LEVEL
from khepera_forage.estimates import Column, Estimate, Measure, Table, Value, difference, holm, mean, pick

ALL = "all"
MEASURES = (
    Measure[PairedRecall]("delivered (%)", lambda row: 100.0 * row.delivered, lambda row: row.not_poisonous),
    Measure[PairedRecall]("poison home", lambda row: row.poison_home, digits=3),
    Measure[PairedRecall]("steps", lambda row: row.steps),
    Measure[PairedRecall]("score (%)", lambda row: row.score),
)


class Pairs(NamedTuple):
    """Recalls of a policy in the arenas of a kind, with the same seeds in the same order.

    Attributes:
        policy: One of `POLICIES`.
        kind: Name of a kind, or `all`.
        pymunk: Recalls with pymunk.
        compiled: Recalls on the compiled backend.
    """

    policy: str
    kind: str
    pymunk: list[PairedRecall]
    compiled: list[PairedRecall]


def differences_table(rows: Sequence[PairedRecall], rng: np.random.Generator) -> Table:
    """Mean differences, with intervals over arenas."""
    lines: list[tuple[Value, ...]] = []
    ps: list[float] = []
    for pairs in _pairs(rows):
        for measure in MEASURES:
            change = difference(pairs.compiled, pairs.pymunk, measure, rng)
            ps.append(p_of(change))
            sides = (mean(side, measure, rng) for side in (pairs.pymunk, pairs.compiled))
            lines.append((pairs.policy, pairs.kind, measure.name, *sides, change, ps[-1]))
    lines = [(*line, p) for line, p in zip(lines, _corrected(ps), strict=True)]
    note = (
        "Differences are compiled minus pymunk, with the same seeds. Delivered: share of the food that is not "
        "poisonous. Poison home and steps: per recall. Brackets: 95 % intervals, bootstrapped over arenas. p: of no "
        f"difference, from the width of the interval; corrected by Holm's rule for the {len(ps)} lines. "
        f"{_verdict([(*line[:3], line[-1]) for line in lines])}"
    )
    columns = (
        *map(Column, ("policy", "arenas", "measure")),
        *(Column(name, 2, estimate=True) for name in (PYMUNK, COMPILED, "difference")),
        Column("p", 3),
        Column("corrected p", 3),
    )
    return Table("paired_differences", "The same seeds in random arenas", note, columns, lines)


def completion_table(rows: Sequence[PairedRecall]) -> Table:
    """Recalls in which only one backend delivers everything."""
    lines: list[tuple[Value, ...]] = []
    ps: list[float] = []
    for pairs in _pairs(rows):
        counts = completions(pairs)
        ps.append(mcnemar(counts[1], counts[2]))
        lines.append((pairs.policy, pairs.kind, *counts, ps[-1]))
    lines = [(*line, p) for line, p in zip(lines, _corrected(ps), strict=True)]
    note = (
        "Recalls that end with no food left but known poison, by backend. Noise is drawn independently on the two "
        "backends, so that many recalls end differently by chance; equally many in both directions if the backends "
        f"agree. p: McNemar's exact test; corrected by Holm's rule for the {len(ps)} lines. "
        f"{_verdict([(*line[:2], line[-1]) for line in lines])}"
    )
    columns = (
        *map(Column, ("policy", "arenas", "both", "pymunk only", "compiled only", "neither")),
        Column("p", 3),
        Column("corrected p", 3),
    )
    return Table("paired_completions", "Recalls that deliver everything", note, columns, lines)


def completions(pairs: Pairs) -> tuple[int, int, int, int]:
    """Recalls that are complete on both backends, on pymunk only, on the compiled one only, on neither."""
    both = [(a.complete, b.complete) for a, b in zip(pairs.pymunk, pairs.compiled, strict=True)]
    return tuple(map(both.count, ((True, True), (True, False), (False, True), (False, False))))  # type: ignore[return-value]


def mcnemar(one: int, other: int) -> float:
    """The p-value of McNemar's exact test: pairs that differ do so equally often in both directions."""
    return float(stats.binomtest(one, one + other).pvalue) if one + other else 1.0


def p_of(change: Estimate) -> float:
    """The p-value of a difference of 0, by a normal distribution as wide as the interval; nan without interval."""
    if math.isnan(change.low):
        return math.nan
    if change.low == change.high:
        return 1.0 if change.value == 0.0 else 0.0
    return float(
        2 * stats.norm.sf(abs(change.value) / ((change.high - change.low) / (2 * stats.norm.isf(LEVEL / 2))))
    )


def _pairs(rows: Sequence[PairedRecall]) -> Iterator[Pairs]:
    """Every policy in all arenas and in those of each kind."""
    for policy in POLICIES:
        for kind in (ALL, *(kind.name for kind in KINDS)):
            own = pick(rows, policy=policy) if kind == ALL else pick(rows, policy=policy, kind=kind)
            yield Pairs(policy, kind, pick(own, backend=PYMUNK), pick(own, backend=COMPILED))


def _corrected(ps: Sequence[float]) -> list[float]:
    """Corrected p-values; nan remains."""
    known = iter(holm([p for p in ps if not math.isnan(p)]))
    return [p if math.isnan(p) else next(known) for p in ps]


def _verdict(lines: Sequence[tuple[Value, ...]]) -> str:
    """The lines, named by all values but the last, whose corrected p-value is small."""
    different = ["; ".join(map(str, names)) for *names, p in lines if isinstance(p, float) and p < LEVEL]
    return f"Different: {' / '.join(different)}." if different else "No line differs at the 5 % level."
