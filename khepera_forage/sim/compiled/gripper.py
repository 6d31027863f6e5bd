"""The gripper turret of a batch: where its fingers and its palm are, and what is between or below them."""

import math

import numpy as np
from numpy.typing import NDArray

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
from khepera_forage.sim.compiled import rows as at
from khepera_forage.sim.compiled.rows import LANES

_THIN = FINGER_THICKNESS / 2
_TOUCH = 0.5
"""mm of play within which the fingers count as touching food."""
_PALM, _PALM_HALF = JAW_ROOT - _THIN, half_gap(JAW_OPEN) + _THIN
"""The middle of the palm, and half its length."""
_END = FINGER_TIP - _THIN

half_gap = inline(half_gap)


@inline
def finger_overlap(u: float, v: float, jaw: float, radius: float) -> float:
    """Mm by which a disc at (u, v) in the robot's frame overlaps the nearer finger; negative when clear."""
    along = u - min(_END, max(JAW_ROOT, u))
    aside = abs(v) - half_gap(jaw) - _THIN
    return radius + _THIN - math.sqrt(along * along + aside * aside)


@inline
def palm_overlap(u: float, v: float, radius: float) -> float:
    """The same of the palm behind the fingers."""
    along = u - _PALM
    aside = max(abs(v) - _PALM_HALF, 0.0)
    return radius + _THIN - math.sqrt(along * along + aside * aside)


@inline
def push_out(u: float, v: float, jaw: float, radius: float) -> tuple[float, float, float]:
    """How a disc comes free of the gripper: overlap in mm, and the way out as a unit vector in the robot's frame."""
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
def seen_from(s: NDArray[np.float64], f: NDArray[np.float64], food: int, i: int) -> tuple[float, float]:
    """Where a food object is in the robot's frame, mm forward and left."""
    base = food * at.FOOD_ROWS * LANES + i
    dx = f[base + at.FOOD_X * LANES] - s[at.X * LANES + i]
    dy = f[base + at.FOOD_Y * LANES] - s[at.Y * LANES + i]
    c, d = s[at.COS * LANES + i], s[at.SIN * LANES + i]
    return dx * c + dy * d, dy * c - dx * d


@inline
def floor_free(s: NDArray[np.float64], f: NDArray[np.float64], foods: int, i: int) -> bool:
    """Whether held food could be set down where it is: on no other."""
    held = s[at.HELD * LANES + i]
    free = True
    for food in range(foods):
        u, v = seen_from(s, f, food, i)
        du, dv = u - s[at.GRIP_X * LANES + i], v - s[at.GRIP_Y * LANES + i]
        if food != held and du * du + dv * dv < 4 * FOOD_RADIUS * FOOD_RADIUS:
            free = False
    return free


@inline
def room_below(s: NDArray[np.float64], f: NDArray[np.float64], foods: int, i: int) -> bool:
    """Whether the arm can come down: the fingers on nothing, held food on no other."""
    held = s[at.HELD * LANES + i]
    if held >= 0.0 and not floor_free(s, f, foods, i):
        return False
    finger = half_gap(s[at.JAW * LANES + i]) + _THIN
    near = (FOOD_RADIUS - _TOUCH) ** 2
    free = True
    for food in range(foods):
        if food == held:
            continue
        u, v = seen_from(s, f, food, i)
        ahead = max(JAW_ROOT - u, u - FINGER_TIP, 0.0)
        aside = max(abs(abs(v) - finger) - _THIN, 0.0)
        behind = max(abs(v) - finger, 0.0)
        palm = u - JAW_ROOT + _THIN
        if ahead * ahead + aside * aside < near or palm * palm + behind * behind < near:
            free = False
    return free


@inline
def between(s: NDArray[np.float64], f: NDArray[np.float64], foods: int, i: int, jaw: float) -> int:
    """The food between the fingers when they close on it to this position of the jaw; -1 without."""
    found = -1
    if half_gap(jaw) <= FOOD_RADIUS:
        for food in range(foods - 1, -1, -1):
            u, v = seen_from(s, f, food, i)
            if JAW_ROOT < u < FINGER_TIP and abs(v) < half_gap(s[at.JAW * LANES + i]):
                found = food
    return found
