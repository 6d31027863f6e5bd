"""The gripper turret: the places of its fingers and its palm, and the food between or below them."""

import math
from typing import Any

from khepera_forage.compilation.decorators import inline
from khepera_forage.robots.khepera import (
    BARRIER,
    FINGER_THICKNESS,
    FINGER_TIP,
    FOOD_RADIUS,
    JAW_OPEN,
    JAW_ROOT,
    half_gap,
)

_THIN = FINGER_THICKNESS / 2
_TOUCH = 0.5
"""mm of play within which the fingers count as touching food."""
_PALM, _PALM_HALF = JAW_ROOT - _THIN, half_gap(JAW_OPEN) + _THIN
"""Middle and half length of the palm, mm."""
_END = FINGER_TIP - _THIN

half_gap = inline(half_gap)


@inline
def finger_overlap(u: float, v: float, jaw: float, radius: float) -> float:
    """Overlap in mm of a disc at (u, v) in the robot's frame with the nearer finger; negative when clear."""
    along = u - min(_END, max(JAW_ROOT, u))
    aside = abs(v) - half_gap(jaw) - _THIN
    return radius + _THIN - math.sqrt(along * along + aside * aside)


@inline
def palm_overlap(u: float, v: float, radius: float) -> float:
    """Overlap in mm of a disc at (u, v) with the palm behind the fingers; negative when clear."""
    along = u - _PALM
    aside = max(abs(v) - _PALM_HALF, 0.0)
    return radius + _THIN - math.sqrt(along * along + aside * aside)


@inline
def push_out(u: float, v: float, jaw: float, radius: float) -> tuple[float, float, float]:
    """Overlap in mm of a disc with the gripper, and the way out as a unit vector in the robot's frame."""
    fingers, palm = finger_overlap(u, v, jaw, radius), palm_overlap(u, v, radius)
    if fingers >= palm:
        depth = fingers
        along = u - min(_END, max(JAW_ROOT, u))
        aside = math.copysign(1.0, v) * (abs(v) - half_gap(jaw) - _THIN)
    else:
        depth = palm
        along = u - _PALM
        aside = math.copysign(1.0, v) * max(abs(v) - _PALM_HALF, 0.0)
    far = math.sqrt(along * along + aside * aside)
    if far < 1e-9:
        return depth, 1.0, 0.0
    return depth, along / far, aside / far


@inline
def in_barrier(u: float, v: float, jaw: float) -> bool:
    """Whether a food disc at (u, v) in the robot's frame cuts the optical barrier between the fingers."""
    lateral = max(abs(v) - half_gap(jaw), 0.0)
    ahead = u - BARRIER
    return ahead * ahead + lateral * lateral < FOOD_RADIUS * FOOD_RADIUS


@inline
def seen_from(robot: Any, food: Any, i: int) -> tuple[float, float]:
    """Place of a food object in the robot's frame, mm forward and left."""
    dx = food.x[i] - robot.x[i]
    dy = food.y[i] - robot.y[i]
    cos, sin = robot.cos[i], robot.sin[i]
    return dx * cos + dy * sin, dy * cos - dx * sin


@inline
def floor_free(robot: Any, foods: Any, i: int) -> bool:
    """Whether held food could be set down without touching other food."""
    held = robot.held[i]
    free = True
    for k in range(foods.shape[0]):
        food = foods[k]
        u, v = seen_from(robot, food, i)
        du, dv = u - robot.grip_x[i], v - robot.grip_y[i]
        if k != held and du * du + dv * dv < 4 * FOOD_RADIUS * FOOD_RADIUS:
            free = False
    return free


@inline
def room_below(robot: Any, foods: Any, i: int) -> bool:
    """Whether the arm can be lowered: no food below the fingers or below held food."""
    held = robot.held[i]
    if held >= 0.0 and not floor_free(robot, foods, i):
        return False
    finger = half_gap(robot.jaw[i]) + _THIN
    near = (FOOD_RADIUS - _TOUCH) ** 2
    free = True
    for k in range(foods.shape[0]):
        food = foods[k]
        if k == held:
            continue
        u, v = seen_from(robot, food, i)
        ahead = max(JAW_ROOT - u, u - FINGER_TIP, 0.0)
        aside = max(abs(abs(v) - finger) - _THIN, 0.0)
        behind = max(abs(v) - finger, 0.0)
        palm = u - JAW_ROOT + _THIN
        if ahead * ahead + aside * aside < near or palm * palm + behind * behind < near:
            free = False
    return free


@inline
def between(robot: Any, foods: Any, i: int, jaw: float) -> int:
    """Number of the food object that the fingers hold when the jaw closes to this position; -1 without."""
    found = -1
    if half_gap(jaw) <= FOOD_RADIUS:
        for k in range(foods.shape[0] - 1, -1, -1):
            u, v = seen_from(robot, foods[k], i)
            if JAW_ROOT < u < FINGER_TIP and abs(v) < half_gap(robot.jaw[i]):
                found = k
    return found
