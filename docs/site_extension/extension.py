"""Connects the parts of the extension to Sphinx."""

from typing import Any

from sphinx.application import Sphinx

from site_extension import (
    api_docstrings,
    api_pages,
    built_links,
    generated_parts,
    source_links,
    source_pages,
)


def setup(app: Sphinx) -> dict[str, Any]:
    """Connect the parts of the extension."""
    for part in (api_pages, api_docstrings, generated_parts, source_links, source_pages, built_links):
        part.setup(app)
    return {"version": "1", "parallel_read_safe": True, "parallel_write_safe": True}
