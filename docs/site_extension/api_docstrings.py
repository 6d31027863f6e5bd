"""What autodoc shows: docstrings in Markdown, members of enums, and readable types."""

import re
from enum import Enum
from typing import Any

from numpy.typing import ArrayLike
from sphinx.application import Sphinx
from sphinx.util.typing import stringify_annotation

from site_extension.docstring_markup import to_rst

PACKAGE = "khepera_forage"
BEFORE_NAPOLEON = 400
"""Napoleon, which reads Google's sections, has Sphinx's priority of 500."""
_ARRAY = re.compile(r"~?numpy\.ndarray\[tuple\[~?typing\.Any, \.\.\.\], ~?numpy\.dtype\[([\w.~]+)\]\]")
"""What autodoc writes for `NDArray`."""
_ARRAY_LIKE = stringify_annotation(ArrayLike, "smart")
"""What autodoc writes for `ArrayLike`: a union of seven types."""


def setup(app: Sphinx) -> None:
    """Connect to the events of autodoc."""
    app.connect("autodoc-process-docstring", _translate, priority=BEFORE_NAPOLEON)
    app.connect("autodoc-skip-member", _skip)
    app.connect("autodoc-process-signature", _shorten)


def _translate(app: Sphinx, what: str, name: str, obj: Any, options: Any, lines: list[str]) -> None:
    # Napoleon takes what is before a colon in the first line of an attribute's docstring for its type, so that line is
    # an empty comment.
    lines[:] = (["..", ""] if what in ("attribute", "data") else []) + to_rst(lines)


def _skip(app: Sphinx, what: str, name: str, obj: Any, skip: bool, options: Any) -> bool | None:
    """Show members of enums, which need no docstring.

    Hide the fields of named tuples, whose class describes them, and what scikit-learn adds to its subclasses.
    """
    if isinstance(obj, Enum):
        return False
    module = getattr(obj, "__module__", None) if callable(obj) else None
    if (module or PACKAGE).partition(".")[0] != PACKAGE:
        return True
    return True if (getattr(obj, "__doc__", None) or "").startswith("Alias for field number") else None


def _shorten(
    app: Sphinx, what: str, name: str, obj: Any, options: Any, arguments: str | None, result: str | None
) -> tuple[str | None, str | None]:
    """Write `NDArray[int64]` and `ArrayLike` as the source does."""
    return _shortened(arguments), _shortened(result)


def _shortened(text: str | None) -> str | None:
    return text and _ARRAY.sub(r"~numpy.typing.NDArray[\1]", text).replace(
        _ARRAY_LIKE, "~numpy.typing.ArrayLike"
    )
