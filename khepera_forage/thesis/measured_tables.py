"""Tables of what the thesis did not measure: noise, training, the teacher, ties, and where it goes wrong."""

import math
from collections import Counter
from collections.abc import Iterable, Sequence

from khepera_forage.rollouts.rows import STATES, RecallRow
from khepera_forage.task.states import State
from khepera_forage.thesis.cells import in_cell
from khepera_forage.thesis.claims import ARENAS
from khepera_forage.thesis.claims.evidence import Evidence, Sample, of_arena
from khepera_forage.thesis.claims.time import attempts_per_episode, steps_needed
from khepera_forage.thesis.design import NO_NOISE, THESIS, Cell, noise_conditions
from khepera_forage.thesis.statistics import UNKNOWN, Estimate, Measure, replications
from khepera_forage.thesis.tables import Column, Table, Value


def noise_table(rows: Sequence[RecallRow], evidence: Evidence) -> Table:
    """Score against each trouble of the laboratory alone and all together."""
    lines: list[tuple[Value, ...]] = []
    for cell in _cells_of(rows):
        quiet = _score(_of_noise(rows, cell, NO_NOISE))
        for noise in _ordered({row.noise for row in in_cell(rows, cell)}):
            score = _score(_of_noise(rows, cell, noise))
            food = Sample(score.rows, lambda row: 100 * row.delivered, lambda row: row.foods)
            cost = UNKNOWN if noise == NO_NOISE else evidence.difference(quiet, score)
            attempts = evidence.mean(attempts_per_episode(evidence, noise))
            numbers: tuple[Estimate, ...] = (evidence.mean(score), cost, evidence.mean(food), attempts)
            lines.append(
                (
                    noise,
                    f"{cell.arena}, {cell.episodes}",
                    *numbers,
                    len(replications(score.rows)),
                    len(score.rows),
                )
            )
    return Table(
        "noise",
        "What each of the laboratory's troubles costs",
        "The same experiment with no noise, with one source alone, and with all together, in training and in "
        "recall; the cost is the score lost against no noise. Attempts are those for one complete training "
        "episode. Intervals: 95 % over replications.",
        (
            Column("noise"),
            Column("arena, episodes"),
            Column("score (%)", 1, estimate=True),
            Column("cost (points)", 1, estimate=True),
            Column("food (%)", 0, estimate=True),
            Column("attempts an episode", 2, estimate=True),
            Column("replications"),
            Column("recalls"),
        ),
        lines,
    )


def training_table(evidence: Evidence) -> Table:
    """Attempts for a complete training episode (5.3.1)."""
    lines: list[tuple[Value, ...]] = []
    for noise in _ordered({row.noise for row in evidence.trainings}):
        rows = [row for row in evidence.trainings if row.noise == noise]
        done = [row for row in rows if row.complete]
        reasons = Counter(row.reason for row in rows if not row.complete)
        lines.append(
            (
                noise,
                evidence.mean(attempts_per_episode(evidence, noise)),
                len(rows),
                len(done),
                evidence.mean(Sample(done, lambda row: row.rounds)),
                evidence.mean(Sample(done, lambda row: row.vectors)),
                evidence.mean(Sample(done, lambda row: row.separations)),
                "; ".join(f"{reason}: {count}" for reason, count in reasons.most_common()) or "-",
            )
        )
    return Table(
        "training",
        "Training episodes",
        "Attempts for one complete episode, and what a complete episode is like; 95 % intervals over "
        "replications.",
        (
            Column("noise"),
            Column("attempts an episode", 2, estimate=True),
            Column("attempts"),
            Column("complete"),
            Column("rounds", 0, estimate=True),
            Column("experience vectors", 0, estimate=True),
            Column("separations", 2, estimate=True),
            Column("why others ended"),
        ),
        lines,
    )


def teacher_table(evidence: Evidence) -> Table:
    """The teacher's own distribution of steps."""
    lines: list[tuple[Value, ...]] = []
    for arena in ARENAS:
        rows = of_arena(evidence.teachers, arena)
        limit = next(cell.limit for cell in THESIS if cell.arena == arena)
        steps = sorted(map(steps_needed, rows))
        at = [steps[math.ceil(q * len(steps)) - 1] if steps else math.nan for q in (0.05, 0.5, 0.95, 1.0)]
        within = evidence.mean(_ended_within(rows, limit))
        lines.append((arena, len(rows), *at, limit, within))
    return Table(
        "teacher",
        "How long the teacher takes",
        "Steps until all food is at home, by quantile; ∞ where some was not brought within the limit of the "
        "run.",
        (
            Column("arena"),
            Column("forages"),
            Column("5 %", 0),
            Column("median", 0),
            Column("95 %", 0),
            Column("longest", 0),
            Column("thesis' limit"),
            Column("within it (%)", 1, estimate=True),
        ),
        lines,
    )


def ties_table(evidence: Evidence) -> Table:
    """How often several experience vectors were equally near, and how often they disagreed (4.6)."""
    lines: list[tuple[Value, ...]] = []
    for cell in _cells_of(evidence.recalls):
        rows = in_cell(evidence.recalls, cell)
        shares = [_per_step(rows, lambda row: row.ties), _per_step(rows, lambda row: row.conflicts)]
        size = evidence.mean(Sample(rows, lambda row: row.experience_size))
        lines.append((cell.arena, cell.episodes, size, *map(evidence.mean, shares)))
    return Table(
        "ties",
        "Ties among the nearest experience vectors",
        "Share of all steps in which several vectors lay at exactly the minimum distance, and in which these "
        "stood for different behaviours, so that one was drawn by confidence level (4.6.2).",
        (
            Column("arena"),
            Column("episodes"),
            Column("experience vectors", 0, estimate=True),
            Column("ties (% of steps)", 1, estimate=True),
            Column("conflicts (% of steps)", 1, estimate=True),
        ),
        lines,
    )


def state_table(evidence: Evidence) -> Table:
    """In which states the learner goes wrong."""
    lines: list[tuple[Value, ...]] = []
    for arena in ARENAS:
        rows = of_arena(evidence.recalls, arena)
        modes = Counter(row.failure_mode for row in rows if row.failed)
        for state in list(State)[:STATES]:
            visited = _per_step(rows, _in_state(state))
            wrong = Sample(rows, _wrong_in(state), _in_state(state))
            lines.append((arena, state.name, evidence.mean(visited), evidence.mean(wrong), modes[state]))
    return Table(
        "states",
        "Where the learner goes wrong",
        "By the state that the teacher would see: share of all steps, share of these that were wrong, and "
        "the number of failed recalls that went wrong most often there.",
        (
            Column("arena"),
            Column("state"),
            Column("steps (%)", 1, estimate=True),
            Column("wrong (%)", 1, estimate=True),
            Column("failures"),
        ),
        lines,
    )


def _cells_of(rows: Iterable[RecallRow]) -> list[Cell]:
    """The thesis' cells that occur in these rows."""
    seen = {(row.arena, row.episodes) for row in rows}
    return [cell for cell in THESIS if (cell.arena, cell.episodes) in seen]


def _of_noise(rows: Iterable[RecallRow], cell: Cell, noise: str) -> list[RecallRow]:
    return [row for row in in_cell(rows, cell) if row.noise == noise]


def _score(rows: Sequence[RecallRow]) -> Sample[RecallRow]:
    return Sample(rows, lambda row: row.score)


def _per_step(rows: Sequence[RecallRow], count: Measure[RecallRow]) -> Sample[RecallRow]:
    return Sample(rows, lambda row: 100 * count(row), lambda row: row.steps)


def _ordered(names: set[str]) -> list[str]:
    """Noise conditions in the order of `noise_conditions`, others after them."""
    known = list(noise_conditions())
    return sorted(names, key=lambda name: (known.index(name) if name in known else len(known), name))


def _in_state(state: State) -> Measure[RecallRow]:
    return lambda row: row.rounds_by_state[state]


def _wrong_in(state: State) -> Measure[RecallRow]:
    return lambda row: 100 * row.wrong_by_state[state]


def _ended_within(rows: Sequence[RecallRow], limit: int) -> Sample[RecallRow]:
    return Sample(rows, lambda row: 100 * (steps_needed(row) <= limit))
