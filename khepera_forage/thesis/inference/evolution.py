"""New sets from good ones, for the search of the best single set: within the prior, and under its rules."""

import math
from collections.abc import Sequence
from typing import Any

from numpy.random import Generator

from khepera_forage.task.decisions import Decisions
from khepera_forage.thesis.inference.prior import Prior, Range, Shares, draw_value, possible_decisions

OTHER_PARENT = 0.3
"""Probability that a field comes from the second parent."""
CHANGED = 0.2
"""Probability that a field is changed."""
STEP = 0.15
"""Standard deviation of a change, as a share of the prior's range."""
STEPS_OF_A_RANGE = 8
"""A range has at least this many steps from one natural value to the next."""
COARSE_STEPS_OF_A_RANGE = 4
"""The same for values that are simpler still."""
_TRIES = 10_000


def child(prior: Prior, parents: Sequence[Decisions], rng: Generator) -> Decisions:
    """A set with natural values whose fields come from two random parents, some of them changed.

    Args:
        prior: Its ranges are kept.
        parents: The better stand first, and are drawn more often.
        rng: To draw from.

    Raises:
        ValueError: No child satisfies the rules between decisions.
    """
    problem = ""
    for _ in range(_TRIES):
        first, second = (parents[int(len(parents) * rng.random() ** 2)] for _ in range(2))
        values = {}
        for name, part in prior.decisions.items():
            value = getattr(second if rng.random() < OTHER_PARENT else first, name)
            values[name] = _changed(part, value, rng) if rng.random() < CHANGED else value
        try:
            return natural(possible_decisions(values), prior)
        except ValueError as error:
            problem = str(error)
    raise ValueError(f"none of {_TRIES} children is possible; the last one: {problem}")


def _changed(part: Range | Shares, value: Any, rng: Generator) -> Any:
    if isinstance(part, Shares):
        return draw_value(part, rng)
    moved = value + STEP * (part.most - part.least) * rng.standard_normal()
    return float(min(max(moved, part.least), part.most))


def natural(decisions: Decisions, prior: Prior) -> Decisions:
    """The set with natural values: multiples of 1, 2 or 5 times a power of ten that are fine enough for the prior.

    Args:
        decisions: A set.
        prior: Its ranges are kept; fields that it does not draw get the values of version 0.1.

    Raises:
        ValueError: The rounded values break a rule between decisions.
    """
    values = {name: getattr(decisions, name) for name in prior.decisions}
    for name, part in prior.decisions.items():
        if isinstance(part, Range):
            values[name] = _nearest(part, values[name], natural_step(part))
    return possible_decisions(values)


def simpler_values(decisions: Decisions, name: str, prior: Prior) -> list[Any]:
    """What a field could be instead, the simplest first: the value of version 0.1, then rounder numbers.

    Args:
        decisions: A set.
        name: Of a field that the prior draws.
        prior: Its ranges are kept.

    Returns:
        No values if the field has that of version 0.1 already.
    """
    value, part = getattr(decisions, name), prior.decisions[name]
    values = [getattr(Decisions.v0_1(), name)]
    if isinstance(part, Range):
        values = [*values, _nearest(part, value, natural_step(part, COARSE_STEPS_OF_A_RANGE))]
        values = [one for one in dict.fromkeys(values) if part.least <= one <= part.most]
    return values[: values.index(value)] if value in values else values


def _nearest(part: Range, value: Any, step: float) -> Any:
    """The multiple of a step that is nearest to a value, within the range, as the same type."""
    return type(value)(round(min(max(round(value / step) * step, part.least), part.most), 6))


def natural_step(part: Range, steps: int = STEPS_OF_A_RANGE) -> float:
    """The largest of 1, 2 and 5 times a power of ten that divides a range into at least so many steps."""
    finest = (part.most - part.least) / steps
    power = 10.0 ** math.floor(math.log10(finest))
    return max(factor * power for factor in (1, 2, 5) if factor * power <= finest * (1 + 1e-9))
