"""Links of pages to files of the repository: in the site they lead to the file's page.

In the repository such a link is relative to the page: `../khepera_forage/noise.py`.
"""

from pathlib import Path
from typing import Any

from docutils import nodes
from sphinx import addnodes
from sphinx.application import Sphinx
from sphinx.pycode import ModuleAnalyzer
from sphinx.transforms import SphinxTransform

from site_extension.repository import DOCS, ROOT, page_of


def setup(app: Sphinx) -> None:
    """Add the transform, which runs on each page after it is parsed."""
    app.add_transform(SourceLinks)


class SourceLinks(SphinxTransform):  # type: ignore[misc]  # not typed where Sphinx is not installed
    """Replaces links to Python files and folders, which MyST takes for downloads or cannot resolve."""

    default_priority = 500

    def apply(self, **kwargs: Any) -> None:
        """Replace the links of one page."""
        folder = (DOCS / self.env.docname).parent
        for kind in (addnodes.download_reference, addnodes.pending_xref):
            for node in list(self.document.findall(kind)):
                page = _target_page(folder, str(node.get("reftarget", "")))
                if page is not None:
                    uri = self.app.builder.get_relative_uri(self.env.docname, page)
                    link = nodes.reference("", "", *node.children, refuri=uri, internal=True)
                    node.replace_self(link)


def code_link(domain: str, info: dict[str, str]) -> str | None:
    """The link beside an object of the API reference to its source, for `sphinx.ext.linkcode`."""
    if domain != "py" or not info["module"]:
        return None
    path = ROOT / info["module"].replace(".", "/")
    path = path / "__init__.py" if path.is_dir() else path.with_suffix(".py")
    page = page_of(path)
    _, line, _ = ModuleAnalyzer.for_module(info["module"]).find_tags().get(info["fullname"], ("", 1, 1))
    return f"../{page}.html#line-{line}"  # from a page in docs/api


def _target_page(folder: Path, target: str) -> str | None:
    """The page that a link leads to, if its target is a file of the repository outside the pages."""
    path = (folder / target.partition("#")[0]).resolve()
    if path.is_relative_to(DOCS):
        # Included files of the repository's own folder link to each other there.
        path = ROOT / path.relative_to(DOCS)
    return page_of(path) if path.exists() else None
