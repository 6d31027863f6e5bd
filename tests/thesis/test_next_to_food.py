"""What votes when a robot arrives next to food."""

import numpy as np
import pytest

from khepera_forage.policies import NearestNeighbourImitator
from khepera_forage.task.states import Behaviour
from khepera_forage.thesis.orient_analysis import BEYOND, arrivals, levels_of, vote_table, votes

ON_THE_LINE = [((0, 36 + food, 0, 215, food), Behaviour.SEARCH_FOR_FOOD) for food in range(56, 30, -1)]
ON_THE_LINE += [((0, 36 + food, 0, 215, food), Behaviour.MOVE_SLOWLY) for food in range(30, 20, -1)]
ON_THE_LINE += [((0, 56, 0, 215, 20), Behaviour.ORIENT_WITH_FOOD)]


def imitator() -> NearestNeighbourImitator:
    vectors, behaviours = zip(*ON_THE_LINE, strict=True)
    return NearestNeighbourImitator(diagonal=138).fit(np.array(vectors), np.array(behaviours))


LEVELS = levels_of(imitator(), arrivals(36))


def test_a_noiseless_episode_orients_up_to_the_training_place_and_draws_lots_beyond() -> None:
    rows = {row.beyond: row for row in votes(LEVELS, 0, 1, "g1")}
    assert set(rows) == set(BEYOND)
    assert rows[-10].orient == rows[0].orient == 1.0
    for beyond in (10, 20, 40, 60):
        assert 0 < rows[beyond].orient < 0.2
        assert rows[beyond].orient + rows[beyond].move_slowly + rows[beyond].search == pytest.approx(1.0)
    # 10 pixels beyond and 20 from the food, the line from 20 to 30 pixels is equally far: 10 against 1.
    assert rows[10].search == 0.0


def test_table_has_a_line_a_place_and_a_column_an_amount_of_training() -> None:
    rows = [row for n in range(6) for k in (1, 3) for row in votes(LEVELS, n, k, "g1")]
    table = vote_table(rows, np.random.default_rng(0))
    assert len(table.rows) == len(BEYOND)
    assert [column.name for column in table.columns] == ["pixels beyond", "1 episodes", "3 episodes"]
    assert vote_table([], np.random.default_rng(0)).rows == []
