"""The parts of the extension that need no Sphinx."""

from pathlib import Path

import pytest
from site_extension.docstring_markup import to_rst
from site_extension.repository import ROOT, module_name, page_of


def test_code_in_text_gets_two_backticks() -> None:
    assert to_rst(["Takes `rng`, and `a", "b`; not ``c``."]) == ["Takes ``rng``, and ``a", "b``; not ``c``."]


def test_heading_becomes_a_rubric() -> None:
    assert to_rst(["## Action space", "Ten."]) == ["", ".. rubric:: Action space", "", "Ten."]


def test_table_becomes_a_list_table() -> None:
    rows = ["| key | meaning |", "|---|---|", "| `arm` | 255 down |"]
    assert [line for line in to_rst(rows) if line] == [
        ".. list-table::",
        "   :header-rows: 1",
        "   * - key",
        "     - meaning",
        "   * - ``arm``",
        "     - 255 down",
    ]


def test_fenced_code_keeps_its_backticks() -> None:
    lines = ["So:", "```python", "f(`x`)", "```", "Then."]
    assert [line for line in to_rst(lines) if line] == ["So:", ".. code-block:: python", "   f(`x`)", "Then."]


@pytest.mark.parametrize(
    ("path", "page"),
    [
        ("khepera_forage/noise.py", "source/khepera_forage/noise"),
        ("khepera_forage/task", "source/khepera_forage/task/index"),
        ("tests/contracts", "source/tests/contracts/index"),
        ("CHANGELOG.md", "changelog"),
        ("docs/thesis/table_errata.csv", None),
        ("pyproject.toml", None),
        (".", None),
        ("..", None),
    ],
)
def test_page_of_file(path: str, page: str | None) -> None:
    assert page_of((ROOT / path).resolve()) == page


def test_module_name_of_package_is_that_of_its_folder() -> None:
    assert module_name(Path(ROOT / "khepera_forage/task/__init__.py")) == "khepera_forage.task"
