"""Parts of pages that are generated from the package.

A part stands in its page between `<!-- generated: noise -->` and `<!-- end -->`, so that pages can be read without a
build; `PYTHONPATH=docs python -m site_extension.generated_parts` brings all of them up to date. The help of all
commands is only on the site, in place of `<!-- on the site: commands -->`.
"""

import argparse
import ast
import inspect
import re
from collections.abc import Iterator
from dataclasses import fields
from importlib import import_module
from typing import TYPE_CHECKING

from khepera_forage import noise
from khepera_forage.cli.main import COMMANDS
from khepera_forage.cli.options import Command, add_commands
from site_extension.repository import DOCS

if TYPE_CHECKING:  # the tests run without Sphinx
    from sphinx.application import Sphinx

_PART = re.compile(r"(<!-- generated: (\w+) ?(\S*) -->\n)(?:.*?\n)??(<!-- end -->)", re.DOTALL)
_COMMANDS = "<!-- on the site: commands -->"


def setup(app: "Sphinx") -> None:
    """Add the help of the commands when their page is read."""
    app.connect("source-read", _add_commands)


def filled_in(text: str) -> str:
    """A page with its generated parts brought up to date.

    Raises:
        KeyError: A comment names no kind of part.
    """
    return _PART.sub(lambda part: f"{part[1]}\n{GENERATORS[part[2]](part[3])}\n\n{part[4]}", text)


def docstring(name: str) -> str:
    """The docstring of a class, which is in Markdown already.

    Args:
        name: Its dotted name.
    """
    module, _, attribute = name.rpartition(".")
    return inspect.getdoc(getattr(import_module(module), attribute)) or ""


def noise_table(_: str) -> str:
    """The sizes of noise, with their meaning and source."""
    described = _attribute_docstrings(inspect.getsource(noise.Noise))
    lines = ["| field | laboratory | meaning and source |", "|---|---:|---|"]
    lines += [
        f"| `{field.name}` | {field.default} | {described[field.name]} |" for field in fields(noise.Noise)
    ]
    return "\n".join(lines)


def commands() -> str:
    """A section for each subcommand, with its help and that of its own subcommands, as the shell shows it."""
    parts = []
    for command in COMMANDS:
        parts.append(f"## khepera-forage {command.name}")
        parts += [f"```text\n{text}```" for text in _help_texts(command)]
    return "\n\n".join(parts)


def _help_texts(command: Command) -> list[str]:
    parser = argparse.ArgumentParser(prog="khepera-forage")
    add_commands(parser, "command", [command])
    return [each.format_help() for each in _subparsers(parser) if not list(_subparsers(each))]


def _subparsers(parser: argparse.ArgumentParser) -> Iterator[argparse.ArgumentParser]:
    """The parsers of all subcommands of a parser, and of theirs."""
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            for subparser in action.choices.values():
                yield subparser
                yield from _subparsers(subparser)


def _attribute_docstrings(source: str) -> dict[str, str]:
    """The strings below the fields of a class, in one line each."""
    body = ast.parse(inspect.cleandoc(source)).body[0]
    assert isinstance(body, ast.ClassDef)
    found = {}
    for field, text in zip(body.body, body.body[1:], strict=False):
        if isinstance(field, ast.AnnAssign) and isinstance(text, ast.Expr):
            found[ast.unparse(field.target)] = " ".join(ast.literal_eval(text.value).split())
    return found


def _add_commands(app: "Sphinx", page: str, content: list[str]) -> None:
    content[0] = content[0].replace(_COMMANDS, commands())


GENERATORS = {"docstring": docstring, "noise": noise_table}
"""What makes each kind of part, from the text that follows the kind."""

if __name__ == "__main__":
    for path in DOCS.rglob("*.md"):
        path.write_text(filled_in(path.read_text(encoding="utf-8")), encoding="utf-8")
