"""Decisions as text for files and rows, and as a table for readers.

Headers of files and columns of rows have texts such as `v0.1;next_to_food=22;round_duration=0.2`. The text names a
version and what differs from it, so it keeps its meaning when the defaults change. Text without a version, which files
had before there were versions, is relative to version 0.1.
"""

from collections.abc import Sequence
from typing import Any, NamedTuple

from khepera_forage.task.decision_versions import PRESENT
from khepera_forage.task.decisions import DEFAULT_DECISIONS, FIELDS, Decisions

_SEPARATOR = ";"
_FIRST = "v0.1"
VERSIONS = {_FIRST: Decisions.v0_1(), PRESENT: DEFAULT_DECISIONS}
"""All versions by name, the oldest first."""
_ALLOWED = ", ".join(map(repr, VERSIONS))


def decisions_text(decisions: Decisions) -> str:
    """The version that differs least, the oldest of several, and the fields that differ from it."""
    changes = {name: decisions.differing(version) for name, version in VERSIONS.items()}
    nearest = min(changes, key=lambda name: len(changes[name]))
    return _SEPARATOR.join(
        (nearest, *(_assignment(name, own) for name, (own, _) in changes[nearest].items()))
    )


def decisions_from_text(text: str) -> Decisions:
    """The decisions that a text of `decisions_text` describes.

    Raises:
        ValueError: Not of this form, an unknown version or field, or a value that is not allowed.
    """
    base, assignments = _split(text.split(_SEPARATOR) if text else [], _FIRST)
    decisions = Decisions.parse(assignments, base)
    for assignment in assignments:
        name = assignment.partition("=")[0]
        expected = _assignment(name, getattr(decisions, name))
        if assignment != expected:  # such as ' 17', '1_7' or '17.0', which Python reads as the same number
            raise ValueError(f"decision {assignment!r}; allowed: {expected!r}")
    return decisions


def decisions_from_words(words: Sequence[str]) -> Decisions:
    """The decisions that a user wrote on a command line.

    Args:
        words: First the name of a version, or nothing for the defaults; then assignments such as `next_to_food=22`.

    Raises:
        ValueError: An unknown version, or as for `Decisions.parse`.
    """
    base, assignments = _split(words, PRESENT)
    return Decisions.parse(assignments, base)


def differences(decisions: Decisions, other: Decisions) -> str:
    """The fields in which two sets differ, with both values, for error messages."""
    return "; ".join(
        f"{name} is {_value_text(own)}, not {_value_text(others)}"
        for name, (own, others) in decisions.differing(other).items()
    )


def _split(words: Sequence[str], version: str) -> tuple[Decisions, Sequence[str]]:
    """The version that the first word names, by default another one, and the remaining words."""
    if words and words[0].startswith("v") and "=" not in words[0]:
        version, *words = words
        if version not in VERSIONS:
            raise ValueError(f"version {version!r} of the decisions is unknown; allowed: {_ALLOWED}")
    return VERSIONS[version], words


def _assignment(name: str, value: Any) -> str:
    return f"{name}={_value_text(value)}"


def _value_text(value: Any) -> str:
    return str(value).removesuffix(".0")


class DecisionRow(NamedTuple):
    """One decision, as text.

    Attributes:
        name: Of the field of `Decisions`.
        default: With its unit.
        allowed: The values that the field accepts.
        section: Of the thesis, where it leaves this open.
        meaning: What the field means, and why it has its default.
    """

    name: str
    default: str
    allowed: str
    section: str
    meaning: str


def decision_table() -> list[DecisionRow]:
    """One row for each field of `Decisions`, in their order."""
    rows = []
    for name, field in FIELDS.items():
        default = getattr(DEFAULT_DECISIONS, name)
        shown = default if field.choices else f"{default:g} {field.unit}"
        allowed = "; ".join(field.choices) if field.choices else f"{field.least:g} to {field.most:g}"
        rows.append(DecisionRow(name, shown, allowed, field.section, field.reason))
    return rows


def markdown_table() -> str:
    """The default decisions as a table in Markdown, for the page docs/decisions.md."""
    lines = ["| decision | default | allowed | thesis | meaning |", "|---|---|---|---|---|"]
    lines += [f"| `{row.name}` | {' | '.join(row[1:])} |" for row in decision_table()]
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    print(markdown_table(), end="")
