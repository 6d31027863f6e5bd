"""Decisions as text: `next_to_food=22;round_duration=0.2`, in the headers of files and in the columns of rows."""

from typing import Any

from khepera_forage.task.decisions import Decisions

_SEPARATOR = ";"


def decisions_text(decisions: Decisions) -> str:
    """The fields that differ from the defaults, with their values; empty for the default decisions."""
    return _SEPARATOR.join(_assignment(name, value) for name, value in decisions.changed().items())


def decisions_from_text(text: str) -> Decisions:
    """The decisions that a text of `decisions_text` describes.

    Raises:
        ValueError: Not of this form, an unknown field, or a value that is not allowed.
    """
    if not text:
        return Decisions()
    assignments = text.split(_SEPARATOR)
    decisions = Decisions.parse(assignments)
    for assignment in assignments:
        name = assignment.partition("=")[0]
        expected = _assignment(name, getattr(decisions, name))
        if assignment != expected:  # such as ' 17', '1_7' or '17.0', which Python reads as the same number
            raise ValueError(f"decision {assignment!r}; allowed: {expected!r}")
    return decisions


def differences(decisions: Decisions, other: Decisions) -> str:
    """The fields in which two sets differ, with both values, for error messages."""
    return "; ".join(
        f"{name} is {_value_text(own)}, not {_value_text(others)}"
        for name, (own, others) in decisions.differing(other).items()
    )


def _assignment(name: str, value: Any) -> str:
    return f"{name}={_value_text(value)}"


def _value_text(value: Any) -> str:
    return str(value).removesuffix(".0")
