"""Food and other robots near a simulated robot: what it may push, and what its infra-reds may see."""

from collections.abc import Sequence

import pymunk

from khepera_forage.robots.khepera import FOOD_RADIUS, RADIUS
from khepera_forage.robots.proximity import REACH
from khepera_forage.sim.broad_phase import PUSHED, SHOVED
from khepera_forage.sim.pymunk.food import PymunkFood


def may_push(
    x: float,
    y: float,
    travel: float,
    on_floor: bool,
    held: PymunkFood | None,
    foods: Sequence[PymunkFood],
    others: Sequence[pymunk.Body],
) -> tuple[bool, bool]:
    """Whether food, other than in the gripper, or another robot can be pushed, and whether that moves already.

    Args:
        x: Of the robot.
        y: Of the robot.
        travel: How far any point of it gets in this round, mm.
        on_floor: Whether its gripper is; a raised one passes above food.
        held: What it has in its gripper.
        foods: All food.
        others: The other robots.
    """
    pushing = moving = False
    reach = (PUSHED if on_floor else SHOVED) + travel
    for food in foods:
        food_x, food_y = food.place
        if (food_x - x) ** 2 + (food_y - y) ** 2 < reach * reach and food is not held:
            pushing = True
            moving = moving or food.moved > 0.0
    for body in others:
        if body.position.get_distance((x, y)) < 2 * PUSHED:
            pushing = moving = True
    return pushing, moving


def discs_near(
    x: float, y: float, foods: Sequence[PymunkFood], others: Sequence[pymunk.Body]
) -> list[tuple[float, float, float]]:
    """What stands on the floor in range of the infra-reds: x, y and radius of each, mm."""
    discs = []
    for food in foods:
        fx, fy = food.place
        if (fx - x) ** 2 + (fy - y) ** 2 < (REACH + FOOD_RADIUS) ** 2 and not food.lifted:
            discs.append((fx, fy, FOOD_RADIUS))
    for other in others:
        ox, oy = other.position
        if (ox - x) ** 2 + (oy - y) ** 2 < (REACH + RADIUS) ** 2:
            discs.append((ox, oy, RADIUS))
    return discs
