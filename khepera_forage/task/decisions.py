"""`Decisions`: everything that the thesis leaves open, each with our reading of it.

`Noise` describes devices; `Decisions` describes how we read the thesis. Every rule of the task takes its numbers from
here at run time, so that one reading can be changed in one place, for every backend.

The first value of a field is its default. The defaults were inferred from the thesis's tables of the corridor
(`benchmarks/best_decisions.py`). Where these say nothing, the defaults are those of version 0.1
(`task.decision_versions`), which were chosen with the teacher alone. The first fields, about the world, are in
`task.decision_world`.
"""

from collections import namedtuple
from dataclasses import dataclass, fields
from typing import TYPE_CHECKING, Any, Self

from khepera_forage.task.decision_fields import Field, choice, count, number
from khepera_forage.task.decision_versions import V0_1
from khepera_forage.task.decision_world import WorldDecisions


@dataclass(frozen=True, slots=True)
class Decisions(WorldDecisions):
    """How this package reads what the thesis leaves open.

    Distances between regions are in pixels of 5 mm, as in the thesis; what lies on the floor is in mm; speeds are in
    units of 8 mm/s.

    Raises:
        ValueError: A value out of range or of the wrong type; the message quotes the value and what is allowed.
    """

    # What the camera shows.
    food_beside_robot: str = choice(
        "seen at its last place",
        ("seen at its last place", "unseen", "unseen until the arm is down"),
        "4.2.2",
        "Food that the tracker has lost, such as food under the robot's marker.",
    )
    redetection_time: float = number(
        0.0, 0.0, 10.0, "s", "4.2.2", "From losing food until it is unseen, if lost food becomes unseen."
    )
    distances: str = choice(
        "straight",
        ("straight", "along the path"),
        "4.3",
        "RobotHomeDistance and RobotFoodDistance where walls stand between.",
    )
    no_food_distance: str = choice(
        "last one known",
        ("diagonal of the arena", "last one known"),
        "4.3",
        "RobotFoodDistance while there is no candidate food; the diagonal if any is known to be poisonous.",
    )
    held_food: str = choice(
        "candidate in the gripper",
        ("candidate at its last place", "no candidate", "candidate in the gripper", "hides all food"),
        "4.3",
        "How food in the gripper counts for RobotFoodDistance.",
    )

    # States (tables 4.1, 4.2; figure 4.2).
    next_to_food: float = number(
        15.0,
        10.0,
        30.0,
        "pixels",
        "4.2.1",
        "RobotNextToFoodThreshold: nearer, ORIENT begins.",
    )
    close_to_food: float = number(40.0, 20.0, 60.0, "pixels", "4.2.1", "RobotCloseToFoodThreshold.")
    equal_distance: str = choice(
        "nearer state",
        ("nearer state", "farther state"),
        "4.2.1",
        "State at a distance that equals a threshold, which matches no row of table 4.2.",
    )
    carry_margin: float = number(
        10.0,
        0.0,
        30.0,
        "arm positions",
        "4.2.1",
        "Above raised (215), up to which an arm counts as raised (fig. 4.2).",
    )

    # What the behaviours command (4.2): speeds of the wheels.
    search_speed: float = number(12.0, 4.0, 20.0, "speed units", "4.2", "SEARCH FOR FOOD.")
    home_speed: float = number(8.0, 4.0, 20.0, "speed units", "4.2", "GO HOME.")
    slow_speed: float = number(
        5.5, 2.0, 20.0, "speed units", "4.2", "MOVE SLOWLY, AVOID FOOD, AVOID HOME, RELEASE FOOD."
    )
    push_speed: float = number(8.0, 2.0, 20.0, "speed units", "4.2.3", "PUSH FOOD.")
    orient_speed: float = number(
        4.0, 1.0, 12.0, "speed units", "4.2", "ORIENT WITH FOOD, on towards the barrier."
    )
    retreat_speed: float = number(
        7.0, 1.0, 12.0, "speed units", "4.2", "Backwards, off food and out of the home."
    )
    circle_speed: float = number(
        1.5, 0.0, 12.0, "speed units", "4.2", "Mean speed of SEARCH with no food in sight, in a small circle."
    )
    turn_speed: float = number(
        5.0, 1.0, 12.0, "speed units", "4.2", "Each wheel, in a turn on the spot of up to 70 degrees."
    )
    quick_turn_speed: float = number(8.0, 1.0, 20.0, "speed units", "4.2", "The same, in a larger turn.")

    # How the behaviours orient and carry (3.4, 3.7, 4.2).
    searching_arm: str = choice(
        "raised", ("raised",), "4.2", "The arm while searching; ORIENT WITH FOOD lowers it."
    )
    search_without_food: str = choice(
        "small circle",
        ("small circle", "wander"),
        "4.2",
        "SEARCH with no food in sight; wandering is straight on, off walls.",
    )
    beside_food: str = choice(
        "back off",
        ("back off", "turn away", "drive on"),
        "4.2",
        "SEARCH and MOVE SLOWLY near food. The infra-reds turn them away, unless they back off or drive on.",
    )
    back_off_distance: float = number(
        16.0,
        0.0,
        20.0,
        "pixels",
        "4.2",
        "Distance to food from which SEARCH and MOVE SLOWLY do not shove it.",
    )
    orienting: str = choice(
        "lowered before food",
        ("lowered before food", "lowered over food"),
        "3.7",
        "ORIENT lowers the arm clear of the food, backing off if need be, or the open fingers around it.",
    )
    arm_after_orienting: str = choice(
        "raised", ("raised", "as it is"), "4.2", "The arm in MOVE SLOWLY while it is still down after ORIENT."
    )
    aimed: float = number(
        5.0, 1.0, 15.0, "degrees", "3.7", "Off the food, within which a robot counts as oriented."
    )
    astray: float = number(
        20.0, 10.0, 90.0, "degrees", "3.7", "Off the food, beyond which ORIENT raises the arm to turn."
    )
    missed_distance: float = number(
        10.0,
        5.0,
        15.0,
        "pixels",
        "3.7",
        "Nearer food is in the gripper, or the try was missed and ORIENT backs off.",
    )
    release_depth: float = number(
        7.0, 0.0, 15.0, "pixels", "4.2", "Inside the rim of the home, where food is released."
    )

    # Following (4.5.2).
    same_place: float = number(
        2.0, 0.0, 10.0, "pixels", "4.5.2", "Within this, the learner is where the teacher is."
    )
    same_heading: float = number(
        8.0, 0.0, 45.0, "degrees", "4.5.2", "Within this, both go in the same direction."
    )
    separation: float = number(
        14.0, 5.0, 40.0, "pixels", "4.5.2", 'Beyond this, they are "significantly apart".'
    )
    recovery_speed: float = number(
        6.0, 1.0, 12.0, "speed units", "4.5.2", "Of a separated learner that catches up."
    )
    following_gain: float = number(
        0.1, 0.01, 1.0, "speed units/degree", "4.5.2", "Of the arc towards the teacher."
    )
    patience: int = count(
        100, 1, 10_000, "rounds", "5.3.1", "Of separation, after which a training attempt is given up."
    )
    most_attempts: int = count(
        200, 1, 100_000, "attempts", "5.2", "At a training episode, after which it is hopeless."
    )
    rounds_after_training: int = count(
        0, 0, 200, "rounds", "5.3", "From the delivery until the operator ends a training episode."
    )
    poison_in_training: str = choice(
        "left with the arm raised",
        ("left with the arm raised",),
        "5.3",
        "When an episode with poisonous food is complete.",
    )

    # The learner (4.6.1).
    distance_arithmetic: str = choice(
        "exact",
        ("exact", "32-bit floats", "64-bit floats"),
        "4.6.1",
        "Of the distance between state vectors: sums of floats can differ where exact ones are equal.",
    )

    # Placement (5.4.1.1: "random in every recall episode").
    food_to_walls: float = number(
        50.0, 20.0, 100.0, "mm", "5.4.1.1", "From random food to the walls: the gripper fits."
    )
    food_spacing: float = number(
        100.0, 40.0, 200.0, "mm", "5.4.2.1", "Between the centres of random food objects."
    )

    # Devices.
    recall_marker: int = count(2, 1, 2, "holes", "3.5", "Of the marker of a robot that forages alone.")

    def __post_init__(self) -> None:
        WorldDecisions.__post_init__(self)
        if self.close_to_food < self.next_to_food:
            raise ValueError(
                f"decision close_to_food is {self.close_to_food!r}; allowed: at least next_to_food, "
                f"{self.next_to_food!r}"
            )

    def values(self) -> "DecisionValues":
        """The decisions as rules take them: numbers, and for a choice its position among the allowed ones."""
        numbers: list[Any] = [Field.of(field).as_number(getattr(self, field.name)) for field in fields(self)]
        return DecisionValues(*numbers)

    @classmethod
    def v0_1(cls) -> Self:
        """The decisions of version 0.1, whatever the defaults are now."""
        return cls(**V0_1)


if TYPE_CHECKING:
    DecisionValues = Decisions
else:
    DecisionValues = namedtuple("DecisionValues", [field.name for field in fields(Decisions)])
    """`Decisions` as numbers, in the same order: what rules take."""

DEFAULT_DECISIONS = Decisions()
DEFAULT_VALUES = DEFAULT_DECISIONS.values()
