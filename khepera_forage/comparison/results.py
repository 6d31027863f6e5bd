"""Learning curves, and the file that keeps them: written by every run, and read again to stand beside another run's.

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
infinite.
"""

import json
import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from khepera_forage.comparison.learning import ALL_ARENAS, Compared, RecallBatch, settings_text
from khepera_forage.estimates import UNKNOWN, Estimate, Measure, bootstrap_quantile, difference, mean, pick
from khepera_forage.files import utf8
from khepera_forage.policies.learners import Supervision

FORMAT = "khepera_forage comparison 1"
PUBLISHED = "published"
"""Stands for the results that come with the package."""
_PUBLISHED_FILE = Path(__file__).with_name("published.json")
SUCCESS = 0.8
"""Share of the food that counts as success."""
DELIVERED = Measure[RecallBatch]("food delivered (%)", lambda row: 100.0 * row.delivered, lambda row: row.foods)
MEASURES = (
    Measure[RecallBatch]("steps", lambda row: row.steps),
    Measure[RecallBatch]("vectors", lambda row: row.vectors),
    Measure[RecallBatch]("score (%)", lambda row: row.score * row.recalls, lambda row: row.recalls),
    DELIVERED,
    Measure[RecallBatch]("steps a recall", lambda row: row.recall_steps, lambda row: row.recalls),
    Measure[RecallBatch]("seconds", lambda row: row.seconds),
)
"""In the order of the fields of `CurvePoint`."""


class CurvePoint(NamedTuple):
    """A learner after one amount of training episodes, queries or steps: means, with intervals over replications."""

    amount: int
    batches: int
    steps: Estimate
    vectors: Estimate
    score: Estimate
    delivered: Estimate
    recall_steps: Estimate
    seconds: Estimate


class ReadLearner(NamedTuple):
    """A learner as tables, figures and results files have it; `needs` is None if it learns nothing."""

    title: str
    needs: Supervision | None
    settings: str


def described(learners: Mapping[str, Compared]) -> dict[str, ReadLearner]:
    """Learners as tables, figures and results files have them."""
    return {name: ReadLearner(one.title, one.needs, settings_text(one)) for name, one in learners.items()}


class Curve(NamedTuple):
    """One learner in one arena.

    Attributes:
        steps_to_success: Steps after which a replication first delivered the share `SUCCESS` of the food; the median
            over replications, infinite if more than half never did.
        gain: Percentage points of the food delivered after all of the learning, minus those after the first amount.
        points: In increasing order of the amount.
    """

    learner: str
    arena: str
    steps_to_success: Estimate
    gain: Estimate
    points: tuple[CurvePoint, ...]

    @property
    def end(self) -> CurvePoint:
        """After all of the learning."""
        return self.points[-1]


def curves(rows: Sequence[RecallBatch], seed: int) -> list[Curve]:
    """A curve for each learner and arena, in the order of the rows.

    The resamples of every curve have the same seed, so that it does not depend on which others there are.
    """
    groups: dict[tuple[str, str], list[RecallBatch]] = {}
    for row in rows:
        groups.setdefault((row.learner, row.arena), []).append(row)
    return [_curve(own, np.random.default_rng(seed)) for own in groups.values()]


def _curve(rows: Sequence[RecallBatch], rng: np.random.Generator) -> Curve:
    parts = {amount: pick(rows, amount=amount) for amount in sorted({row.amount for row in rows})}
    points = tuple(
        CurvePoint(amount, len(own), *(mean(own, measure, rng) for measure in MEASURES))
        for amount, own in parts.items()
    )
    first, *_, last = (*parts.values(), *parts.values())
    firsts = {row.replication: math.inf for row in rows}
    for row in rows:
        if row.delivered >= SUCCESS * row.foods:
            firsts[row.replication] = min(firsts[row.replication], row.steps)
    to_success = bootstrap_quantile([_First(*own) for own in firsts.items()], lambda row: row.steps, 0.5, rng)
    gain = difference(last, first, DELIVERED, rng) if len(parts) > 1 else UNKNOWN
    return Curve(rows[0].learner, rows[0].arena, to_success, gain, points)


class _First(NamedTuple):
    """Steps to the first success of a replication; infinite without success."""

    replication: int
    steps: float


class Results(NamedTuple):
    """What a results file holds, and its origin in one word: `published`, or the name of the folder or file."""

    made_with: str
    learners: Mapping[str, ReadLearner]
    curves: Sequence[Curve]
    origin: str = ""


def as_json(results: Results) -> str:
    """The text of a results file."""
    learners = {
        name: {"title": one.title, "learns_from": one.needs.value if one.needs else None, "settings": one.settings}
        for name, one in results.learners.items()
    }
    lines = [json.dumps(_plain(curve), ensure_ascii=False) for curve in results.curves]
    head = {"format": FORMAT, "made_with": results.made_with, "learners": learners}
    text = json.dumps(head, indent=1, ensure_ascii=False).removesuffix("\n}")
    return f'{text},\n "curves": [\n  ' + ",\n  ".join(lines) + "\n ]\n}\n"


def read_results(source: str) -> Results:
    """Read a results file: a path, or `published` for the results that come with the package.

    Raises:
        ValueError: It is no results file; the message names the file and what is wrong.
        OSError: It cannot be read.
    """
    path = _PUBLISHED_FILE if source == PUBLISHED else Path(source)
    origin = path.stem if source == PUBLISHED or path.stem != "results" else path.resolve().parent.name
    try:
        content = json.loads(utf8(path.read_bytes()))
        if not isinstance(content, dict) or content.get("format") != FORMAT:
            raise ValueError(f"no results of a comparison; allowed: a file with the format {FORMAT!r}")
        learners = {}
        for name, one in content["learners"].items():
            needs = Supervision(one["learns_from"]) if one["learns_from"] else None
            learners[name] = ReadLearner(one["title"], needs, one["settings"])
        curves = [_curve_of(value, learners) for value in content["curves"]]
        return Results(str(content["made_with"]), learners, curves, origin)
    except (json.JSONDecodeError, UnicodeDecodeError, RecursionError) as error:
        raise ValueError(f"{path}: not JSON: {error}; allowed: a results.json of khepera-forage compare") from None
    except (ValueError, KeyError, TypeError, AttributeError) as error:
        what = f"{error.args[0]!r} is missing" if isinstance(error, KeyError) else error
        raise ValueError(f"{path}: {what}") from None


def merged(
    own: Sequence[Curve], learners: Mapping[str, ReadLearner], other: Results | None
) -> tuple[list[Curve], dict[str, ReadLearner]]:
    """The curves and learners of a run, and behind them those of a results file, with its origin in their titles."""
    if other is None:
        return list(own), dict(learners)
    mark = f"({other.origin})"
    behind = [curve._replace(learner=f"{curve.learner} {mark}") for curve in other.curves]
    read = {f"{name} {mark}": one._replace(title=f"{one.title} {mark}") for name, one in other.learners.items()}
    return [*own, *behind], {**learners, **read}


def _plain(value: Any) -> Any:
    """A curve, or a part of it, as JSON has it."""
    if isinstance(value, Estimate):
        return [None if math.isnan(v) else "inf" if math.isinf(v) else float(f"{v:.6g}") for v in value]
    if isinstance(value, Curve | CurvePoint):
        return {name: _plain(part) for name, part in value._asdict().items()}
    return [_plain(part) for part in value] if isinstance(value, tuple) else value


def _curve_of(value: Any, learners: Mapping[str, ReadLearner]) -> Curve:
    name, arena = value["learner"], value["arena"]
    if name not in learners:
        raise ValueError(f"learner is {name!r}; allowed: {', '.join(learners)}")
    if arena not in ALL_ARENAS:
        raise ValueError(f"arena is {arena!r}; allowed: {', '.join(ALL_ARENAS)}")
    means = CurvePoint._fields[2:]
    points = tuple(
        CurvePoint(_count(one, "amount"), _count(one, "batches"), *(_estimate(one, key) for key in means))
        for one in value["points"]
    )
    if not points:
        raise ValueError(f"points of {name} are empty; allowed: one or more")
    return Curve(name, arena, _estimate(value, "steps_to_success"), _estimate(value, "gain"), points)


def _count(value: Any, key: str) -> int:
    number = value[key]
    if type(number) is not int or number < 0:
        raise ValueError(f"{key} is {number!r}; allowed: a whole number of at least 0")
    return number


def _estimate(value: Any, key: str) -> Estimate:
    known = {None: math.nan, "inf": math.inf}
    numbers = value[key]
    if not isinstance(numbers, list) or len(numbers) != 3:
        raise ValueError(f"{key} is {numbers!r}; allowed: a list of value, low and high")
    for number in numbers:
        if type(number) not in (int, float) and number not in (None, "inf"):
            raise ValueError(f'{key} has {number!r}; allowed: a number, null or "inf"')
    return Estimate(*(known[number] if number in known else float(number) for number in numbers))
