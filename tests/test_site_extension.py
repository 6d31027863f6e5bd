"""What the site needs: its tree of pages, its notebooks, and the parts of its extension that need no Sphinx."""

import re
from pathlib import Path
from pydoc import locate

import pytest
from site_extension import ROOT, filled_in, page_of, to_rst, with_commands

from khepera_forage.cli.main import main

DOCS = ROOT / "docs"
PAGES = {path: path.read_text("utf-8") for path in sorted(DOCS.rglob("*.md"))}
PARTS = [path for path, text in PAGES.items() if "<!-- generated: " in text]


def entries(page: Path) -> list[Path]:
    """The pages below a page."""
    blocks = re.findall(r"```\{toctree\}\n(.*?)```", PAGES[page], flags=re.DOTALL)
    names = re.findall(r"^[\w/]+$", "\n".join(blocks), flags=re.MULTILINE)
    return [page.parent / f"{name}.md" for name in names if not name.startswith("api/")]


def test_every_page_is_in_the_tree_once() -> None:
    below = [entry for page in PAGES for entry in entries(page)]
    assert sorted([*below, DOCS / "index.md"]) == sorted(PAGES)


def test_every_page_is_two_clicks_from_the_index() -> None:
    reached = {DOCS / "index.md"}
    for _ in range(2):
        links = {
            (page.parent / link).resolve()
            for page in reached
            for link in re.findall(r"\]\(([^)#]+\.md)[^)]*\)", PAGES[page])
        }
        reached |= {each for page in reached for each in entries(page)} | (links & PAGES.keys())
    assert reached == set(PAGES)


@pytest.mark.parametrize("notebook", sorted((DOCS / "notebooks").glob("*.md")), ids=lambda path: path.stem)
def test_cells_of_notebook_are_python(notebook: Path) -> None:
    assert PAGES[notebook].startswith("---\nkernelspec:\n  name: python3\n")
    cells = re.findall(r"```\{code-cell\} ipython3\n(?::[^\n]*\n\n)?(.*?)```", PAGES[notebook], flags=re.DOTALL)
    assert len(cells) >= 4
    for cell in cells:
        compile(cell, notebook.name, "exec")


@pytest.mark.parametrize("name", sorted(set(re.findall(r"\{py:mod\}`([\w.]+)`", PAGES[DOCS / "api.md"]))))
def test_module_of_the_api_page_can_be_imported(name: str) -> None:
    assert getattr(locate(name), "__doc__", None)


MARKDOWN = """Takes `rng`, and `a
b`; not ``c``.
## Action space
| key | meaning |
|---|---|
| `arm` | 255 down |

So:
```python
f(`x`)
```
Then."""
RST = """Takes ``rng``, and ``a
b``; not ``c``.
.. rubric:: Action space
.. list-table::
   :header-rows: 1
   * - key
     - meaning
   * - ``arm``
     - 255 down
So:
.. code-block:: python
   f(`x`)
Then."""


def test_markdown_of_docstrings_becomes_rst() -> None:
    assert [line for line in to_rst(MARKDOWN).split("\n") if line] == RST.split("\n")


def test_python_files_and_packages_have_pages() -> None:
    pages = {
        "khepera_forage/noise.py": "source/khepera_forage/noise.py",
        "khepera_forage/task": "api/khepera_forage.task",
        "docs/published/thesis.zip": None,
        "..": None,
    }
    assert {path: page_of((ROOT / path).resolve()) for path in pages} == pages


@pytest.mark.parametrize("path", PARTS, ids=lambda path: path.stem)
def test_generated_part_of_page_is_up_to_date(path: Path) -> None:
    text = path.read_text("utf-8")
    assert filled_in(text) == text, "run PYTHONPATH=docs python -m site_extension"


def test_page_of_commands_has_the_help_of_all(capsys: pytest.CaptureFixture[str]) -> None:
    page = with_commands("# Commands\n\n<!-- on the site: commands -->")
    with pytest.raises(SystemExit):
        main(["--help"])
    commands = set(re.findall(r"^ {4}(\w+)", capsys.readouterr().out, flags=re.MULTILINE))
    headings = {line.split()[-1] for line in page.splitlines() if line.startswith("## khepera-forage ")}
    assert headings == commands
    for usage in ("reproduce [-h]", "robot probe [-h]", "camera calibrate [-h]"):
        assert page.count(f"usage: khepera-forage {usage}") == 1
