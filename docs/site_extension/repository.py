"""The repository of this site: where its files are, and where the site has a page about one."""

from pathlib import Path

ROOT = Path(__file__).parents[2]
"""The folder of the repository."""
DOCS = ROOT / "docs"
PACKAGE = ROOT / "khepera_forage"
SOURCES = tuple(ROOT / name for name in ("khepera_forage", "benchmarks", "examples", "tests/contracts"))
"""Folders whose Python files have a page of source code."""
PAGES = {"README.md": "index", "CHANGELOG.md": "changelog", "CONTRIBUTING.md": "contributing"}
"""The page of this site for files of the repository's own folder."""


def page_of(path: Path) -> str | None:
    """The page about a file or folder of the repository, without `.html`; None if there is none.

    Args:
        path: Absolute.
    """
    if not path.is_relative_to(ROOT):
        return None
    within = path.relative_to(ROOT).as_posix()
    if any(path.is_relative_to(folder) for folder in SOURCES) and (path.is_dir() or path.suffix == ".py"):
        # With the ending, because a file may be called index.py.
        return f"source/{within}/index" if path.is_dir() else f"source/{within}"
    return PAGES.get(within)


def module_name(path: Path) -> str:
    """The dotted name of a Python file of the package."""
    parts = path.relative_to(ROOT).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)
