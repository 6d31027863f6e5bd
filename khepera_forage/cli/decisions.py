"""`khepera-forage decisions`: the table of everything that the thesis leaves open."""

import argparse
from dataclasses import fields

from khepera_forage.task.decision_fields import Field
from khepera_forage.task.decisions import DEFAULT_DECISIONS, Decisions

_COLUMNS = ("decision", "default", "allowed", "thesis")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command's description; it has no arguments."""
    parser.description = (
        "List the decisions: what the thesis leaves open, with our default and the reason for it. "
        "Other commands take them as --decision NAME=VALUE, or all of a version as --decision VERSION."
    )


def run(arguments: argparse.Namespace) -> int:
    """Print a line for each decision, and its reason below it."""
    known = [Field.of(field) for field in fields(Decisions)]
    lines = [_COLUMNS, *map(_line, known)]
    widths = [max(len(line[i]) for line in lines) for i in range(len(_COLUMNS))]
    reasons = ["", *(field.reason for field in known)]
    for line, reason in zip(lines, reasons, strict=True):
        cells = (cell.ljust(width) for cell, width in zip(line, widths, strict=True))
        print("  ".join(cells).rstrip())
        if reason:
            print(f"    {reason}")
    return 0


def _line(field: Field) -> tuple[str, str, str, str]:
    """Name, default with its unit, allowed values and section."""
    default = getattr(DEFAULT_DECISIONS, field.name)
    shown = default if field.choices else f"{default:g} {field.unit}"
    allowed = " | ".join(field.choices) if field.choices else f"{field.least:g} to {field.most:g}"
    return field.name, shown, allowed, field.section
