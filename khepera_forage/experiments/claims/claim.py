"""A claim of the thesis, its measured effect, and the rule that turns one into a verdict."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from enum import StrEnum
from typing import Protocol

from khepera_forage.experiments.statistics import Estimate

Show = Callable[[float], str]


class Verdict(StrEnum):
    """What the measurement says of a claim."""

    SUPPORTED = "supported"
    NOT_SUPPORTED = "not supported"
    UNDECIDED = "undecided"


class Rule(Protocol):
    """Turns an estimate into a verdict; fixed before there are data."""

    def judge(self, estimate: Estimate) -> Verdict:
        """The verdict; undecided without an interval."""
        ...

    def text(self, show: Show) -> str:
        """The rule in words."""
        ...


@dataclass(frozen=True, slots=True)
class Above:
    """Supported if the whole interval lies above a threshold, not supported if it lies below."""

    threshold: float

    def judge(self, estimate: Estimate) -> Verdict:
        """The verdict."""
        return _verdict(estimate.low > self.threshold, estimate.high < self.threshold)

    def text(self, show: Show) -> str:
        """The rule in words."""
        return f"supported above {show(self.threshold)}, not supported below"


@dataclass(frozen=True, slots=True)
class AtMost:
    """Supported if the whole interval is at most a threshold, not supported if it lies above."""

    threshold: float

    def judge(self, estimate: Estimate) -> Verdict:
        """The verdict."""
        return _verdict(estimate.high <= self.threshold, estimate.low > self.threshold)

    def text(self, show: Show) -> str:
        """The rule in words."""
        return f"supported up to {show(self.threshold)}, not supported above"


@dataclass(frozen=True, slots=True)
class Within:
    """Supported if the whole interval lies within a margin around 0, not supported if it lies beyond."""

    margin: float

    def judge(self, estimate: Estimate) -> Verdict:
        """The verdict."""
        return _verdict(_inside(estimate, self.margin), _beyond(estimate, self.margin))

    def text(self, show: Show) -> str:
        """The rule in words."""
        return f"supported between {show(-self.margin)} and {show(self.margin)}, not supported beyond"


@dataclass(frozen=True, slots=True)
class Beyond:
    """Supported if the whole interval lies on one side beyond a margin around 0, not supported if within."""

    margin: float

    def judge(self, estimate: Estimate) -> Verdict:
        """The verdict."""
        return _verdict(_beyond(estimate, self.margin), _inside(estimate, self.margin))

    def text(self, show: Show) -> str:
        """The rule in words."""
        return f"supported beyond {show(-self.margin)} or {show(self.margin)}, not supported between"


@dataclass(frozen=True, slots=True)
class Claim:
    """One claim of the thesis, measured.

    Attributes:
        name: What is claimed.
        thesis_section: Where.
        effect: The measured effect with its unit and interval.
        value: The effect as a number; nan if there are no rows for it.
        low: Lower end of its 95 % interval; nan if there is none.
        high: Upper end.
        thesis: The same effect in the thesis' own figures, or what it says in words.
        rule: What makes the verdict; an interval that reaches across is undecided.
        verdict: Supported, not supported or undecided.
        sentence: What was measured, with the figures behind it.
    """

    name: str
    thesis_section: str
    effect: str
    value: float
    low: float
    high: float
    thesis: str
    rule: str
    verdict: Verdict
    sentence: str


def judged(
    name: str, section: str, estimate: Estimate, rule: Rule, show: Show, thesis: str, sentence: str
) -> Claim:
    """A claim with the verdict of its rule on an estimate."""
    value, low, high = estimate
    effect = show(value) if math.isnan(low) else f"{show(value)} [{show(low)}, {show(high)}]"
    return Claim(
        name, section, effect, value, low, high, thesis, rule.text(show), rule.judge(estimate), sentence
    )


def points(value: float) -> str:
    """Percentage points of the score, with sign."""
    return _number(value, "+.1f", " points")


def percent(share: float) -> str:
    """A share in percent."""
    return _number(100 * share, ".0f", " %")


def percent_change(difference: float) -> str:
    """A difference of two shares in percentage points, with sign."""
    return _number(100 * difference, "+.0f", " points")


def number(unit: str, digits: int = 0) -> Show:
    """A number with a unit."""
    return lambda value: _number(value, f".{digits}f", f" {unit}")


def _number(value: float, form: str, unit: str) -> str:
    if math.isnan(value):
        return "-"
    return f"{value:{form}}{unit}" if math.isfinite(value) else f"more{unit} than were allowed"


def _inside(estimate: Estimate, margin: float) -> bool:
    return -margin < estimate.low and estimate.high < margin


def _beyond(estimate: Estimate, margin: float) -> bool:
    return estimate.low > margin or estimate.high < -margin


def _verdict(supported: bool, not_supported: bool) -> Verdict:
    """Comparisons with nan are false, so that no interval means undecided."""
    if supported:
        return Verdict.SUPPORTED
    return Verdict.NOT_SUPPORTED if not_supported else Verdict.UNDECIDED
