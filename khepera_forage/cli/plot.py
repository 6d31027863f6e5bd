"""`khepera-forage plot`: draw recalls, trainings and comparisons from the files that other commands write."""

import argparse
from collections.abc import Sequence
from dataclasses import fields
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from khepera_forage.cli.options import check_file, command, option, out
from khepera_forage.comparison.learning import RecallBatch, all_learners
from khepera_forage.comparison.page import STYLES
from khepera_forage.comparison.page import figure as figure_of_curves
from khepera_forage.comparison.results import ReadLearner, Results, curves, described, merged, read_results
from khepera_forage.estimates import percent
from khepera_forage.extras import require
from khepera_forage.figures import COLOURS, GREY, OURS, SMALL, WIDTH, entry, grid, legend, levels, new_figure, save
from khepera_forage.files import utf8
from khepera_forage.option_values import given_path
from khepera_forage.policies.learners import Supervision
from khepera_forage.rollouts.row_files import read_rows
from khepera_forage.rollouts.rows import RecallRow, TrainingRow

if TYPE_CHECKING:
    from matplotlib.figure import Figure

FILES = "rows of `recall`, attempts.csv of `train`, rows.csv or results.json of `compare`"
OUTCOMES = {"complete": "o", "out of time": "X", "separated": "s"}
"""Markers of attempts at a training; others, such as a lost robot, are drawn last."""
_LINE = 0.34
"""Inches: height of a line of a figure."""


@command(
    option("files", f"of one kind: {FILES}", given_path, "FILE", nargs="+"),
    out("plot.png", "picture, whose name ends in .png"),
)
def plot_command(arguments: argparse.Namespace) -> None:
    """Draw recalls, trainings or comparisons from their files."""
    require("khepera-forage plot", "plots")
    check_file(arguments.out, (".png",))
    save(drawn(arguments.files), arguments.out)
    print(f"{arguments.out}: {', '.join(map(str, arguments.files))}")


def drawn(paths: Sequence[Path]) -> "Figure":
    """The figure of some files, which must be of one kind; a file that is given twice counts once."""
    paths = list(dict.fromkeys(paths))
    kinds, contents = zip(*map(_read, paths), strict=True)
    if len(set(kinds)) > 1:
        files = " and ".join(map(str, dict(zip(kinds, paths, strict=True)).values()))
        raise ValueError(f"{files} are of different kinds; allowed: one kind")
    forms = [path.stem for path in paths], [path.resolve().parent.name for path in paths], list(map(str, paths))
    names = next((form for form in forms if len(set(form)) == len(paths)), forms[-1]) if len(paths) > 1 else [""]
    figure: Figure = kinds[0](names, contents)
    return figure


def _read(path: Path) -> tuple[Any, Any]:
    """What draws a file, and its content."""
    if path.suffix == ".json":
        return _comparison, read_results(str(path))
    header = utf8(path.read_bytes()).partition(b"\n")[0].decode(errors="replace").strip()
    for kind, draw in ((RecallRow, _recalls), (TrainingRow, _trainings), (RecallBatch, _comparison)):
        if header == ",".join(field.name for field in fields(kind)):
            rows: Any = read_rows(path, kind)
            if rows and draw is _comparison:
                # A learner that is not known here is drawn among the imitators.
                unknown = {row.learner: ReadLearner(row.learner, Supervision.VECTORS, "") for row in rows}
                rows = Results("", unknown | described(all_learners()), curves(rows, 0))
            if rows:
                return draw, rows
            raise ValueError(f"{path} has no rows; allowed: at least one")
    raise ValueError(f"{path}: its first line is {header[:60]!r}; allowed: {FILES}")


def _recalls(names: Sequence[str], contents: Sequence[list[RecallRow]]) -> "Figure":
    """The share of the food that each learner delivers, and the score of every recall."""
    groups: dict[str, list[RecallRow]] = {}
    for name, rows in zip(names, contents, strict=True):
        for row in rows:
            label = f"{row.learner}, {row.arena} ({name})" if name else f"{row.learner}, {row.arena}"
            groups.setdefault(label, []).append(row)
    figure = new_figure(WIDTH, 1.2 + _LINE * len(groups))
    food, score = figure.subplots(1, 2)
    shares = {}
    for place, (label, rows) in enumerate(reversed(groups.items())):
        shares[label] = [percent(sum(row.delivered for row in rows), sum(row.foods for row in rows))]
        scores = [row.score for row in rows]
        score.plot(scores, [place] * len(rows), "|", ms=12, color=GREY)
        score.plot(np.mean(scores), place, "o", ms=7, mec="white", color=OURS)
    levels(food, dict(reversed(shares.items())), "food delivered (%)")
    food.set_xlim(-3, 103)
    score.set_yticks([])
    score.set_ylim(food.get_ylim())
    score.set_xlim(right=103)
    score.set_xlabel("score (%): every recall, and the mean")
    grid(score, "x")
    figure.suptitle("Recalls: food with Wilson's 95 % intervals, and score", fontsize=SMALL + 2)
    return figure


def _trainings(names: Sequence[str], contents: Sequence[list[TrainingRow]]) -> "Figure":
    """The rounds of every attempt at each experience file, by outcome."""
    groups: dict[str, list[TrainingRow]] = {}
    for name, rows in zip(names, contents, strict=True):
        for row in rows:
            groups.setdefault(f"{name}/g{row.file}".removeprefix("/"), []).append(row)
    reasons = {row.reason or "complete" for rows in groups.values() for row in rows}
    markers = OUTCOMES | dict.fromkeys(sorted(reasons - OUTCOMES.keys()), "^")
    colours = dict(zip(markers, COLOURS, strict=False))
    figure = new_figure(WIDTH, 1.6 + _LINE * len(groups))
    axes = figure.subplots()
    for place, rows in enumerate(reversed(list(groups.values()))):
        end = 0
        for row in rows:
            outcome = row.reason or "complete"
            axes.plot([end, end + row.rounds], [place, place], color=colours[outcome], lw=3)
            end += row.rounds
            axes.plot(end, place, markers[outcome], color=colours[outcome], ms=8, mec="white", zorder=3)
    for outcome, marker in markers.items():
        if outcome in reasons:
            entry(axes, outcome, colours[outcome], marker, "-")
    axes.set_yticks(range(len(groups)), list(groups)[::-1], fontsize=SMALL)
    axes.set_ylim(-0.6, len(groups) - 0.4)
    axes.set_xlim(left=0)
    axes.set_xlabel("rounds of all attempts at an experience file")
    grid(axes, "x")
    legend(figure, axes)
    figure.suptitle("Training: attempts and how they ended", fontsize=SMALL + 2)
    return figure


def _comparison(names: Sequence[str], contents: Sequence[Results]) -> "Figure":
    """The learning curves of comparisons, each with the name of its file or folder if there are several."""
    found, learners = list(contents[0].curves), dict(contents[0].learners)
    if len(names) > 1:
        found, learners = [], {}
        for name, content in zip(names, contents, strict=True):
            found, learners = merged(found, learners, content._replace(origin=name))
    shown = [curve for curve in found if curve.arena in STYLES]
    if not shown:
        raise ValueError(f"no recalls in {' or '.join(STYLES)}; allowed: results with at least one of them")
    return figure_of_curves(shown, learners)
