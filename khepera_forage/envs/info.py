"""The info of recall environments: the same keys for one world and for many."""

from typing import Any


def episode_info(
    state: Any,
    pose: Any,
    score: Any,
    penalty: Any,
    correct: Any,
    steps: Any,
    delivered: Any,
    poison_home: Any,
) -> dict[str, Any]:
    """The info dict; every argument is one value, or an array with one element or row a world.

    Args:
        state: The state.
        pose: x and y in pixels and orientation in degrees, as the camera reports them.
        score: Equation 5.1, in percent.
        penalty: Taken off the score for food left in the arena, in percent.
        correct: Steps on which the teacher would have done the same.
        steps: Steps so far.
        delivered: Food brought home that is not poisonous.
        poison_home: Poisonous food brought home.
    """
    return {
        "state": state,
        "correct_behaviour": state,
        "pose": pose,
        "score": score,
        "penalty": penalty,
        "correct": correct,
        "steps": steps,
        "delivered": delivered,
        "poison_home": poison_home,
    }
