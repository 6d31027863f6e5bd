"""The info of recall environments: the same keys for one world and for many."""

from typing import Any

OF_EPISODE = ("score", "penalty", "correct", "steps")
OF_FOOD = ("delivered", "poison_home")


def episode_info(state: Any, pose: Any, episode: Any, tracker: Any) -> dict[str, Any]:
    """The info dict.

    Args:
        state: The state, or an array with one a world.
        pose: x and y in pixels and orientation in degrees, as the camera reports them; one row a world.
        episode: A `task.episode.Episode`, or a numpy array with its fields, one element a world.
        tracker: A `task.food_tracking.FoodTracker`, or a numpy array with its fields.

    Returns:
        Values as given; arrays are fresh.
    """
    info = {"state": state, "correct_behaviour": _fresh(state), "pose": pose}
    info |= {name: _read(episode, name) for name in OF_EPISODE}
    return info | {name: _read(tracker, name) for name in OF_FOOD}


def _read(record: Any, name: str) -> Any:
    dtype = getattr(record, "dtype", None)
    return getattr(record, name) if dtype is None else record[name].copy()


def _fresh(value: Any) -> Any:
    return value.copy() if hasattr(value, "copy") else value
