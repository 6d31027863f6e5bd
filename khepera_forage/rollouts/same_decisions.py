"""Checks that rows were made under the same decisions, so that no report mixes several readings of the thesis."""

import csv
from collections.abc import Iterable
from pathlib import Path
from typing import Protocol

from khepera_forage.rollouts.rows import row_decisions
from khepera_forage.task.decisions import DEFAULT_DECISIONS, Decisions, decisions_text, differences


class _Row(Protocol):
    """A row with a column `decisions`."""

    @property
    def decisions(self) -> str:
        """Text of the decisions."""
        ...


def common_decisions(*tables: Iterable[_Row]) -> Decisions:
    """The decisions of all rows of some tables; the defaults without rows.

    Raises:
        ValueError: Rows of different decisions.
    """
    texts = list(dict.fromkeys(row.decisions for table in tables for row in table))
    first, *others = [row_decisions(text) for text in texts] or [DEFAULT_DECISIONS]
    for other in others:
        if other != first:
            raise ValueError(
                f"rows of different decisions: {differences(other, first)}; "
                "allowed: rows of the same decisions in one report"
            )
    return first


def refuse_other_decisions(path: Path, decisions: Decisions) -> None:
    """Check that an existing file of rows may be replaced by rows of certain decisions.

    Only the first row is read. A file without a column `decisions`, which version 0.1 wrote, is of the decisions of
    version 0.1. A file without rows, or that does not exist, is of none.

    Raises:
        ValueError: The file has rows of other decisions.
    """
    if not path.exists():
        return
    with open(path, encoding="utf-8", newline="") as file:
        row = next(csv.DictReader(file), None)
    if row is None:
        return
    try:
        found = row_decisions(row.get("decisions") or "")
    except ValueError as error:
        raise ValueError(f"{path}:2: {error}") from error
    if found != decisions:
        raise ValueError(
            f"{path} has rows of other decisions: {differences(found, decisions)}; allowed: the same decisions "
            f"(now {decisions_text(decisions)}), another --out, or no such file"
        )
