"""Parts of the scripts that measure the laboratory: what cameras see, how devices fail, and what is true."""

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple


class Work(NamedTuple):
    """A unit of a study: a function with its arguments, and a key that no other unit has."""

    key: str
    run: Callable[[], Sequence[Any]]
