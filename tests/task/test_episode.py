"""When a robot has done its part of a training, and the score of a recall (5.3, 5.4).

Rewards, ends and mistakes are counted step by step in `tests/rollouts/test_training_and_recall.py`.
"""

import pytest

from khepera_forage.task.decisions import DEFAULT_VALUES
from khepera_forage.task.episode import Episode, end_step, has_done_its_part, penalty, score
from khepera_forage.task.food_tracking import FoodObject, FoodTracker
from khepera_forage.task.states import FoodType, StateVector
from khepera_forage.thesis import appendix_a

HOME_RADIUS = 20
OUTSIDE_HOME = StateVector(0, HOME_RADIUS + 1, 0, 215, 60)


P, X, U = FoodType.PICKABLE, FoodType.POISONOUS, FoodType.UNKNOWN


@pytest.mark.parametrize(
    ("changes", "types", "delivered", "done"),
    [
        ({}, [P], 1, True),
        ({}, [P, U], 1, False),
        ({"robot_home_distance": HOME_RADIUS}, [P], 1, False),
        ({"arms_height": 255}, [P], 1, True),  # the arm matters with poison only
        ({}, [X], 0, True),
        ({"arms_height": 225}, [X], 0, True),
        ({"arms_height": 226}, [X], 0, False),
        ({"object_presence": 1}, [X], 0, False),
        ({"arms_height": 255}, [X, P], 1, False),
    ],
)
def test_part_is_done_outside_home_with_food_delivered_and_poison_left_with_the_arm_raised(
    changes: dict[str, int], types: list[FoodType], delivered: int, done: bool
) -> None:
    foods = [FoodObject(0, 0, known=food_type) for food_type in types]
    tracker = FoodTracker(delivered=delivered, deliverable=len(types) - types.count(X))
    vector = OUTSIDE_HOME._replace(**changes)
    assert has_done_its_part(tracker, foods, vector, HOME_RADIUS, DEFAULT_VALUES) is done


def test_episode_that_ends_at_its_limit_is_terminated_and_not_truncated() -> None:
    episode = Episode()
    end_step(episode, FoodTracker(delivered=1, deliverable=1), True, limit=1)
    assert (episode.terminated, episode.truncated) == (True, False)


def test_score_is_equation_5_1_and_agrees_with_appendix_a() -> None:
    assert (penalty(0, 2), penalty(1, 2), penalty(2, 2)) == (20.0, 5.0, 0.0)
    assert penalty(0, 0) == 0.0, "poison never counts as uncollected"
    agreeing = 0
    for row in appendix_a.RECALLS:
        share = 100 * row.correct / row.total
        if int(share) == row.percent and row.score == row.percent - row.points:  # a row without an error
            foods = 1 if row.arena == "corridor" else 2
            found = score(row.correct, row.total, penalty(row.delivered(foods), foods))
            assert int(found + 1e-9) == row.score
            agreeing += 1
    assert agreeing > 80
