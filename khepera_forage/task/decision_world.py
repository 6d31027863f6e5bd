"""Decisions about the world, the first fields of `Decisions`: how long things take, and where everything stands."""

from dataclasses import dataclass

from khepera_forage.task.decision_fields import number
from khepera_forage.task.decision_set import DecisionSet


@dataclass(frozen=True, slots=True)
class WorldDecisions(DecisionSet):
    """Readings that worlds are made with, before any rule of the task.

    Raises:
        ValueError: A value out of range or of the wrong type; the message quotes the value and what is allowed.
    """

    # Time.
    round_duration: float = number(
        0.1, 0.05, 0.5, "s", "4.5", "Length of a round (MultiStep). Commands take effect together at its end."
    )
    arm_travel_time: float = number(
        0.1, 0.1, 2.0, "s", "4.2.2", "Time the arm takes between down (255) and raised (215)."
    )
    jaw_travel_time: float = number(
        0.6, 0.1, 2.0, "s", "4.2.2", "Time the jaw takes between open (200) and closed (0)."
    )

    # The set-up of figure 5.1, whose picture did not survive. The start was chosen by hand: at 90 mm, as in version
    # 0.1, trainings without noise never ended on pymunk.
    start_to_wall: float = number(
        100.0, 60.0, 200.0, "mm", "5.2", "From the robot's start to the wall behind it."
    )
    food_to_home: float = number(160.0, 120.0, 300.0, "mm", "5.2", "From the food to the centre of the home.")
    home_to_wall: float = number(
        80.0, 50.0, 150.0, "mm", "5.2", "From the home's centre to the wall behind it."
    )
    home_radius: float = number(80.0, 50.0, 110.0, "mm", "4.2.2", 'Radius of the home, "known to the robot".')
    start_aside: float = number(
        0.0, -60.0, 60.0, "mm", "5.2", "From the arena's middle line to the start, towards the left wall."
    )
    food_aside: float = number(0.0, -60.0, 60.0, "mm", "5.2", "From the middle line to the food, likewise.")
    home_aside: float = number(0.0, -60.0, 60.0, "mm", "5.2", "From the middle line to the home, likewise.")

    def __post_init__(self) -> None:
        DecisionSet.__post_init__(self)
        if self.home_radius > self.home_to_wall:
            raise ValueError(
                f"decision home_radius is {self.home_radius!r}; allowed: at most home_to_wall, {self.home_to_wall!r}"
            )
