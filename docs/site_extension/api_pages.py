"""The pages of the API reference, one for each package, written into `docs/api` before Sphinx reads the pages."""

import importlib
from pathlib import Path

from sphinx.application import Sphinx
from sphinx.util import logging

from site_extension.public_names import exported_names, public_modules, public_names
from site_extension.repository import DOCS, module_name

FOLDER = DOCS / "api"
_log = logging.getLogger(__name__)


def setup(app: Sphinx) -> None:
    """Write the pages at the beginning of a build, and check at its end that they have every public name."""
    app.connect("builder-inited", _write_pages)
    app.connect("env-check-consistency", _check_names)


def page_text(package: str, paths: list[Path]) -> str:
    """The page of a package, in MyST.

    Args:
        package: Its dotted name.
        paths: Its files, its own `__init__.py` first.
    """
    parts = [f"# {package.removeprefix('khepera_forage.')}", f"The modules of `{package}`."]
    for path in paths:
        name = module_name(path)
        if name == package:
            parts.append(_automodule(name, members=bool(public_names(path))))
            if exported := exported_names(path):
                parts.append(
                    f"`from {package} import` {', '.join(_link(package, each) for each in exported)}"
                )
        else:
            parts += [f"## {name.removeprefix(f'{package}.')}", _automodule(name, members=True)]
    return "\n\n".join(parts) + "\n"


def _automodule(name: str, members: bool) -> str:
    options = "   :members:\n   :ignore-module-all:\n   :show-inheritance:\n" if members else ""
    return f"```{{eval-rst}}\n.. automodule:: {name}\n{options}```"


def _link(package: str, name: str) -> str:
    """A name that a package exports, with a link to where it is documented."""
    value = getattr(importlib.import_module(package), name)
    module = getattr(value, "__module__", None)
    return f"{{py:obj}}`{name} <{module}.{name}>`" if module else f"`{name}`"


def _write_pages(app: Sphinx) -> None:
    """Write the pages that changed, and remove those of packages that are gone."""
    FOLDER.mkdir(exist_ok=True)
    pages = {
        FOLDER / f"{package}.md": page_text(package, paths) for package, paths in public_modules().items()
    }
    for path in set(FOLDER.glob("*.md")) - set(pages):
        path.unlink()
    for path, text in pages.items():
        if not path.exists() or path.read_text(encoding="utf-8") != text:
            path.write_text(text, encoding="utf-8")


def _check_names(app: Sphinx, env: object) -> None:
    documented = app.env.domains.python_domain.objects
    for paths in public_modules().values():
        for path in paths:
            for name in public_names(path):
                if f"{module_name(path)}.{name}" not in documented:
                    _log.warning("%s.%s is public, but not in the API reference", module_name(path), name)
