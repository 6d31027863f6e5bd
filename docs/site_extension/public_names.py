"""The public modules and names of the package, read from its files without importing it."""

import ast
from pathlib import Path

from site_extension.repository import PACKAGE, module_name

COMMANDS, COMPILER = "khepera_forage.cli", "khepera_forage.compilation"
"""The command line, which has a page of its own, and what only compiled modules use."""
COMPILED = {"entry", "rule", "array_rule"}
"""Decorators of functions of compiled worlds, which users do not call."""


def public_modules() -> dict[str, list[Path]]:
    """The files of all public modules, by the package that contains them, each package's own file first."""
    found: dict[str, list[Path]] = {}
    for path in sorted(PACKAGE.rglob("*.py")):
        name = module_name(path)
        internal = any(f"{name}.".startswith(f"{package}.") for package in (COMMANDS, COMPILER))
        compiled = COMPILER in _imported(path) and not public_names(path)
        if not (internal or compiled):
            package = name if path.name == "__init__.py" else name.rpartition(".")[0]
            found.setdefault(package, []).append(path)
    return found


def public_names(path: Path) -> list[str]:
    """The classes and functions that a file defines, without compiled ones and those that begin with an underscore."""
    kinds = (ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef)
    return [
        node.name
        for node in _parsed(path).body
        if isinstance(node, kinds)
        and not node.name.startswith("_")
        and COMPILED.isdisjoint(map(ast.unparse, node.decorator_list))
    ]


def exported_names(path: Path) -> list[str]:
    """The names in a file's `__all__`; none without one."""
    for node in _parsed(path).body:
        if isinstance(node, ast.Assign) and [ast.unparse(target) for target in node.targets] == ["__all__"]:
            names: list[str] = ast.literal_eval(node.value)
            return names
    return []


def _parsed(path: Path) -> ast.Module:
    return ast.parse(path.read_text(encoding="utf-8"))


def _imported(path: Path) -> set[str]:
    """The modules that a file imports names from."""
    return {
        node.module for node in ast.walk(_parsed(path)) if isinstance(node, ast.ImportFrom) and node.module
    }
