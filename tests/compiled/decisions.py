"""Sets of decisions that between them have each alternative that is not the default."""

from khepera_forage.task.decisions import Decisions

DECISIONS = (
    Decisions(),
    Decisions(next_to_food=17, close_to_food=36, equal_distance="farther state", separation=8, same_place=1),
    Decisions(
        food_beside_robot="unseen until the arm is down",
        redetection_time=0.3,
        no_food_distance="last one known",
        held_food="no candidate",
        search_without_food="wander",
        beside_food="drive on",
        orienting="lowered over food",
        arm_after_orienting="as it is",
        rounds_after_training=5,
        distance_arithmetic="32-bit floats",
    ),
    Decisions(
        food_beside_robot="unseen",
        held_food="candidate in the gripper",
        beside_food="turn away",
        distance_arithmetic="64-bit floats",
    ),
    Decisions(held_food="hides all food"),
)
"""The defaults, other numbers, and each reading that is not the default at least once."""
IDS = ("default", "numbers", "readings", "more readings", "hidden")
