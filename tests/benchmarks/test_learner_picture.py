"""The picture of the learners' comparison: every learner can be told from all others, also where curves are dense."""

import numpy as np
import pytest
from matplotlib.figure import Figure
from sklearn.ensemble import RandomForestClassifier

from khepera_forage.comparison.learning import ARENAS, RecallBatch, all_learners
from khepera_forage.comparison.page import STYLES, figure
from khepera_forage.comparison.results import Curve, ReadLearner, curves, described
from khepera_forage.policies.learners import OfflineImitation, Supervision
from tests.figure_checks import check_points_are_shown, check_readable, check_shading_is_explained, lay_out, legends_of

AMOUNTS = {
    Supervision.VECTORS: (200, 550, 750, 1_100, 2_200),
    Supervision.QUERIES: (100, 200, 300, 500, 1_000),
    Supervision.STEPS: (1_000, 10_000, 100_000, 1_000_000),
    None: (0,),
}
"""Steps of the learning, as published."""


@pytest.fixture(scope="module")
def learners() -> dict[str, ReadLearner]:
    """Those of the registry, and ten that a user adds."""
    own = {f"own_{i}": OfflineImitation(f"own learner {i}", RandomForestClassifier) for i in range(10)}
    return described(all_learners() | own)


def rows_of(learners: dict[str, ReadLearner]) -> list[RecallBatch]:
    rng = np.random.default_rng(1)
    return [
        RecallBatch(name, number, amount, arena, amount, 0, 10, 50.0, int(rng.integers(0, 21)), 20, 900, 1.0)
        for name, learner in learners.items()
        for amount in AMOUNTS[learner.needs]
        for arena in ARENAS
        for number in range(6)
    ]


@pytest.fixture(scope="module")
def found(learners: dict[str, ReadLearner]) -> list[Curve]:
    return curves(rows_of(learners), 2)


@pytest.fixture(scope="module")
def drawn(found: list[Curve], learners: dict[str, ReadLearner]) -> Figure:
    return lay_out(figure(found, learners))


def test_every_learner_has_a_panel_with_its_own_curves_over_its_own_range(
    drawn: Figure, found: list[Curve], learners: dict[str, ReadLearner]
) -> None:
    """Imitators learn from 200 to 2,200 steps: on an axis up to 1,000,000 their curves cannot be told apart."""
    kinds = {learner.title: learner.needs for learner in learners.values() if learner.needs is not None}
    shares: dict[str, list[list[float]]] = {}
    for curve in found:
        points = [point.delivered.value for point in curve.points]
        shares.setdefault(learners[curve.learner].title, []).append(points)
    panels = {axes.get_title().replace("\n", " "): axes for axes in drawn.axes if axes.axison}
    assert sorted(panels) == sorted(kinds)
    for title, axes in panels.items():
        # Curves of other learners are grey and without marks.
        lines = [line for line in axes.lines if line.get_marker() not in ("", "None", None)]
        styles = [(line.get_color(), line.get_marker(), line.get_linestyle()) for line in lines]
        assert styles == [tuple(style[:3]) for style in STYLES.values()]
        assert [np.asarray(line.get_xydata())[:, 1].tolist() for line in lines] == shares[title]
        check_points_are_shown(axes)
        amounts, (low, high) = AMOUNTS[kinds[title]], axes.get_xlim()
        assert np.log(amounts[-1] / amounts[0]) > 0.8 * np.log(high / low)


def test_picture_is_readable_and_complete_in_its_legend(drawn: Figure) -> None:
    check_readable(drawn)
    check_shading_is_explained(drawn)
    labels = [text.get_text() for legend in legends_of(drawn) for text in legend.get_texts()]
    assert {"success: 80 %", "other learners of the kind"} <= set(labels)
    for arena in ARENAS:
        assert {f"the teacher, {arena}", f"random behaviours, {arena}"} <= set(labels)


def test_picture_of_references_alone_can_be_drawn(learners: dict[str, ReadLearner]) -> None:
    few = {"teacher": learners["teacher"]}
    figure(curves(rows_of(few), 3), few).draw_without_rendering()
