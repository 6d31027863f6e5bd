"""The account of an episode: steps, reward and end (5.3, 5.4), and decisions by state.

The functions take *records*: objects with the fields of `Episode`, `DecisionCounts` and `food_tracking.FoodTracker`.
`episode` and `counts` are changed in place.
"""

from dataclasses import dataclass, field
from typing import Any

from khepera_forage.task.decisions import DecisionValues
from khepera_forage.task.food_tracking import is_finished
from khepera_forage.task.perception import Marker
from khepera_forage.task.states import NUM_STATES, Behaviour, FoodType, StateVector, is_raised


@dataclass(slots=True)
class Episode:
    """One robot's account of an episode.

    Attributes:
        steps: Steps so far.
        correct: Steps on which the teacher would have done the same.
        reward: Of the last step.
        terminated: Whether everything is delivered or known to be poisonous.
        truncated: Whether the episode has reached its limit.
        delivered: Food brought home that is not poisonous.
        poison_home: Poisonous food brought home.
        penalty: Percent taken off for food left so far, see `penalty`.
        score: Percent so far, see `score`.
    """

    steps: int = 0
    correct: int = 0
    reward: float = 0.0
    terminated: bool = False
    truncated: bool = False
    delivered: int = 0
    poison_home: int = 0
    penalty: float = 0.0
    score: float = 0.0


@dataclass(slots=True)
class ForagerState:
    """One robot at its task, after a round.

    Attributes:
        own: Its marker.
        vector: The state vector.
        state: What the teacher classifies the state vector as.
        behaviour: What was decided on; of motors, the teacher's behaviour if they are what it commands, else WAIT.
        number: Episodes of a compiled world that began since it was seeded.
        episode: The account of its episode.
    """

    own: Marker
    vector: StateVector
    state: int = 0
    behaviour: int = 0
    number: int = 0
    episode: Episode = field(default_factory=Episode)


@dataclass(slots=True)
class DecisionCounts:
    """Decisions of a policy, counted by state.

    Attributes:
        by_state: Steps in each of the ten states.
        wrong_by_state: Those of them in which the teacher would have done something else.
        orient_without_food: Steps in which ORIENT WITH FOOD was wrong and no food was within the close threshold.
    """

    by_state: list[int] = field(default_factory=lambda: [0] * NUM_STATES)
    wrong_by_state: list[int] = field(default_factory=lambda: [0] * NUM_STATES)
    orient_without_food: int = 0


def begin_episode(episode: Any, tracker: Any) -> None:
    """Start the account of an episode, after the first perception."""
    episode.steps = episode.correct = 0
    episode.reward, episode.terminated, episode.truncated = 0.0, False, False
    _grade(episode, tracker)


def end_step(episode: Any, tracker: Any, correct: bool, limit: int) -> None:
    """Account for a step: the decision, and what it has brought.

    It was correct if the teacher would have made the same one. An episode is truncated after `limit` steps.
    """
    delivered, poison_home = tracker.delivered - episode.delivered, tracker.poison_home - episode.poison_home
    episode.steps += 1
    episode.correct += 1 if correct else 0
    episode.reward = delivered - poison_home - 1.0 / limit
    episode.terminated = is_finished(tracker)
    episode.truncated = episode.steps >= limit and not episode.terminated
    _grade(episode, tracker)


def _grade(episode: Any, tracker: Any) -> None:
    episode.delivered, episode.poison_home = tracker.delivered, tracker.poison_home
    episode.penalty = penalty(tracker.delivered, tracker.deliverable)
    episode.score = score(episode.correct, episode.steps, episode.penalty)


def has_done_its_part(
    tracker: Any, foods: Any, vector: StateVector, home_radius: float, decisions: DecisionValues
) -> bool:
    """Whether a robot has done its part of a training episode (5.3).

    It has delivered its food and left home. Poisonous food must be avoided, not just identified: otherwise no learner
    would ever be shown how. So the arm must be raised again with nothing in the gripper.
    """
    poison = False
    for food in foods:
        poison = poison or food.known == FoodType.POISONOUS
    if poison and (vector.object_presence or (decisions.has_gripper and not is_raised(vector.arms_height, decisions))):
        return False
    return is_finished(tracker) and vector.robot_home_distance > home_radius


def count_decision(counts: Any, state: int, behaviour: int, food_distance: float, decisions: DecisionValues) -> None:
    """Count a decision that was made in a state, with this `robot_food_distance` of the state vector."""
    counts.by_state[state] += 1
    # States and behaviours correspond one to one (4.4.1).
    if behaviour != state:
        counts.wrong_by_state[state] += 1
        if behaviour == Behaviour.ORIENT_WITH_FOOD and food_distance > decisions.close_to_food:
            counts.orient_without_food += 1


PENALTY_NONE_DELIVERED = 20.0
PENALTY_SOME_LEFT = 5.0


def penalty(delivered: int, deliverable: int) -> float:
    """Percent taken off for food left in the arena (5.4.1.1, 5.4.2.1).

    Args:
        delivered: Food brought home that is not poisonous.
        deliverable: All food that is not known to be poisonous; poison never counts as uncollected.
    """
    if delivered >= deliverable:
        return 0.0
    return PENALTY_SOME_LEFT if delivered else PENALTY_NONE_DELIVERED


def score(correct: int, steps: int, penalty: float) -> float:
    """Correct behaviours / steps - penalty, in percent (equation 5.1); 0 before the first step.

    Args:
        correct: Steps on which the teacher would have done the same.
        steps: All steps so far.
        penalty: See `penalty`.
    """
    return 100.0 * correct / steps - penalty if steps else 0.0
