"""The info of recall environments: the same keys for one world and for many."""

from typing import Any


def episode_info(state: Any, pose: Any, episode: Any, tracker: Any) -> dict[str, Any]:
    """The info dict.

    Args:
        state: The state, or an array with one a world.
        pose: x and y in pixels and orientation in degrees, as the camera reports them; one row a world.
        episode: An object with the fields of `task.episode.Episode`, or with arrays of them.
        tracker: An object with the fields of `task.food_tracking.FoodTracker`, or with arrays of them.
    """
    return {
        "state": state,
        "correct_behaviour": state,
        "pose": pose,
        "score": episode.score,
        "penalty": episode.penalty,
        "correct": episode.correct,
        "steps": episode.steps,
        "delivered": tracker.delivered,
        "poison_home": tracker.poison_home,
    }
