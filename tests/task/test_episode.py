"""The account of an episode: steps, reward, end, and decisions by state (5.3, 5.4)."""

import pytest

from khepera_forage.task.decisions import DEFAULT_VALUES
from khepera_forage.task.episode import (
    DecisionCounts,
    Episode,
    begin_episode,
    count_decision,
    end_step,
    has_done_its_part,
)
from khepera_forage.task.food_tracking import FoodObject, FoodTracker
from khepera_forage.task.states import Behaviour, FoodType, State, StateVector

LIMIT = 50
HOME_RADIUS = 20
CLOSE_TO_FOOD = DEFAULT_VALUES.close_to_food
OUTSIDE_HOME = StateVector(0, HOME_RADIUS + 1, 0, 215, 60)


def begun(deliverable: int = 2) -> tuple[Episode, FoodTracker]:
    """An episode and its food tracker after the first perception."""
    episode, tracker = Episode(), FoodTracker(deliverable=deliverable)
    begin_episode(episode, tracker)
    return episode, tracker


def step(episode: Episode, tracker: FoodTracker, correct: bool = True, **changes: int) -> None:
    """A step that changes the counts of the food tracker."""
    for name, value in changes.items():
        setattr(tracker, name, value)
    end_step(episode, tracker, correct, LIMIT)


@pytest.mark.parametrize(
    ("changes", "reward"),
    [
        ({}, 0.0),
        ({"delivered": 1}, 1.0),
        ({"delivered": 2}, 2.0),
        ({"poison_home": 1, "deliverable": 1}, -1.0),
        ({"delivered": 1, "poison_home": 1, "deliverable": 1}, 0.0),
        ({"deliverable": 1}, 0.0),
    ],
)
def test_reward_is_food_delivered_less_poison_brought_home_and_the_step(
    changes: dict[str, int], reward: float
) -> None:
    episode, tracker = begun()
    step(episode, tracker, True, **changes)
    assert episode.reward == pytest.approx(reward - 1 / LIMIT)
    step(episode, tracker)
    assert episode.reward == pytest.approx(-1 / LIMIT), "each delivery counts once"


def test_episode_is_terminated_once_all_deliverable_food_is_delivered() -> None:
    episode, tracker = begun()
    step(episode, tracker, delivered=1)
    assert not episode.terminated
    step(episode, tracker, deliverable=1)
    assert episode.terminated, "the other food is known to be poisonous"
    assert not episode.truncated


def test_episode_is_truncated_at_the_limit_unless_it_is_terminated() -> None:
    for delivered, expected in ((1, (False, True)), (2, (True, False))):
        episode, tracker = begun()
        for _ in range(LIMIT - 1):
            step(episode, tracker)
            assert (episode.terminated, episode.truncated) == (False, False)
        step(episode, tracker, delivered=delivered)
        assert (episode.terminated, episode.truncated) == expected


# ---------------------------------------------------------------- training episodes


def done(vector: StateVector, *types: FoodType, delivered: int = 0) -> bool:
    """Whether a robot has done its part, with food of these known types."""
    foods = [FoodObject(0, 0, known=food_type) for food_type in types]
    deliverable = sum(food_type != FoodType.POISONOUS for food_type in types)
    tracker = FoodTracker(delivered=delivered, deliverable=deliverable, foods=foods)
    return has_done_its_part(tracker, foods, vector, HOME_RADIUS, DEFAULT_VALUES)


def test_part_is_done_with_all_food_delivered_and_outside_home() -> None:
    assert done(OUTSIDE_HOME, FoodType.PICKABLE, delivered=1)
    assert not done(OUTSIDE_HOME, FoodType.PICKABLE, delivered=0)
    assert not done(OUTSIDE_HOME, FoodType.PICKABLE, FoodType.UNKNOWN, delivered=1)
    at_home = OUTSIDE_HOME._replace(robot_home_distance=HOME_RADIUS)
    assert not done(at_home, FoodType.PICKABLE, delivered=1)
    lowered = OUTSIDE_HOME._replace(arms_height=255)
    assert done(lowered, FoodType.PICKABLE, delivered=1), "the arm matters with poison only"


def test_part_with_poison_is_done_once_the_poison_is_left_with_the_arm_raised() -> None:
    assert done(OUTSIDE_HOME, FoodType.POISONOUS)
    assert done(OUTSIDE_HOME._replace(arms_height=225), FoodType.POISONOUS)
    assert not done(OUTSIDE_HOME._replace(arms_height=226), FoodType.POISONOUS)
    assert not done(OUTSIDE_HOME._replace(object_presence=1), FoodType.POISONOUS)
    assert not done(
        OUTSIDE_HOME._replace(arms_height=255), FoodType.POISONOUS, FoodType.PICKABLE, delivered=1
    )
    assert not done(OUTSIDE_HOME, FoodType.POISONOUS, FoodType.PICKABLE, delivered=0)


# ---------------------------------------------------------------- decisions by state


def test_count_decision_counts_steps_and_mistakes_by_state() -> None:
    counts = DecisionCounts()
    for state, behaviour in (
        (State.SEARCH, Behaviour.SEARCH_FOR_FOOD),
        (State.SEARCH, Behaviour.GO_HOME),
        (State.NEXT_TO_FOOD, Behaviour.ORIENT_WITH_FOOD),
        (State.AT_HOME_WITH_FOOD, Behaviour.AVOID_HOME),
    ):
        count_decision(counts, state, behaviour, 100.0, DEFAULT_VALUES)
    assert counts.by_state == [2, 0, 1, 0, 0, 0, 0, 0, 0, 1]
    assert counts.wrong_by_state == [1, 0, 0, 0, 0, 0, 0, 0, 0, 1]
    assert counts.orient_without_food == 0


@pytest.mark.parametrize(
    ("state", "behaviour", "distance", "expected"),
    [
        (State.SEARCH, Behaviour.ORIENT_WITH_FOOD, CLOSE_TO_FOOD + 1, 1),
        (State.CLOSE_TO_FOOD, Behaviour.ORIENT_WITH_FOOD, CLOSE_TO_FOOD, 0),
        (State.NEXT_TO_FOOD, Behaviour.ORIENT_WITH_FOOD, CLOSE_TO_FOOD + 1, 0),
        (State.SEARCH, Behaviour.MOVE_SLOWLY, CLOSE_TO_FOOD + 1, 0),
    ],
)
def test_orienting_without_food_is_a_mistake_beyond_the_close_threshold(
    state: State, behaviour: Behaviour, distance: float, expected: int
) -> None:
    counts = DecisionCounts()
    count_decision(counts, state, behaviour, distance, DEFAULT_VALUES)
    assert counts.orient_without_food == expected
