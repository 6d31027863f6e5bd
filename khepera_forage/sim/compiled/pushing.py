"""Pushed food: out of the robot's way, out of walls, and away from other food."""

import math
from typing import Any

from khepera_forage.compilation.decorators import inline
from khepera_forage.robots.khepera import ARM_ON_FLOOR, FINGER_TIP, FOOD_RADIUS, RADIUS
from khepera_forage.sim.compiled.gripper import push_out, seen_from
from khepera_forage.sim.compiled.listed_walls import wall_in
from khepera_forage.sim.compiled.walls import from_wall, squared_from_wall

_FRICTION = 0.04
"""Friction of a finger along food: pymunk multiplies 0.2 of each."""


@inline
def push_food(robot: Any, foods: Any, i: int, walls: Any, forward: float, turn: float) -> float:
    """Move food out of the robot's way, out of walls and away from other food.

    Args:
        robot: A block of robots.
        foods: The food objects of the block.
        i: The lane.
        walls: The walls near the robot.
        forward: Distance that the robot has just moved, mm: its fingers drag food that they touch.
        turn: Angle that it has turned, radians.

    Returns:
        Sum of the distances that food was moved, mm.
    """
    moved = 0.0
    held = robot.held[i]
    low = robot.arm[i] >= ARM_ON_FLOOR
    for k in range(foods.shape[0]):
        if k == held:
            continue
        food = foods[k]
        from_x, from_y = food.x[i], food.y[i]
        u, v = seen_from(robot, food, i)
        if u * u + v * v > (FINGER_TIP + 4 * FOOD_RADIUS) ** 2:
            continue
        u, v = _apart(u, v, 0.0, 0.0, RADIUS + FOOD_RADIUS)
        if low:
            if held >= 0.0:
                u, v = _apart(u, v, robot.grip_x[i], robot.grip_y[i], 2 * FOOD_RADIUS)
            depth, along, aside = push_out(u, v, robot.jaw[i], FOOD_RADIUS)
            if depth > 0.0:
                # Within the cone of friction food moves with the point of the finger that it touches; beyond the cone
                # it slips along the finger.
                slip = along * turn * u - aside * (forward - turn * v)
                drag = min(_FRICTION * depth, max(-_FRICTION * depth, slip))
                u, v = u + depth * along - drag * aside, v + depth * aside + drag * along
        cos, sin = robot.cos[i], robot.sin[i]
        x, y = robot.x[i] + u * cos - v * sin, robot.y[i] + u * sin + v * cos
        food.x[i], food.y[i] = x, y
        moved += abs(x - from_x) + abs(y - from_y)
    if moved > 0.0:
        for k in range(foods.shape[0]):
            if k != held:
                moved += _settle(foods, k, i, held, walls)
    return moved


@inline
def _settle(foods: Any, k: int, i: int, held: float, walls: Any) -> float:
    """Move food object `k` out of walls, and others away from it; returns the sum of the distances."""
    food = foods[k]
    x, y = food.x[i], food.y[i]
    moved = 0.0
    for j in range(walls.shape[0]):
        wall = wall_in(walls, j, i)
        if squared_from_wall(x, y, wall) < FOOD_RADIUS * FOOD_RADIUS:
            far, nx, ny = from_wall(x, y, wall)
            x, y = x + nx * (FOOD_RADIUS - far), y + ny * (FOOD_RADIUS - far)
            moved += FOOD_RADIUS - far
    food.x[i], food.y[i] = x, y
    for n in range(foods.shape[0]):
        if n != k and n != held:
            other = foods[n]
            from_x, from_y = other.x[i], other.y[i]
            to_x, to_y = _apart(from_x, from_y, x, y, 2 * FOOD_RADIUS)
            other.x[i], other.y[i] = to_x, to_y
            moved += abs(to_x - from_x) + abs(to_y - from_y)
    return moved


@inline
def _apart(x: float, y: float, from_x: float, from_y: float, distance: float) -> tuple[float, float]:
    """A place, moved away from another to at least this distance."""
    dx, dy = x - from_x, y - from_y
    far = math.sqrt(dx * dx + dy * dy)
    if far >= distance or far < 1e-9:
        return x, y
    return from_x + dx * distance / far, from_y + dy * distance / far
