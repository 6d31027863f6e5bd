"""The best set without changes that the tables do not ask for."""

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

from khepera_forage.task.decisions import Decisions
from khepera_forage.thesis.inference.evolution import simpler_values
from khepera_forage.thesis.inference.prior import Prior, possible_decisions

TOLERANCE = 0.2
"""Misfit that a simpler set may have more than the set from which it began."""


class Judgement(NamedTuple):
    """How well a set fits.

    Attributes:
        misfit: Infinity if the set is not admissible.
        outcome: Why it is not admissible, or `admissible`.
    """

    misfit: float
    outcome: str


class Trial(NamedTuple):
    """A field that was given a simpler value.

    Attributes:
        name: Of the field.
        value: Before.
        simpler: The value that was tried.
        judgement: Of the set with it.
        accepted: Whether the set keeps it.
    """

    name: str
    value: Any
    simpler: Any
    judgement: Judgement
    accepted: bool


def simplify(
    start: Decisions,
    misfit: float,
    prior: Prior,
    judge: Callable[[Decisions, int], Judgement],
    passes: int,
    fields: Sequence[str] = (),
) -> tuple[Decisions, list[Trial]]:
    """Give each field in turn the value of version 0.1, or a rounder one, unless the set then fits worse.

    Fields are tried again, because one change can make room for another.

    Args:
        start: The best set.
        misfit: Its own, by the same judge.
        prior: Its ranges and rules are kept.
        judge: Takes a set and the number of the trial, from 1.
        passes: Through all fields, at most.
        fields: Names of the fields that are tried; by default all decisions of the prior.

    Returns:
        The simpler set, and all trials.
    """
    most = misfit + TOLERANCE
    current, trials = start, list[Trial]()
    for _ in range(passes):
        before = current
        for name in fields or tuple(prior.decisions):
            current = _simplify_field(current, name, prior, judge, most, trials)
        if current == before:
            break
    return current, trials


def _simplify_field(
    current: Decisions,
    name: str,
    prior: Prior,
    judge: Callable[[Decisions, int], Judgement],
    most: float,
    trials: list[Trial],
) -> Decisions:
    """The set with the simplest value of a field that fits, after these trials; they are added."""
    for simpler in simpler_values(current, name, prior):
        values = {field: getattr(current, field) for field in prior.decisions}
        try:
            candidate = possible_decisions(values | {name: simpler})
        except ValueError:
            continue
        judgement = judge(candidate, len(trials) + 1)
        accepted = judgement.misfit <= most
        trials.append(Trial(name, values[name], simpler, judgement, accepted))
        if accepted:
            return candidate
    return current
