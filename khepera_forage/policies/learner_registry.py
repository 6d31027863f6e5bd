"""Learners from other packages: registered by a program, found among the installed packages, or named as text.

A package makes its learners known with an entry point in its `pyproject.toml`:

```toml
[project.entry-points."khepera_forage.learners"]
forest = "my_package.learners:forest"
```

It names an `OfflineImitation`, `InteractiveImitation` or `ReinforcementLearner`, or a function or class that makes a
scikit-learn classifier.
"""

import inspect
import os
import sys
import traceback
from collections.abc import Iterator
from contextlib import contextmanager
from importlib import import_module
from importlib.metadata import entry_points
from pathlib import Path
from typing import Any, NamedTuple

from khepera_forage.policies.learners import (
    LEARNERS,
    InteractiveImitation,
    Learner,
    OfflineImitation,
    ReinforcementLearner,
)

GROUP = "khepera_forage.learners"
"""The group of the entry points."""
_PACKAGE = str(Path(__file__).parents[1]) + os.sep


class LearnerError(ValueError):
    """An error in the code of a learner; the message ends with its traceback."""


class Installed(NamedTuple):
    """What the installed packages offer: learners by name, and by name why one cannot be used."""

    learners: dict[str, Learner]
    broken: dict[str, str]

    def why_not(self, name: str) -> str:
        """The part of a message that says why a learner cannot be used; empty if it is not here."""
        return f", which cannot be used ({self.broken[name]})" if name in self.broken else ""


def register_learner(name: str, learner: Any) -> Learner:
    """Make a learner known to every comparison of this process.

    Args:
        name: Of its rows: letters, digits and underscores.
        learner: An `OfflineImitation`, `InteractiveImitation` or `ReinforcementLearner`; or what makes a scikit-learn
            classifier when called. It gets `random_state` and `diagonal` (of the arena, in pixels) if it takes them.

    Returns:
        The learner as comparisons take it.

    Raises:
        ValueError: The name is no identifier, or another learner has it.
        TypeError: The learner is none of these.
    """
    described = _described(name, learner)
    if LEARNERS.get(name, described) != described:
        raise ValueError(f"name of a learner is {name!r}, as that of another; allowed: a new name")
    LEARNERS[name] = described
    return described


def installed_learners() -> Installed:
    """The learners of all installed packages that have entry points; none that cannot be imported stops the others."""
    found = Installed({}, {})
    for entry in entry_points(group=GROUP):
        try:
            if entry.name in LEARNERS | found.learners:
                raise ValueError("its name is that of another learner")
            found.learners[entry.name] = _described(entry.name, entry.load())
        except (Exception, SystemExit) as error:
            found.broken[entry.name] = " ".join(f"{entry.value}: {type(error).__name__}: {error}".split())
    return found


def learner_at(place: str) -> tuple[str, Learner]:
    """The name and the learner at a place in any module, such as `my_package.learners:forest`.

    The module may be in the present folder.

    Raises:
        ValueError: There is no such place, or no learner.
    """
    module, _, name = place.partition(":")
    allowed = "allowed: package.module:name of what makes a classifier"
    if module[:1] in ("", ".") or not name.isidentifier():
        raise ValueError(f"learner is {place!r}; {allowed}")
    if os.getcwd() not in sys.path:
        sys.path.insert(0, os.getcwd())
    try:
        with own_errors(f"learner {place}"):
            return name, _described(name, getattr(import_module(module), name))
    except TypeError as error:
        raise ValueError(f"learner is {place!r}: {error}") from None
    except (ImportError, AttributeError) as error:
        raise ValueError(f"learner is {place!r}: {error}; {allowed}") from None


@contextmanager
def own_errors(name: str) -> Iterator[None]:
    """A block that calls a learner: errors outside this package become a `LearnerError` that shows where they are."""
    try:
        yield
    except (Exception, SystemExit) as error:
        report = traceback.TracebackException.from_exception(error)
        depth = len(report.stack)
        while depth and not report.stack[depth - 1].filename.startswith(_PACKAGE):
            depth -= 1
        frames = [frame for frame in report.stack[depth:] if "importlib" not in frame.filename]
        if not frames and not isinstance(error, SyntaxError):
            raise
        report.stack = traceback.StackSummary.from_list(frames)
        raise LearnerError(f"{name} failed\n{''.join(report.format()).rstrip()}") from error


def _described(name: Any, learner: Any) -> Learner:
    if not isinstance(name, str) or not name.isidentifier():
        raise ValueError(f"name of a learner is {name!r}; allowed: letters, digits and underscores")
    if isinstance(learner, OfflineImitation | InteractiveImitation | ReinforcementLearner):
        return learner
    if callable(learner):
        taken = _parameters(learner)
        missing = ", ".join(each for each, given in taken.items() if not given)
        if missing:
            raise TypeError(f"{name} takes {missing}; allowed: what makes a classifier by itself")
        title = name.replace("_", " ")
        return OfflineImitation(title, learner, seeded="random_state" in taken, diagonal="diagonal" in taken)
    raise TypeError(
        f"learner {name} is {learner!r}; allowed: OfflineImitation, InteractiveImitation, ReinforcementLearner, or "
        "what makes a classifier"
    )


def _parameters(make: Any) -> dict[str, bool]:
    """Names of the arguments that something callable takes, and whether it is called with them or without."""
    try:
        taken = inspect.signature(make).parameters.values()
    except (TypeError, ValueError):  # a builtin without a signature
        return {}
    variable = (inspect.Parameter.VAR_POSITIONAL, inspect.Parameter.VAR_KEYWORD)
    given = ("random_state", "diagonal")
    return {one.name: one.name in given or one.default is not one.empty or one.kind in variable for one in taken}
