"""All decisions as a table: for the command line, and for the page docs/decisions.md."""

from dataclasses import fields
from typing import NamedTuple

from khepera_forage.task.decision_fields import Field
from khepera_forage.task.decisions import Decisions


class DecisionRow(NamedTuple):
    """One decision, as text.

    Attributes:
        name: Of the field of `Decisions`.
        value: In the set of decisions that is shown, with its unit.
        allowed: The values that the field accepts.
        section: Of the thesis, where it leaves this open.
        meaning: What the field means, and why it has its default.
    """

    name: str
    value: str
    allowed: str
    section: str
    meaning: str


def decision_table(decisions: Decisions | None = None) -> list[DecisionRow]:
    """One row for each field of `Decisions`, in their order.

    Args:
        decisions: Where the values come from; the defaults if left out.
    """
    decisions = Decisions() if decisions is None else decisions
    rows = []
    for name, known in ((field.name, Field.of(field)) for field in fields(Decisions)):
        value = getattr(decisions, name)
        rows.append(
            DecisionRow(
                name,
                value if known.choices else f"{value:g} {known.unit}",
                "; ".join(known.choices) if known.choices else f"{known.least:g} to {known.most:g}",
                known.section,
                known.reason,
            )
        )
    return rows


def markdown_table() -> str:
    """The default decisions as a table in Markdown."""
    lines = ["| decision | default | allowed | thesis | meaning |", "|---|---|---|---|---|"]
    lines += [f"| `{row.name}` | {' | '.join(row[1:])} |" for row in decision_table()]
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    print(markdown_table(), end="")
