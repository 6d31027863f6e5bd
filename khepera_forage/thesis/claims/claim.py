"""A claim of the thesis, its measured effect, and the rule that gives the verdict."""

import math
from dataclasses import dataclass
from enum import StrEnum
from typing import Protocol

from khepera_forage.estimates import Estimate


@dataclass(frozen=True, slots=True)
class Unit:
    """A unit of measurement, and the format of numbers in it.

    Attributes:
        suffix: Name of the unit.
        form: Format specification of the number.
        scale: Factor by which a number is multiplied before it is written.
    """

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


class Rule(Protocol):
    """Gives the verdict on an estimate; fixed before any data exist."""

    def judge(self, estimate: Estimate) -> Verdict:
        """The verdict; undecided if the estimate has no interval."""
        ...

    def text(self, show: Unit) -> str:
        """The rule in words."""
        ...


@dataclass(frozen=True, slots=True)
class Above:
    """Supported if the whole interval lies above a threshold, not supported if no part of it does."""

    threshold: float

    def judge(self, estimate: Estimate) -> Verdict:
        """The verdict."""
        return _verdict(estimate.low > self.threshold, estimate.high <= self.threshold)

    def text(self, show: Unit) -> str:
        """The rule in words."""
        return f"supported above {show(self.threshold)}, not supported below"


@dataclass(frozen=True, slots=True)
class Below:
    """Supported if the whole interval lies below a threshold, not supported if no part of it does."""

    threshold: float

    def judge(self, estimate: Estimate) -> Verdict:
        """The verdict."""
        return _verdict(estimate.high < self.threshold, estimate.low >= self.threshold)

    def text(self, show: Unit) -> str:
        """The rule in words."""
        return f"supported below {show(self.threshold)}, not supported above"


@dataclass(frozen=True, slots=True)
class AtMost:
    """Supported if the whole interval is at most a threshold, not supported if it lies above."""

    threshold: float

    def judge(self, estimate: Estimate) -> Verdict:
        """The verdict."""
        return _verdict(estimate.high <= self.threshold, estimate.low > self.threshold)

    def text(self, show: Unit) -> str:
        """The rule in words."""
        return f"supported up to {show(self.threshold)}, not supported above"


@dataclass(frozen=True, slots=True)
class Within:
    """Supported if the whole interval lies within a margin around 0, not supported if it lies beyond."""

    margin: float

    def judge(self, estimate: Estimate) -> Verdict:
        """The verdict."""
        return _verdict(_inside(estimate, self.margin), _beyond(estimate, self.margin))

    def text(self, show: Unit) -> str:
        """The rule in words."""
        return f"supported between {show(-self.margin)} and {show(self.margin)}, not supported beyond"


@dataclass(frozen=True, slots=True)
class Beyond:
    """Supported if the whole interval lies on one side beyond a margin around 0, not supported if within."""

    margin: float

    def judge(self, estimate: Estimate) -> Verdict:
        """The verdict."""
        return _verdict(_beyond(estimate, self.margin), _inside(estimate, self.margin))

    def text(self, show: Unit) -> str:
        """The rule in words."""
        return f"supported beyond {show(-self.margin)} or {show(self.margin)}, not supported between"


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
    """Make a claim with the verdict of its rule on an estimate.

    Args:
        name: The claim in words.
        section: Section of the thesis that makes it.
        estimate: The measured effect.
        rule: Gives the verdict.
        show: The unit of the effect.
        thesis: The same effect in the thesis: its figure, or its words.
        sentence: The measurement in words, with its figures.
    """
    effect = show.estimate(estimate)
    return Claim(
        name, section, effect, *estimate, show, thesis, rule.text(show), rule.judge(estimate), sentence
    )


def _inside(estimate: Estimate, margin: float) -> bool:
    return -margin < estimate.low and estimate.high < margin


def _beyond(estimate: Estimate, margin: float) -> bool:
    return estimate.low > margin or estimate.high < -margin


def _verdict(supported: bool, not_supported: bool) -> Verdict:
    """The verdict from two comparisons; both are false, and the claim is undecided, if the interval is nan."""
    if supported:
        return Verdict.SUPPORTED
    return Verdict.NOT_SUPPORTED if not_supported else Verdict.UNDECIDED
