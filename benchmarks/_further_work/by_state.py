"""Recall by the state that the teacher would see: where the time goes, and where it goes wrong."""

from collections.abc import Callable, Iterable, Sequence

import numpy as np

from _further_work.measures import Measure, mean
from _further_work.rows import Recalled
from khepera_forage.task.states import State
from khepera_forage.thesis.tables import Column, Table, Value

STATES = tuple(state for state in State if state != State.UNKNOWN)


def spent(state: State) -> Measure[Recalled]:
    """Steps in a state, of all steps."""
    return Measure("steps (%)", lambda row: 100.0 * row.rounds_by_state[state], lambda row: float(row.steps))


def wrong(state: State) -> Measure[Recalled]:
    """Steps in a state in which the teacher would have done something else, of all steps in it."""
    return Measure(
        "wrong (%)",
        lambda row: 100.0 * row.wrong_by_state[state],
        lambda row: float(row.rounds_by_state[state]),
    )


def occurring(rows: Iterable[Recalled]) -> list[State]:
    """The states that occur in these recalls."""
    rows = list(rows)
    return [state for state in STATES if any(row.rounds_by_state[state] for row in rows)]


def states_table(
    title: str,
    note: str,
    groups: Sequence[tuple[str, Sequence[tuple[str, Sequence[Recalled]]]]],
    measures: Sequence[Callable[[State], Measure[Recalled]]],
    rng: np.random.Generator,
) -> Table:
    """State by state, what of the steps was spent in it, or wrong there.

    Args:
        title: Heading.
        note: What is in it.
        groups: An arena each, with the recalls there of every condition by its name.
        measures: `spent`, `wrong`, or both.
        rng: Draws the resamples.
    """
    lines: list[tuple[Value, ...]] = []
    for arena, conditions in groups:
        for state in STATES:
            for condition, rows in conditions:
                if state in occurring(rows):
                    shares = (mean(rows, measure(state), rng) for measure in measures)
                    lines.append((arena, state.name, condition, *shares))
    columns = [Column("arena"), Column("state"), Column("condition")]
    columns += [Column(measure(State.SEARCH).name, 1, estimate=True) for measure in measures]
    return Table("states", title, note, tuple(columns), lines)
