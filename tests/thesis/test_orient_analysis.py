"""The orient analysis: an imitator's confidence levels when a robot arrives next to food."""

import numpy as np
import pytest

from khepera_forage.policies import NearestNeighbourImitator
from khepera_forage.task.decisions import Decisions
from khepera_forage.task.states import Behaviour, State, StateVector, classify
from khepera_forage.thesis.orient_analysis import (
    PIXELS_BEYOND,
    arrival_vectors,
    imitator_levels,
    orient_rows,
    orient_table,
)
from tests.version_0_1 import V0_1

TRAINING = [((0, 36 + food, 0, 215, food), Behaviour.SEARCH_FOR_FOOD) for food in range(56, 30, -1)]
TRAINING += [((0, 36 + food, 0, 215, food), Behaviour.MOVE_SLOWLY) for food in range(30, 20, -1)]
TRAINING += [((0, 56, 0, 215, 20), Behaviour.ORIENT_WITH_FOOD)]
"""An episode without noise on the line of training, up to the first ORIENT WITH FOOD."""


@pytest.fixture(scope="module")
def imitator() -> NearestNeighbourImitator:
    vectors, behaviours = zip(*TRAINING, strict=True)
    return NearestNeighbourImitator(diagonal=138, arithmetic="exact").fit(np.array(vectors), np.array(behaviours))


@pytest.mark.parametrize("equal_distance", ["nearer state", "farther state"])
@pytest.mark.parametrize("next_to_food", [Decisions().next_to_food, 12.5, 13.5, 17.0])
def test_robot_arrives_at_the_largest_distances_next_to_food(next_to_food: float, equal_distance: str) -> None:
    decisions = Decisions(next_to_food=next_to_food, equal_distance=equal_distance, food_to_home=200)
    arrival = arrival_vectors(decisions)[-1].tolist()
    last = arrival[-1][-1]
    farther = [*arrival[-1][:-1], last + 1]
    states = [classify(StateVector(*vector), 20, decisions.values()) for vector in (*arrival, farther)]
    assert states == [*[State.NEXT_TO_FOOD] * 3, State.CLOSE_TO_FOOD]
    assert [vector[-1] for vector in arrival] == [last - 2, last - 1, last]
    assert [vector[1] - vector[-1] for vector in arrival] == [200 // 5 + PIXELS_BEYOND[-1]] * 3, "from home to the food"


def test_orient_confidence_falls_beyond_the_training_distance_and_stands_in_a_table(
    imitator: NearestNeighbourImitator,
) -> None:
    levels = imitator_levels(imitator, arrival_vectors(V0_1))
    rows = {row.beyond: row for row in orient_rows(levels, 0, 1, "g1", V0_1)}
    assert set(rows) == set(PIXELS_BEYOND)
    assert rows[-10].orient == rows[0].orient == 1.0
    for beyond in (10, 20, 40, 60):
        assert 0 < rows[beyond].orient < 0.2
        assert rows[beyond].orient + rows[beyond].move_slowly + rows[beyond].search == pytest.approx(1.0)
    # 10 pixels beyond training and 20 from the food, all vectors recorded at 20 to 30 pixels are equally near: ten
    # MOVE SLOWLY and one ORIENT WITH FOOD.
    assert rows[10].search == 0.0
    several = [row for n in range(6) for episodes in (1, 3) for row in orient_rows(levels, n, episodes, "g1", V0_1)]
    table = orient_table(several, np.random.default_rng(0))
    assert len(table.rows) == len(PIXELS_BEYOND)
    assert [column.name for column in table.columns] == ["pixels beyond", "1 episodes", "3 episodes"]
