"""`khepera-forage decisions`: the table of everything that the thesis leaves open."""

import argparse

from khepera_forage.task.decisions import decision_table

_COLUMNS = ("decision", "default", "allowed", "thesis")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command's description; it has no arguments."""
    parser.description = (
        "List the decisions: what the thesis leaves open, with our default and the reason for it. "
        "Other commands take them as --decision NAME=VALUE, or all of a version as --decision VERSION."
    )


def run(arguments: argparse.Namespace) -> int:
    """Print a line for each decision, and its meaning below it."""
    rows = decision_table()
    widths = [max(map(len, column)) for column in zip(_COLUMNS, *(row[:4] for row in rows), strict=True)]
    print(_line(_COLUMNS, widths))
    for row in rows:
        print(f"{_line(row[:4], widths)}\n    {row.meaning}")
    return 0


def _line(cells: tuple[str, ...], widths: list[int]) -> str:
    return "  ".join(cell.ljust(width) for cell, width in zip(cells, widths, strict=True)).rstrip()
