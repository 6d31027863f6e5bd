"""A claim of the thesis, its measured effect, and the rule that gives the verdict."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from enum import StrEnum
from typing import NamedTuple

from khepera_forage.estimates import Estimate


@dataclass(frozen=True, slots=True)
class Unit:
    """A unit of measurement; numbers are multiplied by `scale`, and written in the format `form`."""

    suffix: str
    form: str = ".0f"
    scale: float = 1.0

    def __call__(self, value: float) -> str:
        """A number with its unit; a dash for nan."""
        number = self._number(value)
        return number if number == "-" else f"{number} {self.suffix}"

    def estimate(self, estimate: Estimate) -> str:
        """A value with its interval in brackets, if it has one."""
        value, low, high = map(self._number, estimate)
        return self(estimate.value) if low == "-" else f"{value} [{low}, {high}] {self.suffix}"

    def _number(self, value: float) -> str:
        if math.isnan(value):
            return "-"
        if value == 0:
            return "0"
        return f"{self.scale * value:{self.form}}" if math.isfinite(value) else "∞"


points = Unit("points", "+.1f")
"""Percentage points of the score."""
percent = Unit("%", scale=100.0)
"""A share, in percent."""
percent_change = Unit("points", "+.0f", 100.0)
"""A difference of two shares, in percentage points."""


class Verdict(StrEnum):
    """The result of measuring a claim."""

    SUPPORTED = "supported"
    NOT_SUPPORTED = "not supported"
    UNDECIDED = "undecided"


class Rule(NamedTuple):
    """Gives the verdict on an estimate; fixed before any data exist.

    An estimate without interval, or with one that reaches across the threshold, is undecided.

    Attributes:
        words: The rule in words, in a unit.
        supported: Whether the whole interval supports the claim.
        not_supported: Whether no part of it does.
    """

    words: Callable[[Unit], str]
    supported: Callable[[Estimate], bool]
    not_supported: Callable[[Estimate], bool]

    def judge(self, estimate: Estimate) -> Verdict:
        """The verdict; comparisons with nan are false."""
        if self.supported(estimate):
            return Verdict.SUPPORTED
        return Verdict.NOT_SUPPORTED if self.not_supported(estimate) else Verdict.UNDECIDED


def above(threshold: float) -> Rule:
    """Supported if the whole interval lies above a threshold."""
    return Rule(
        lambda show: f"supported above {show(threshold)}, not supported below",
        lambda estimate: estimate.low > threshold,
        lambda estimate: estimate.high <= threshold,
    )


def below(threshold: float) -> Rule:
    """Supported if the whole interval lies below a threshold."""
    return Rule(
        lambda show: f"supported below {show(threshold)}, not supported above",
        lambda estimate: estimate.high < threshold,
        lambda estimate: estimate.low >= threshold,
    )


def at_most(threshold: float) -> Rule:
    """Supported if the whole interval is at most a threshold."""
    return Rule(
        lambda show: f"supported up to {show(threshold)}, not supported above",
        lambda estimate: estimate.high <= threshold,
        lambda estimate: estimate.low > threshold,
    )


def within(margin: float) -> Rule:
    """Supported if the whole interval lies within a margin around 0, not supported if it lies beyond."""
    return Rule(
        lambda show: f"supported between {show(-margin)} and {show(margin)}, not supported beyond",
        lambda estimate: _inside(estimate, margin),
        lambda estimate: _outside(estimate, margin),
    )


def beyond(margin: float) -> Rule:
    """Supported if the whole interval lies on one side beyond a margin around 0, not supported if within."""
    return Rule(
        lambda show: f"supported beyond {show(-margin)} or {show(margin)}, not supported between",
        lambda estimate: _outside(estimate, margin),
        lambda estimate: _inside(estimate, margin),
    )


@dataclass(frozen=True, slots=True)
class Claim:
    """One claim of the thesis, measured.

    Attributes:
        name: The claim in words.
        thesis_section: Section of the thesis that makes it.
        effect: The measured effect with its unit and interval.
        value: The effect as a number; nan if there are no rows for it.
        low: Lower end of its 95 % interval; nan if there is none.
        high: Upper end of the interval.
        unit: Of value, low and high.
        thesis: The same effect in the thesis: its figure, or its words.
        rule: The rule of the verdict; a claim whose interval contains the threshold is undecided.
        verdict: Supported, not supported or undecided.
        sentence: The measurement in words, with its figures.
    """

    name: str
    thesis_section: str
    effect: str
    value: float
    low: float
    high: float
    unit: Unit
    thesis: str
    rule: str
    verdict: Verdict
    sentence: str


def judged(
    name: str, section: str, estimate: Estimate, rule: Rule, show: Unit, thesis: str, sentence: str
) -> Claim:
    """Make a claim with the verdict of its rule on an estimate, shown in a unit."""
    effect, verdict = show.estimate(estimate), rule.judge(estimate)
    return Claim(name, section, effect, *estimate, show, thesis, rule.words(show), verdict, sentence)


def _inside(estimate: Estimate, margin: float) -> bool:
    return -margin < estimate.low and estimate.high < margin


def _outside(estimate: Estimate, margin: float) -> bool:
    return estimate.low > margin or estimate.high < -margin
