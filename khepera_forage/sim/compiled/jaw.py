"""The jaw, step by step: closing on food grips it, opening releases it."""

from typing import Any

from khepera_forage.compilation.decorators import inline
from khepera_forage.robots.khepera import (
    ARM_ON_FLOOR,
    FINGER_THICKNESS,
    JAW_ON_FOOD,
    half_gap,
)
from khepera_forage.sim.compiled.gripper import between, floor_free, seen_from
from khepera_forage.sim.compiled.listed_walls import wall_in
from khepera_forage.sim.compiled.walls import gripper_behind

_CENTRED = 1.0
"""mm from the middle within which food counts as between both fingers."""
_TOUCH = 0.5
"""mm by which a finger may overlap a wall."""

half_gap = inline(half_gap)


@inline
def move_jaw(robot: Any, foods: Any, i: int, walls: Any, step: float) -> None:
    """Move the jaw of one robot for one step.

    Args:
        robot: A block of robots.
        foods: The food objects of the block.
        i: The lane.
        walls: The walls near the robot.
        step: The largest change of the jaw's position.
    """
    jaw, target = robot.jaw[i], robot.jaw_target[i]
    held = int(robot.held[i])
    if target == jaw or (held >= 0 and target < jaw):
        return
    new = min(target, jaw + step) if target > jaw else max(target, jaw - step)
    if new > jaw and _opens_into_wall(robot, i, new, walls):
        return
    low = robot.arm[i] >= ARM_ON_FLOOR
    if held >= 0:
        if not low and not floor_free(robot, foods, i):
            return
        cos, sin = robot.cos[i], robot.sin[i]
        u, v = robot.grip_x[i], robot.grip_y[i]
        food = foods[held]
        food.x[i] = robot.x[i] + u * cos - v * sin
        food.y[i] = robot.y[i] + u * sin + v * cos
        robot.held[i] = -1.0
    elif new < jaw and low:
        k = between(robot, foods, i, new)
        if k >= 0:
            new = JAW_ON_FOOD
            u, v = seen_from(robot, foods[k], i)
            if abs(v) < _CENTRED:
                robot.held[i] = k
                robot.grip_x[i], robot.grip_y[i] = u, v
    robot.jaw[i] = new


@inline
def _opens_into_wall(robot: Any, i: int, jaw: float, walls: Any) -> bool:
    """Whether a finger at this position of the jaw would overlap a wall."""
    aside = half_gap(jaw) + FINGER_THICKNESS
    into = False
    for j in range(walls.shape[0]):
        wall = wall_in(walls, j, i)
        for corner in range(4):
            _, _, depth, _, _ = gripper_behind(robot, i, corner, aside, wall)
            into = into or depth > _TOUCH
    return into
