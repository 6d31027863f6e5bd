"""A check of the built site: every link within it leads to a file, and to a place in that file if it names one."""

import re
from collections.abc import Iterator
from functools import cache
from html import unescape
from pathlib import Path
from typing import TYPE_CHECKING
from urllib.parse import unquote, urlsplit

if TYPE_CHECKING:  # the tests run without Sphinx
    from sphinx.application import Sphinx

_LINK = re.compile(r'(?:href|src)="([^"]+)"')
_PLACE = re.compile(r'(?:id|name)="([^"]+)"')


def setup(app: "Sphinx") -> None:
    """Check the links after the build."""
    app.connect("build-finished", _check)


def broken_links(site: Path) -> Iterator[str]:
    """The links within a site that lead nowhere, each with its page.

    Args:
        site: Folder of the pages.
    """
    for page in sorted(site.rglob("*.html")):
        for link in sorted(set(_LINK.findall(page.read_text(encoding="utf-8")))):
            parts = urlsplit(unescape(link))
            target = (page.parent / unquote(parts.path)).resolve() if parts.path else page
            if parts.scheme or parts.netloc:
                continue
            lost = parts.fragment and target.suffix == ".html" and target.exists()
            if not target.exists() or (lost and unquote(parts.fragment) not in _places(target)):
                yield f"{page.relative_to(site)}: {link}"


@cache
def _places(page: Path) -> frozenset[str]:
    """What links to a page can name."""
    return frozenset(map(unescape, _PLACE.findall(page.read_text(encoding="utf-8"))))


def _check(app: "Sphinx", error: Exception | None) -> None:
    """Report broken links as warnings."""
    from sphinx.util import logging

    if error is None and app.builder.format == "html":
        for link in broken_links(Path(app.outdir)):
            logging.getLogger(__name__).warning("broken link in %s", link)
