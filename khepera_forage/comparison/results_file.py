"""The results of a comparison as JSON: written by every run, and read again to stand beside another run's.

```json
{
  "format": "khepera_forage comparison 1",
  "made_with": "khepera-forage 0.2.0, decisions v1: khepera-forage compare --seeds 10 ...",
  "learners": {"tree": {"title": "decision tree", "learns_from": "experience vectors", "settings": "tree()"}},
  "curves": [
    {
      "learner": "tree", "arena": "corridor", "steps_to_success": [1524, null, null], "gain": [12.5, 3.1, 20.2],
      "points": [{"amount": 1, "batches": 10, "steps": [219.4, 205.0, 233.1], "delivered": [41, 30, 52], "...": []}]
    }
  ]
}
```

An estimate is a list of value, low and high end of its interval, with null for what is not known and "inf" for
infinite. `khepera_forage.comparison.curves` describes the fields.
"""

import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from khepera_forage.comparison.curves import Curve, Point
from khepera_forage.comparison.learning import Compared
from khepera_forage.comparison.rows import ARENAS
from khepera_forage.experiments.statistics import Estimate
from khepera_forage.policies.learners import Needs

FORMAT = "khepera_forage comparison 1"
PUBLISHED = "published"
"""Stands for the results that come with the package."""
_PUBLISHED_FILE = Path(__file__).with_name("published.json")
_ESTIMATES = Point._fields[2:]


@dataclass(frozen=True, slots=True)
class ReadLearner:
    """A learner of a results file.

    Attributes:
        title: For tables and figures.
        needs: What it learned from; None if it learns nothing.
        settings: In one line.
    """

    title: str
    needs: Needs | None
    settings: str


Shown = Compared | ReadLearner
"""What tables and figures show."""


@dataclass(frozen=True, slots=True)
class Results:
    """What a results file holds.

    Attributes:
        made_with: Version and command, in one line.
        learners: By name.
        curves: One a learner and arena.
        origin: Where they were read, in one word: `published`, or the name of the folder or file.
    """

    made_with: str
    learners: Mapping[str, ReadLearner]
    curves: Sequence[Curve]
    origin: str = ""


def as_json(results: Results) -> str:
    """The text of a results file."""
    learners = {
        name: {
            "title": learner.title,
            "learns_from": learner.needs.value if learner.needs else None,
            "settings": learner.settings,
        }
        for name, learner in results.learners.items()
    }
    lines = [json.dumps(_curve_as_json(curve), ensure_ascii=False) for curve in results.curves]
    head = {"format": FORMAT, "made_with": results.made_with, "learners": learners}
    text = json.dumps(head, indent=1, ensure_ascii=False).removesuffix("\n}")
    return f'{text},\n "curves": [\n  ' + ",\n  ".join(lines) + "\n ]\n}\n"


def read_results(source: str) -> Results:
    """Read a results file.

    Args:
        source: Its path, or `published` for the results that come with the package.

    Raises:
        ValueError: It is no results file; the message names the file and what is wrong.
        OSError: It cannot be read.
    """
    path = _PUBLISHED_FILE if source == PUBLISHED else Path(source)
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
        if not isinstance(content, dict) or content.get("format") != FORMAT:
            raise ValueError(f"no results of a comparison; allowed: a file with the format {FORMAT!r}")
        learners = {name: _learner(value) for name, value in content["learners"].items()}
        curves = [_curve(value, learners) for value in content["curves"]]
        return Results(str(content["made_with"]), learners, curves, _origin(source, path))
    except (ValueError, KeyError, TypeError, AttributeError) as error:
        what = f"{error.args[0]!r} is missing" if isinstance(error, KeyError) else error
        raise ValueError(f"{path}: {what}") from None


def beside(
    own: Sequence[Curve], learners: Mapping[str, Compared], other: Results | None
) -> tuple[list[Curve], dict[str, Shown]]:
    """The curves and learners of a run, and behind them those of a results file, with its origin in their titles.

    Args:
        own: Of this run.
        learners: Theirs.
        other: What was read; None for nothing.
    """
    if other is None:
        return list(own), dict(learners)
    mark = f"({other.origin})"
    names = {name: f"{name} {mark}" for name in other.learners}
    read = {names[name]: replace(one, title=f"{one.title} {mark}") for name, one in other.learners.items()}
    behind = [replace(curve, learner=names[curve.learner]) for curve in other.curves]
    return [*own, *behind], {**learners, **read}


def _origin(source: str, path: Path) -> str:
    if source == PUBLISHED or path.stem != "results":
        return path.stem
    return path.resolve().parent.name


def _curve_as_json(curve: Curve) -> dict[str, Any]:
    return {
        "learner": curve.learner,
        "arena": curve.arena,
        "steps_to_success": _numbers(curve.steps_to_success),
        "gain": _numbers(curve.gain),
        "points": [
            {
                "amount": point.amount,
                "batches": point.batches,
                **{name: _numbers(getattr(point, name)) for name in _ESTIMATES},
            }
            for point in curve.points
        ],
    }


def _numbers(estimate: Estimate) -> list[float | str | None]:
    return [None if math.isnan(v) else "inf" if math.isinf(v) else float(f"{v:.6g}") for v in estimate]


def _learner(value: Any) -> ReadLearner:
    source = value["learns_from"]
    return ReadLearner(str(value["title"]), None if source is None else Needs(source), str(value["settings"]))


def _curve(value: Any, learners: Mapping[str, ReadLearner]) -> Curve:
    name, arena = value["learner"], value["arena"]
    if name not in learners:
        raise ValueError(f"learner is {name!r}; allowed: {', '.join(learners)}")
    if arena not in ARENAS:
        raise ValueError(f"arena is {arena!r}; allowed: {' or '.join(ARENAS)}")
    points = tuple(
        Point(_count(p, "amount"), _count(p, "batches"), *(_estimate(p, key) for key in _ESTIMATES))
        for p in value["points"]
    )
    if not points:
        raise ValueError(f"points of {name} are empty; allowed: one or more")
    # Ranks the learners of one run, which is not done again here.
    unranked = math.nan
    return Curve(
        name, arena, points, _estimate(value, "steps_to_success"), unranked, _estimate(value, "gain")
    )


def _count(value: Any, key: str) -> int:
    number = value[key]
    if type(number) is not int or number < 0:
        raise ValueError(f"{key} is {number!r}; allowed: a whole number of at least 0")
    return number


def _estimate(value: Any, key: str) -> Estimate:
    numbers = value[key]
    if not isinstance(numbers, list) or len(numbers) != 3:
        raise ValueError(f"{key} is {numbers!r}; allowed: a list of value, low and high")
    return Estimate(*(_number(number, key) for number in numbers))


def _number(number: Any, key: str) -> float:
    if number is None:
        return math.nan
    if number == "inf":
        return math.inf
    if type(number) not in (int, float):
        raise ValueError(f'{key} has {number!r}; allowed: a number, null or "inf"')
    return float(number)
