"""Food that is pushed in a batch: out of the robot's way, out of walls, and off other food."""

import math

import numpy as np
from numpy.typing import NDArray

from khepera_forage.compilation.decorators import inline
from khepera_forage.robots.khepera import ARM_ON_FLOOR, FINGER_TIP, FOOD_RADIUS, RADIUS
from khepera_forage.sim.compiled import rows as at
from khepera_forage.sim.compiled.gripper import push_out, seen_from
from khepera_forage.sim.compiled.rows import LANES
from khepera_forage.sim.compiled.walls import from_wall, squared_from_wall

_FRICTION = 0.04
"""Of a finger along food: pymunk's, the product of 0.2 for each."""


@inline
def push_food(
    s: NDArray[np.float64],
    f: NDArray[np.float64],
    foods: int,
    i: int,
    walls: NDArray[np.float64],
    forward: float,
    turn: float,
) -> float:
    """Move food out of the robot's way, out of walls and off other food.

    Args:
        s: The robots' rows.
        f: The food's rows.
        foods: Number of food objects in a world.
        i: The lane.
        walls: Those that are near.
        forward: How far the robot has just gone, mm: its fingers carry along what they touch.
        turn: How far it has turned, radians.

    Returns:
        How far food was moved in all, mm.
    """
    moved = 0.0
    held = s[at.HELD * LANES + i]
    low = s[at.ARM * LANES + i] >= ARM_ON_FLOOR
    for food in range(foods):
        if food == held:
            continue
        base = food * at.FOOD_ROWS * LANES + i
        from_x, from_y = f[base + at.FOOD_X * LANES], f[base + at.FOOD_Y * LANES]
        u, v = seen_from(s, f, food, i)
        if u * u + v * v > (FINGER_TIP + 4 * FOOD_RADIUS) ** 2:
            continue
        u, v = _apart(u, v, 0.0, 0.0, RADIUS + FOOD_RADIUS)
        if low:
            if held >= 0.0:
                u, v = _apart(u, v, s[at.GRIP_X * LANES + i], s[at.GRIP_Y * LANES + i], 2 * FOOD_RADIUS)
            depth, along, aside = push_out(u, v, s[at.JAW * LANES + i], FOOD_RADIUS)
            if depth > 0.0:
                # Food slides on the floor the way it is pushed: within the cone of friction it stays where it
                # touches the finger, beyond that it slips along it.
                slip = along * turn * u - aside * (forward - turn * v)
                drag = min(_FRICTION * depth, max(-_FRICTION * depth, slip))
                u, v = u + depth * along - drag * aside, v + depth * aside + drag * along
        c, d = s[at.COS * LANES + i], s[at.SIN * LANES + i]
        x, y = s[at.X * LANES + i] + u * c - v * d, s[at.Y * LANES + i] + u * d + v * c
        f[base + at.FOOD_X * LANES], f[base + at.FOOD_Y * LANES] = x, y
        moved += abs(x - from_x) + abs(y - from_y)
    if moved > 0.0:
        for food in range(foods):
            if food != held:
                moved += _settle(f, foods, i, food, held, walls)
    return moved


@inline
def _settle(
    f: NDArray[np.float64], foods: int, i: int, food: int, held: float, walls: NDArray[np.float64]
) -> float:
    """Move one food object out of walls, and others off it."""
    base = food * at.FOOD_ROWS * LANES + i
    x, y = f[base + at.FOOD_X * LANES], f[base + at.FOOD_Y * LANES]
    moved = 0.0
    for wall in range(walls.shape[0]):
        if squared_from_wall(x, y, walls, wall) < FOOD_RADIUS * FOOD_RADIUS:
            far, nx, ny = from_wall(x, y, walls, wall)
            x, y = x + nx * (FOOD_RADIUS - far), y + ny * (FOOD_RADIUS - far)
            moved += FOOD_RADIUS - far
    f[base + at.FOOD_X * LANES], f[base + at.FOOD_Y * LANES] = x, y
    for other in range(foods):
        if other != food and other != held:
            there = other * at.FOOD_ROWS * LANES + i
            from_x, from_y = f[there + at.FOOD_X * LANES], f[there + at.FOOD_Y * LANES]
            to_x, to_y = _apart(from_x, from_y, x, y, 2 * FOOD_RADIUS)
            f[there + at.FOOD_X * LANES], f[there + at.FOOD_Y * LANES] = to_x, to_y
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
