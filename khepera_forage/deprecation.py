"""Names of earlier versions, which still work for one version, with a warning."""

import warnings
from collections.abc import Mapping
from typing import Any


def renamed(module: str, name: str, new: Mapping[str, Any]) -> Any:
    """What a module's `__getattr__` returns.

    Args:
        module: Its name.
        name: What is asked for.
        new: Classes by their former names.

    Raises:
        AttributeError: It was never there.
    """
    if name not in new:
        raise AttributeError(f"module {module!r} has no attribute {name!r}")
    warnings.warn(
        f"{name} is now {new[name].__name__}; the old name goes with the next version", DeprecationWarning, stacklevel=3
    )
    return new[name]
