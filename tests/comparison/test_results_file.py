"""`results.json`: what is written is read again, stands beside another run, and is checked."""

import csv
import json
import math
import zipfile
from pathlib import Path
from typing import Any

import pytest

from khepera_forage.comparison.learning import RecallBatch, all_learners
from khepera_forage.comparison.page import page
from khepera_forage.comparison.results import PUBLISHED, Results, as_json, curves, described, merged, read_results
from khepera_forage.policies.learners import LEARNERS

TABLE = Path(__file__).parents[2] / "docs" / "published" / "learners.zip"


def batch(amount: int, delivered: int, replication: int) -> RecallBatch:
    return RecallBatch("tree", replication, amount, "corridor", 90 * amount, 80, 10, 50.5, delivered, 10, 900, 1.0)


@pytest.fixture
def results() -> Results:
    rows = [batch(amount, amount + number, number) for number in range(3) for amount in (1, 5)]
    return Results("here", described({"tree": LEARNERS["tree"]}), curves(rows, 0))


def test_results_that_are_written_are_read_again(results: Results, tmp_path: Path) -> None:
    path = tmp_path / "results.json"
    path.write_text(as_json(results), encoding="utf-8")
    read = read_results(str(path))
    assert read.learners == results.learners
    assert read.made_with == "here"
    assert read.origin == tmp_path.name
    (curve,), (original,) = read.curves, results.curves
    assert math.isinf(curve.steps_to_success.value)
    for point, other in zip(curve.points, original.points, strict=True):
        assert (point.amount, point.batches) == (other.amount, other.batches)
        assert tuple(point.delivered) == pytest.approx(tuple(other.delivered), nan_ok=True)
        assert tuple(point.recall_steps) == pytest.approx(tuple(other.recall_steps), nan_ok=True)


def test_published_results_are_those_of_the_documentation() -> None:
    published = read_results(PUBLISHED)
    ends = {(published.learners[c.learner].title, c.arena): c.end for c in published.curves}
    with zipfile.ZipFile(TABLE) as archive:
        rows = list(csv.DictReader(archive.read("learners.csv").decode().splitlines()))
    assert len(rows) == len(ends)
    for row in rows:
        end = ends[row["learner"], row["arena"]]
        assert end.delivered.value == float(row["food delivered (%)"])
        assert end.score.value == float(row["score (%)"])
        assert end.batches == int(row["seeds"])


def test_published_rows_stand_beside_those_of_a_run(results: Results) -> None:
    tree = described(all_learners())["tree"]
    found, learners = merged(results.curves, {"tree": tree}, read_results(PUBLISHED))
    assert learners["tree"] is tree
    written = page(found, learners, {}, tuned=False)
    table: dict[Any, Any] = {row[0]: row for row in written.tables[0].rows}
    assert table["decision tree"][2].value == 60
    assert table["decision tree (published)"][2].value != 60
    assert "the teacher (published)" in table


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda c: c.update(format="other"), "no results of a comparison; allowed: a file with the format"),
        (lambda c: c.pop("learners"), "'learners' is missing"),
        (lambda c: c["curves"][0]["points"][0].pop("score"), "'score' is missing"),
        (lambda c: c["curves"][0].update(arena="kitchen"), "arena is 'kitchen'; allowed: corridor, rectangle, t_maze"),
        (lambda c: c["curves"][0].update(learner="x"), "learner is 'x'; allowed: tree"),
        (lambda c: c["curves"][0].update(gain=[1]), r"gain is \[1\]; allowed: a list of value, low and high"),
        (lambda c: c["curves"][0].update(gain=["a", 1, 2]), "gain has 'a'; allowed: a number"),
        (lambda c: c["curves"][0].update(gain=[[1], 1, 2]), r"gain has \[1\]; allowed: a number"),
        (lambda c: c["curves"][0].update(points=[]), "points of tree are empty; allowed: one or more"),
        (lambda c: c["curves"][0]["points"][0].update(amount=-1), "amount is -1; allowed: a whole number"),
        (lambda c: c["learners"]["tree"].update(learns_from="luck"), "'luck' is not a valid Supervision"),
    ],
)
def test_a_file_that_is_wrong_is_named(change: Any, message: str, results: Results, tmp_path: Path) -> None:
    content = json.loads(as_json(results))
    change(content)
    path = tmp_path / "results.json"
    path.write_text(json.dumps(content))
    with pytest.raises(ValueError, match=message) as raised:
        read_results(str(path))
    assert str(raised.value).startswith(f"{path}: ")
