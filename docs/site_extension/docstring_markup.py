"""Docstrings are written in Markdown; autodoc reads reStructuredText. This module translates the one to the other."""

import re
from collections.abc import Iterator, Sequence
from itertools import groupby

_CODE = re.compile(r"(?<![`:\w])`([^`]+)`(?!`)")
"""Code in single backticks, which may go on in the next line."""


def to_rst(lines: Sequence[str]) -> list[str]:
    """Translate a docstring: headings, tables, fenced code and code in the text.

    Args:
        lines: Without the indentation that they share. Google's sections (`Args:`) stay as they are.
    """
    translated: list[str] = []
    for block, part in _parts(lines):
        if block == "code":
            language = part[0].strip().removeprefix("```") or "text"
            indent = _indent(part[0])
            translated += ["", f"{indent}.. code-block:: {language}", ""]
            translated += [f"   {line}" for line in part[1:-1]] + [""]
        elif block == "table":
            translated += ["", *_list_table(part), ""]
        else:
            text = _with_code("\n".join(part))
            translated += re.sub(r"^( *)#+ (.*)$", r"\n\1.. rubric:: \2\n", text, flags=re.MULTILINE).split(
                "\n"
            )
    return translated


def _parts(lines: Sequence[str]) -> Iterator[tuple[str, list[str]]]:
    """Runs of lines of one kind: `code`, `table` or `text`."""
    fenced = False
    kinds = []
    for line in lines:
        fence = line.lstrip().startswith("```")
        kinds.append("code" if fenced or fence else "table" if line.lstrip().startswith("|") else "text")
        fenced ^= fence
    for kind, run in groupby(zip(kinds, lines, strict=True), key=lambda pair: pair[0]):
        yield kind, [line for _, line in run]


def _list_table(rows: Sequence[str]) -> Iterator[str]:
    """A table whose second line, between head and body, is left out."""
    indent = _indent(rows[0])
    yield from (f"{indent}.. list-table::", f"{indent}   :header-rows: 1", "")
    for row in (rows[0], *rows[2:]):
        cells = [cell.strip() for cell in row.strip().strip("|").split("|")]
        for i, cell in enumerate(cells):
            yield f"{indent}   {'* -' if i == 0 else '  -'} {_with_code(cell)}"


def _with_code(text: str) -> str:
    return _CODE.sub(r"``\1``", text)


def _indent(line: str) -> str:
    return line[: len(line) - len(line.lstrip())]
