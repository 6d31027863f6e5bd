"""The tables of the report: the thesis beside our results, and measurements beyond the thesis."""

import math
from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from itertools import zip_longest
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from khepera_forage.estimates import (
    RESAMPLES,
    UNKNOWN,
    Column,
    Estimate,
    Sample,
    Table,
    Value,
    combined,
    percentile_rank,
    pick,
    replications,
    table_of,
)
from khepera_forage.rollouts.rows import IMITATOR, STATES, RecallRow
from khepera_forage.sim.arenas.thesis import THESIS_ARENAS
from khepera_forage.task.states import State
from khepera_forage.thesis import appendix_a
from khepera_forage.thesis.claims import Claim, Evidence, attempts_per_episode, steps_needed
from khepera_forage.thesis.design import LIMITS, NO_NOISE, THESIS, Cell, noise_conditions
from khepera_forage.thesis.inference.summary import usable_lines
from khepera_forage.thesis.replication import UntrainedRow


class Measured(NamedTuple):
    """A figure of the thesis, and ours.

    Attributes:
        ours: Our mean.
        experiments: One of each complete replication, which is an experiment of the thesis's size.
    """

    thesis: float
    ours: Estimate
    experiments: Sequence[float]

    @property
    def rank(self) -> tuple[float, float]:
        """Percentile and tail of the thesis's figure among our experiments."""
        return percentile_rank(self.thesis, self.experiments)


class CellResult(NamedTuple):
    """One table of appendix A and our replications of it.

    Attributes:
        thesis_printed: The thesis's printed mean score, in percent.
        score: Mean score, in percent; the thesis's is that of its lines, which differs where the printed mean is wrong.
        food: Food objects carried home in an experiment of the thesis's size.
    """

    cell: Cell
    thesis_printed: float
    score: Measured
    food: Measured
    recalls: int


def in_cell(rows: Iterable[RecallRow], cell: Cell) -> list[RecallRow]:
    """The recall episodes of the imitator in one cell."""
    return pick(rows, learner=IMITATOR, arena=cell.arena, episodes=cell.episodes)


def cell_results(
    recalls: Sequence[RecallRow], rng: np.random.Generator, resamples: int = RESAMPLES
) -> list[CellResult]:
    """The result of every cell; rows of other policies than the imitator are ignored."""
    results = []
    for cell in THESIS:
        rows = in_cell(recalls, cell)
        score = combined([(1.0, _score(rows))], rng, resamples)
        food = combined([(cell.size, Sample(rows, lambda row: row.delivered))], rng, resamples)
        experiments: dict[int, list[RecallRow]] = {number: [] for number in replications(rows)}
        for row in rows:
            experiments[row.replication].append(row)
        whole = [group for group in experiments.values() if len(group) == cell.size]
        scores = [sum(row.score for row in group) / cell.size for group in whole]
        foods = [sum(row.delivered for row in group) for group in whole]
        table = appendix_a.table_of(cell.arena, cell.episodes)
        results.append(
            CellResult(
                cell,
                float(table.average),
                Measured(appendix_a.mean_score(table), score, scores),
                Measured(table.collected, food, foods),
                len(rows),
            )
        )
    return results


def cell_table(results: Sequence[CellResult], v0_1_results: Sequence[CellResult] = ()) -> Table:
    """Mean score and food count of each cell in the thesis, in our replications, and in those of version 0.1 if any."""
    rows: list[dict[str, Value]] = []
    for r, old in zip_longest(results, v0_1_results):
        rows.append(
            {
                "arena": r.cell.arena,
                "episodes": r.cell.episodes,
                "thesis: score (%)": r.thesis_printed,
                "from its lines (%)": r.score.thesis,
                **_measured("score", " (%)", r.score, old and old.score),
                "thesis: food": f"{r.food.thesis} of {r.cell.available}",
                **_measured("food", "", r.food, old and old.food),
                "experiments": len(r.score.experiments),
                "recalls": r.recalls,
            }
        )
    digits = dict.fromkeys(("thesis: score (%)", "from its lines (%)", "score tail", "food tail"), 2)
    percentiles = ("score percentile", "food percentile", "v0.1: score percentile", "v0.1: food percentile")
    return table_of(
        "cells",
        "Results of the thesis and of our replications",
        "Mean score in percent and food carried home, with a 95 % interval over replications. The thesis's score is "
        "shown as printed, and as the mean of the printed lines, which is compared with ours. *Percentile* is the rank "
        "of the thesis's value among our experiments of its size, one in each replication; *tail* is the probability "
        "that one more of them is at least as extreme, on either side."
        + (" *v0.1*: under the decisions of version 0.1." if v0_1_results else ""),
        rows,
        digits | dict.fromkeys(percentiles, 0),
    )


def _measured(name: str, unit: str, own: Measured, old: Measured | None) -> dict[str, Value]:
    row: dict[str, Value] = {f"ours: {name}{unit}": own.ours}
    row[f"{name} percentile"], row[f"{name} tail"] = own.rank
    if old:
        row |= {f"v0.1: {name}{unit}": old.ours, f"v0.1: {name} percentile": old.rank[0]}
    return row


def joint_table(results: Sequence[CellResult], recalls: Sequence[RecallRow]) -> Table:
    """The thesis's results taken together, among our experiments; empty without all cells, or with few experiments."""
    rows: list[tuple[Value, ...]] = []
    counts = {len(r.score.experiments) for r in results}
    if len(results) == len(THESIS) and len(counts) == 1 and counts.pop() > 3 * len(THESIS):
        foods = [np.divide((r.food.thesis, *r.food.experiments), r.cell.available) for r in results]
        # One line for each experiment, the thesis's first; scores of all cells, then shares of the food.
        means = np.array([(r.score.thesis, *r.score.experiments) for r in results] + foods).T
        scores, shares = np.hsplit(means, 2)
        for arena in THESIS_ARENAS:
            own = scores[:, [r.cell.arena == arena for r in results]]
            rows.append(_joint(f"mean score, {arena} (%)", own.mean(axis=1)))
        rows.append(_joint("sum of all scores (%)", scores.sum(axis=1)))
        rows.append(_joint("mean share of the food (%)", 100 * shares.mean(axis=1)))
        rows += [_steps(arena, recalls) for arena in THESIS_ARENAS]
        off, spread = means - means[1:].mean(axis=0), np.linalg.pinv(np.cov(means[1:].T))
        distances = np.sqrt(((off @ spread) * off).sum(axis=1))
        farther = (1 + int((distances[1:] >= distances[0]).sum())) / len(distances)
        rows.append((*_joint("Mahalanobis distance of all means", distances)[:-1], farther))
    return Table(
        "joint",
        "Results taken together",
        "Several means of the thesis at once, among our experiments of its size. *Percentile* and *tail* as above; of "
        "the distance, the tail is the probability that one more experiment is at least as far from our mean. Medians "
        "of steps are those of recalls that left no food; of the thesis, in lines that do not contradict themselves.",
        (*map(Column, ("measure", "thesis", "ours", "percentile")), Column("tail", 3)),
        rows,
    )


def _joint(name: str, values: Sequence[float] | NDArray[np.float64]) -> tuple[Value, ...]:
    """A line of the joint table, from the thesis's value and ours."""
    thesis, *ours = map(float, values)
    return name, thesis, float(np.mean(ours)) if ours else math.nan, *percentile_rank(thesis, ours)


def _steps(arena: str, recalls: Sequence[RecallRow]) -> tuple[Value, ...]:
    """The median number of steps of the successful recalls in an arena."""
    lines = [line for cell in THESIS if cell.arena == arena for line in usable_lines(cell)]
    own: dict[int, list[int]] = {-1: [line.total for line in lines if not line.points]}
    for row in pick(recalls, arena=arena, learner=IMITATOR, failed=False):
        own.setdefault(row.replication, []).append(row.steps)
    return _joint(f"median steps of successful recalls, {arena}", [*map(np.median, own.values())])


def summary_table(results: Sequence[CellResult], v0_1_results: Sequence[CellResult] = ()) -> Table:
    """The means of each cell in the thesis, in our replications, and in those of version 0.1 if there are any."""
    ours = (Column("ours"), *((Column("v0.1"),) if v0_1_results else ()))
    return Table(
        "summary",
        "Summary",
        "Mean score, and food carried home in an experiment of the thesis's size."
        + (" v0.1: under the decisions of version 0.1." if v0_1_results else ""),
        (
            *(Column("arena"), Column("episodes")),
            *(Column("score (%): thesis", 2), *ours),
            *(Column("food: thesis"), *ours),
        ),
        [
            (
                *(r.cell.arena, r.cell.episodes, r.score.thesis, r.score.ours.value),
                *((old.score.ours.value,) if old else ()),
                *(f"{r.food.thesis} of {r.cell.available}", r.food.ours.value),
                *((old.food.ours.value,) if old else ()),
            )
            for r, old in zip_longest(results, v0_1_results)
        ],
    )


def claim_table(claims: Sequence[Claim]) -> Table:
    """The thesis's claims with effect and verdict."""
    return table_of(
        "claims",
        "Claims of the thesis",
        "Each claim with its effect, a 95 % interval over replications, and a verdict, by the rules of the next table. "
        "All rules were fixed before any data existed, but for those of claims 7 and 8, which counted a difference in "
        "either direction until version 0.2. A claim is undecided if its interval contains the rule's threshold, or "
        "without an interval.",
        [
            {
                "no.": i,
                "claim": c.name,
                "section": c.thesis_section,
                "effect [95 %]": c.effect,
                "value": c.estimate,
                "in the thesis": c.thesis,
                "verdict": c.verdict.value,
            }
            for i, c in enumerate(claims, 1)
        ],
        hidden=("value",),
    )


def rule_table(claims: Sequence[Claim]) -> Table:
    """The measurement behind each claim, and the rule of its verdict."""
    return table_of(
        "rules",
        "Measurements and rules of the verdicts",
        "Ordered by the number of the claim.",
        [{"no.": i, "rule": c.rule.words(c.unit), "what was measured": c.sentence} for i, c in enumerate(claims, 1)],
    )


def errata_table() -> Table:
    """Errors of arithmetic in the thesis's tables."""
    return table_of(
        "errata",
        "Errata of the thesis",
        "Values in tables A.1 to A.7 that do not follow from the values printed beside them. A *series* is a run of "
        "lines that count up by one, as a spreadsheet's fill-down produces them.",
        [erratum._asdict() for erratum in appendix_a.errata()],
    )


def noise_table(rows: Sequence[RecallRow], evidence: Evidence, untrained: Sequence[UntrainedRow] = ()) -> Table:
    """The score under each source of noise alone, and under all together; lines without result are in `untrained`."""
    missing = Counter[str]()
    for row in untrained:
        missing[row.noise] += row.count
    left_out = ", ".join(f"{name} ({missing[name]})" for name in _ordered(set(missing)))
    lines: list[dict[str, Value]] = []
    for cell in _cells_of(rows):
        own = in_cell(rows, cell)
        noiseless = _score(pick(own, noise=NO_NOISE))
        for noise in _ordered({row.noise for row in own} | missing.keys()):
            score = _score(pick(own, noise=noise))
            food = Sample(score.rows, lambda row: 100 * row.delivered, lambda row: row.foods)
            cost = UNKNOWN if noise == NO_NOISE else evidence.difference(noiseless, score)
            attempts = evidence.mean(attempts_per_episode(evidence, noise))
            lines.append(
                {
                    "noise": noise,
                    "arena, episodes": f"{cell.arena}, {cell.episodes}",
                    "score (%)": evidence.mean(score),
                    "cost (points)": cost,
                    "food (%)": evidence.mean(food),
                    "attempts per episode": attempts,
                    "replications": len(replications(score.rows)),
                    "recalls": len(score.rows),
                }
            )
    return table_of(
        "noise",
        "Effect of each source of noise",
        "The same experiments without noise, with one source of noise, and with all sources together, in training and "
        "in recall. The cost is the score without noise minus the score with it. Attempts are counted per complete "
        "training episode. Intervals: 95 % over replications."
        + (f" Replications left out, as no attempt at a training episode was complete: {left_out}." if missing else ""),
        lines,
        {"food (%)": 0, "attempts per episode": 2},
    )


def training_table(evidence: Evidence) -> Table:
    """Attempts per complete training episode, and properties of complete episodes (5.3.1)."""
    lines: list[dict[str, Value]] = []
    for noise in _ordered({row.noise for row in evidence.trainings}):
        rows = pick(evidence.trainings, noise=noise)
        done = pick(rows, complete=True)
        reasons = Counter(row.reason for row in rows if not row.complete)
        listed = "; ".join(f"{reason}: {count}" for reason, count in reasons.most_common())
        lines.append(
            {
                "noise": noise,
                "attempts per episode": evidence.mean(attempts_per_episode(evidence, noise)),
                "attempts": len(rows),
                "complete": len(done),
                "rounds": evidence.mean(Sample(done, lambda row: row.rounds)),
                "experience vectors": evidence.mean(Sample(done, lambda row: row.vectors)),
                "separations": evidence.mean(Sample(done, lambda row: row.separations)),
                "reasons of incomplete attempts": listed or "-",
            }
        )
    return table_of(
        "training",
        "Training episodes",
        "Attempts per complete episode, and means over complete episodes. Intervals: 95 % over replications.",
        lines,
        {"attempts per episode": 2, "rounds": 0, "experience vectors": 0, "separations": 2},
    )


def teacher_table(evidence: Evidence) -> Table:
    """The distribution of the teacher's steps."""
    shares = {"5 %": 0.05, "median": 0.5, "95 %": 0.95, "longest": 1.0}
    lines: list[dict[str, Value]] = []
    for arena in THESIS_ARENAS:
        rows = pick(evidence.teachers, arena=arena)
        limit = LIMITS[arena]
        steps = sorted(map(steps_needed, rows))
        lines.append(
            {
                "arena": arena,
                "forages": len(rows),
                **{k: steps[math.ceil(q * len(steps)) - 1] if steps else math.nan for k, q in shares.items()},
                "thesis's limit": limit,
                "within this limit (%)": evidence.mean(
                    Sample(rows, lambda row: 100 * (steps_needed(row) <= LIMITS[row.arena]))
                ),
            }
        )
    return table_of(
        "teacher",
        "Steps of the teacher",
        "Quantiles of the steps until all food is at home; ∞ means that some food was not delivered within the time "
        "limit, which is three times the thesis's.",
        lines,
        dict.fromkeys(shares, 0),
    )


def ties_table(evidence: Evidence) -> Table:
    """How often several experience vectors were equally near, and how often their behaviours differed (4.6)."""
    lines: list[dict[str, Value]] = []
    for cell in _cells_of(evidence.recalls):
        rows = in_cell(evidence.recalls, cell)
        lines.append(
            {
                "arena": cell.arena,
                "episodes": cell.episodes,
                "experience vectors": evidence.mean(Sample(rows, lambda row: row.experience_size)),
                "ties (% of steps)": evidence.mean(_per_step(rows, lambda row: row.ties)),
                "conflicts (% of steps)": evidence.mean(_per_step(rows, lambda row: row.conflicts)),
            }
        )
    return table_of(
        "ties",
        "Ties among the nearest experience vectors",
        "A tie is a step in which several experience vectors have exactly the minimum distance. A conflict is a tie "
        "between different behaviours, of which one is drawn by its confidence level (4.6.2).",
        lines,
        {"experience vectors": 0},
    )


def state_table(evidence: Evidence) -> Table:
    """The learner's errors by state."""
    lines: list[dict[str, Value]] = []
    for arena in THESIS_ARENAS:
        rows = pick(evidence.recalls, arena=arena)
        modes = Counter(row.failure_mode for row in rows if row.failed)
        for state in list(State)[:STATES]:
            rounds = _rounds_in(state)
            lines.append(
                {
                    "arena": arena,
                    "state": state.name,
                    "steps (%)": evidence.mean(_per_step(rows, rounds)),
                    "wrong (%)": evidence.mean(Sample(rows, _wrong_in(state), rounds)),
                    "failures": modes[state],
                }
            )
    return table_of(
        "states",
        "Errors of the learner by state",
        "By the state that the teacher would classify: share of all steps, share of wrong behaviours in these steps, "
        "and number of failed recalls that had most of their wrong behaviours in this state.",
        lines,
    )


def _cells_of(rows: Iterable[RecallRow]) -> list[Cell]:
    """The thesis's cells that occur in these rows."""
    seen = {(row.arena, row.episodes) for row in rows}
    return [cell for cell in THESIS if (cell.arena, cell.episodes) in seen]


def _score(rows: Sequence[RecallRow]) -> Sample[RecallRow]:
    return Sample(rows, lambda row: row.score)


def _rounds_in(state: State) -> Callable[[RecallRow], float]:
    return lambda row: row.rounds_by_state[state]


def _wrong_in(state: State) -> Callable[[RecallRow], float]:
    return lambda row: 100 * row.wrong_by_state[state]


def _per_step(rows: Sequence[RecallRow], count: Callable[[RecallRow], float]) -> Sample[RecallRow]:
    return Sample(rows, lambda row: 100 * count(row), lambda row: row.steps)


def _ordered(names: set[str]) -> list[str]:
    return [name for name in noise_conditions() if name in names]
