"""A page for each Python file of the repository, with its code, and one for each folder, with its files."""

import ast
from collections.abc import Iterator
from html import escape
from pathlib import Path
from typing import Any

from sphinx.application import Sphinx

from site_extension.repository import ROOT, SOURCES, page_of

Page = tuple[str, dict[str, Any], str]
"""Name, context and template, as Sphinx takes them."""


def setup(app: Sphinx) -> None:
    """Add the pages to those of the site."""
    app.connect("html-collect-pages", _pages)


def _pages(app: Sphinx) -> Iterator[Page]:
    for folder in SOURCES:
        files = sorted(folder.rglob("*.py"))
        for path in files:
            code = app.builder.highlighter.highlight_block(
                path.read_text(encoding="utf-8"), "python", lineanchors="line"
            )
            yield _page(path, code)
        for inner in sorted({folder, *(path.parent for path in files)} if files else ()):
            yield _page(inner, _listing(app, inner))


def _page(path: Path, body: str) -> Page:
    name = escape(path.relative_to(ROOT).as_posix())
    page = page_of(path)
    assert page is not None
    # Without the tree of pages beside it: rendering it for each of some hundred files would take a minute.
    context = {"title": name, "body": f"<h1>{name}</h1>{body}", "toctree": lambda **_: ""}
    return page, context, "page.html"


def _listing(app: Sphinx, folder: Path) -> str:
    """The folders and files of a folder, each with the first line of its docstring."""
    rows = []
    for path in sorted(folder.iterdir(), key=lambda path: (path.is_file(), path.name)):
        described = path / "__init__.py" if path.is_dir() else path
        if path.suffix in ("", ".py") and described.exists() and path.name != "__init__.py":
            link = app.builder.get_relative_uri(str(page_of(folder)), str(page_of(path)))
            text = (ast.get_docstring(ast.parse(described.read_text(encoding="utf-8"))) or "").partition(
                "\n"
            )[0]
            rows.append(f'<li><a href="{link}">{escape(path.name)}</a> {escape(text)}</li>')
    return f"<ul>{''.join(rows)}</ul>"
