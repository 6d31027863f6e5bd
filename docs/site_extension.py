"""Sphinx extension of this site: Markdown in docstrings, parts generated from the package, and links to source files.

A generated part stands in its page between `<!-- generated: noise -->` and `<!-- end -->`, so that pages can be read
without a build; `PYTHONPATH=docs python -m site_extension` brings all of them up to date. The help of all commands is
only on the site, in place of `<!-- on the site: commands -->`.
"""

import ast
import inspect
import io
import re
from collections.abc import Iterator
from contextlib import redirect_stdout, suppress
from dataclasses import fields
from enum import Enum
from itertools import pairwise
from pathlib import Path
from pydoc import locate
from typing import TYPE_CHECKING, Any

from khepera_forage.cli.main import main
from khepera_forage.noise import Noise
from khepera_forage.task.decisions import decision_table

if TYPE_CHECKING:  # the tests run without Sphinx
    from sphinx.application import Sphinx

ROOT = Path(__file__).parents[1]
SOURCES = [ROOT / name for name in ("khepera_forage", "benchmarks", "examples", "tests/contracts")]
"""Folders whose Python files have a page of source code."""


def setup(app: "Sphinx") -> dict[str, Any]:
    """Connect to the events of a build."""
    app.connect("source-read", lambda app, page, content: content.append(with_commands(content.pop())))
    # Before napoleon, which reads Google's sections.
    app.connect("autodoc-process-docstring", _translate, priority=400)
    app.connect("autodoc-skip-member", _skip)
    app.connect("autodoc-process-signature", _shorten)
    app.connect("doctree-read", _link_sources)
    app.connect("html-collect-pages", _source_pages)
    return {"version": "1", "parallel_read_safe": True, "parallel_write_safe": True}


def filled_in(text: str) -> str:
    """A page with its generated parts brought up to date."""
    part = re.compile(r"(<!-- generated: (\w+) ?(\S*) -->\n)(?:.*?\n)??(<!-- end -->)", re.DOTALL)
    return part.sub(lambda found: f"{found[1]}\n{GENERATORS[found[2]](found[3])}\n\n{found[4]}", text)


def noise_table(_: str) -> str:
    """The sizes of noise, with the docstrings of their fields."""
    body = ast.parse(inspect.getsource(Noise)).body[0].body  # type: ignore[attr-defined]
    texts = {
        ast.unparse(field.target): " ".join(ast.literal_eval(text.value).split())
        for field, text in pairwise(body)
        if isinstance(field, ast.AnnAssign) and isinstance(text, ast.Expr)
    }
    lines = ["| field | laboratory | meaning and source |", "|---|---:|---|"]
    return "\n".join(lines + [f"| `{each.name}` | {each.default} | {texts[each.name]} |" for each in fields(Noise)])


def decisions_table(_: str) -> str:
    """All decisions, with their defaults."""
    lines = ["| decision | default | allowed | thesis | meaning |", "|---|---|---|---|---|"]
    return "\n".join(lines + [f"| `{row.name}` | {' | '.join(row[1:])} |" for row in decision_table()])


GENERATORS = {
    "decisions": decisions_table,
    "docstring": lambda name: inspect.getdoc(locate(name)) or "",
    "noise": noise_table,
}
"""What makes each kind of part, from the text that follows the kind."""


def with_commands(page: str) -> str:
    """A page with the help of all commands in place of its comment."""
    comment = "<!-- on the site: commands -->"
    return page.replace(comment, "\n\n".join(_commands())) if comment in page else page


def _commands(*names: str) -> Iterator[str]:
    """The help of a command, as the shell shows it, or that of its subcommands, each command with a heading."""
    shown = io.StringIO()
    with redirect_stdout(shown), suppress(SystemExit):
        main([*names, "--help"])
    subcommands = re.findall(r"^ {4}([a-z]+)(?: .*)?$", shown.getvalue(), flags=re.MULTILINE)
    if len(names) == 1:
        yield f"## khepera-forage {names[0]}"
    if not subcommands:
        yield f"```text\n{shown.getvalue()}```"
    for name in subcommands:
        yield from _commands(*names, name)


def to_rst(text: str) -> str:
    """Translate the Markdown of a docstring: fenced code, tables, headings, and code in the text."""
    code = r"^( *)```(\w*)\n(.*?)\n *```$"
    parts = re.split(code, text, flags=re.DOTALL | re.MULTILINE)
    for i in range(0, len(parts), 4):
        part = re.sub(r"(?<![`:\w])`([^`]+)`(?!`)", r"``\1``", parts[i])
        part = re.sub(r"^( *)#+ (.*)$", r"\1.. rubric:: \2\n", part, flags=re.MULTILINE)
        parts[i] = re.sub(r"(?:^ *\|.*\|\n?)+", _list_table, part, flags=re.MULTILINE)
    for i in range(1, len(parts), 4):
        indent, language, lines = parts[i : i + 3]
        body = "\n".join(f"   {line}" for line in lines.split("\n"))
        parts[i : i + 3] = [f"\n{indent}.. code-block:: {language or 'text'}\n\n{body}\n", "", ""]
    return "".join(parts)


def _list_table(table: re.Match[str]) -> str:
    indent = table[0][: table[0].index("|")]
    rows = [re.split(r" *\| *", row.strip(" |")) for row in table[0].strip().split("\n")]
    lines = ["", ".. list-table::", "   :header-rows: 1", ""]
    for row in (rows[0], *rows[2:]):
        lines += [f"   {'* -' if i == 0 else '  -'} {cell}" for i, cell in enumerate(row)]
    return "\n".join(f"{indent}{line}" for line in lines) + "\n\n"


def _translate(app: Any, what: str, name: str, obj: Any, options: Any, lines: list[str]) -> None:
    # Napoleon takes what is before a colon in the first line of an attribute's docstring for its type, so that line is
    # an empty comment.
    lines[:] = (["..", ""] if what in ("attribute", "data") else []) + to_rst("\n".join(lines)).split("\n")


def _skip(app: Any, what: str, name: str, obj: Any, skip: bool, options: Any) -> bool | None:
    """Show members of enums; hide the fields of named tuples, and what scikit-learn adds to its subclasses."""
    if isinstance(obj, Enum):
        return False
    module = (getattr(obj, "__module__", None) if callable(obj) else None) or "khepera_forage"
    alias = (getattr(obj, "__doc__", None) or "").startswith("Alias for field number")
    return True if alias or module.partition(".")[0] != "khepera_forage" else None


def _shorten(
    app: Any, what: str, name: str, obj: Any, options: Any, arguments: str | None, result: str | None
) -> tuple[str | None, str | None]:
    """Write `NDArray[int64]` and `ArrayLike` as the source does."""
    from numpy.typing import ArrayLike
    from sphinx.util.typing import stringify_annotation

    array = r"~?numpy\.ndarray\[tuple\[~?typing\.Any, \.\.\.\], ~?numpy\.dtype\[([\w.~]+)\]\]"
    alike = stringify_annotation(ArrayLike, "smart")
    short = [
        text and re.sub(array, r"~numpy.typing.NDArray[\1]", text).replace(alike, "~numpy.typing.ArrayLike")
        for text in (arguments, result)
    ]
    return short[0], short[1]


def page_of(path: Path) -> str | None:
    """The page about a Python file or a package of the repository, without `.html`; None if there is none."""
    if any(path.is_relative_to(folder) for folder in SOURCES) and path.suffix == ".py":
        return f"source/{path.relative_to(ROOT).as_posix()}"
    if path.is_dir() and path.is_relative_to(SOURCES[0]):
        return f"api/{'.'.join(path.relative_to(ROOT).parts)}"
    return None


def code_link(domain: str, info: dict[str, str]) -> str:
    """The link beside an object of the API reference to its source, for `sphinx.ext.linkcode`."""
    from sphinx.pycode import ModuleAnalyzer

    analyzer = ModuleAnalyzer.for_module(info["module"])
    _, line, _ = analyzer.find_tags().get(info["fullname"], ("", 1, 1))
    return f"../{page_of(Path(analyzer.srcname))}.html#line-{line}"  # from a page in docs/api


def _link_sources(app: "Sphinx", document: Any) -> None:
    """Replace links to files and packages, which MyST takes for downloads or cannot resolve."""
    from docutils import nodes
    from sphinx import addnodes

    page = app.env.docname
    for node in [*document.findall(addnodes.download_reference), *document.findall(addnodes.pending_xref)]:
        path = (Path(app.srcdir, page).parent / node["reftarget"].partition("#")[0]).resolve()
        if node.get("refdomain") != "py" and (target := page_of(path)):
            uri = app.builder.get_relative_uri(page, target)
            node.replace_self(nodes.reference("", "", *node.children, refuri=uri, internal=True))


def _source_pages(app: Any) -> Iterator[tuple[str, dict[str, Any], str]]:
    """A page for each Python file, without the tree of pages beside it, which would take a minute to render."""
    for path in (path for folder in SOURCES for path in sorted(folder.rglob("*.py"))):
        code = app.builder.highlighter.highlight_block(path.read_text("utf-8"), "python", lineanchors="line")
        name = path.relative_to(ROOT).as_posix()
        context = {"title": name, "body": f"<h1>{name}</h1>{code}", "toctree": lambda **_: ""}
        yield str(page_of(path)), context, "page.html"


if __name__ == "__main__":
    for path in (ROOT / "docs").rglob("*.md"):
        path.write_text(filled_in(path.read_text(encoding="utf-8")), encoding="utf-8")
