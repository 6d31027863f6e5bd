"""Broad phase: which robots could touch something in a round, and which do at the free end of the round."""

import math
from typing import Any

from khepera_forage.compilation.decorators import inline, kernel
from khepera_forage.compilation.packing import rounded_up
from khepera_forage.robots.khepera import (
    ARM_ON_FLOOR,
    FINGER_THICKNESS,
    FINGER_TIP,
    FOOD_RADIUS,
    JAW_OPEN,
    JAW_ROOT,
    RADIUS,
    half_gap,
)
from khepera_forage.sim.broad_phase import GRIPPER_AHEAD, GRIPPER_RADIUS, PUSHED, SHOVED
from khepera_forage.sim.compiled.gripper import finger_overlap, palm_overlap
from khepera_forage.sim.compiled.listed_walls import (
    at,
    pack_near_corner,
    pack_near_wall,
    packed_corner,
    packed_wall,
    with_corner,
    with_wall,
)

_PALM = half_gap(JAW_OPEN) + FINGER_THICKNESS
_EXTENT = 94.0
"""mm from a robot's centre to the furthest point of the robot and the food in its gripper."""
_FAR = 30.0
"""mm a round from which a finger could pass through food unnoticed: the round is then calculated step by step."""

half_gap = inline(half_gap)


@kernel
def find_near(robot: Any, foods: Any, scratch: Any, walls: Any) -> None:
    """Mark the worlds in which the robot could touch food, or a wall, in this round."""
    lanes = robot.x.shape[0]
    for k in range(foods.shape[0]):
        food = foods[k]
        for i in range(lanes):
            dx, dy = food.x[i] - robot.x[i], food.y[i] - robot.y[i]
            reach = PUSHED if robot.arm[i] >= ARM_ON_FLOOR else SHOVED
            reach += scratch.travel[i]
            near = dx * dx + dy * dy < reach * reach and robot.held[i] != k
            scratch.near_food[i] = 1.0 if near else scratch.near_food[i]
    for j in range(walls.shape[0]):
        x1, y1, ex, ey, share = walls[j].x1, walls[j].y1, walls[j].ex, walls[j].ey, walls[j].share
        for i in range(lanes):
            x, y, wall_x, wall_y = robot.x[i] - at(x1, i), robot.y[i] - at(y1, i), at(ex, i), at(ey, i)
            travel = scratch.travel[i]
            t = min(1.0, max(0.0, (x * wall_x + y * wall_y) * at(share, i)))
            dx, dy = x - t * wall_x, y - t * wall_y
            reach = travel + (PUSHED if scratch.near_food[i] != 0.0 else RADIUS)
            body = dx * dx + dy * dy < reach * reach
            x += GRIPPER_AHEAD * robot.cos[i]
            y += GRIPPER_AHEAD * robot.sin[i]
            t = min(1.0, max(0.0, (x * wall_x + y * wall_y) * at(share, i)))
            dx, dy = x - t * wall_x, y - t * wall_y
            reach = travel + GRIPPER_RADIUS
            near = body or dx * dx + dy * dy < reach * reach
            scratch.near_wall[i] = 1.0 if near else scratch.near_wall[i]


@kernel
def find_wall_contacts(robot: Any, scratch: Any, near: Any, walls: Any) -> None:
    """Mark the worlds whose robot would touch a wall at the free end of the round."""
    lanes = robot.x.shape[0]
    packed = count = pack_near_wall(near, scratch)
    for n in range(count):
        i = scratch.lane[n]
        scratch.near_x[n], scratch.near_y[n] = scratch.free_x[i], scratch.free_y[i]
        scratch.near_cos[n], scratch.near_sin[n] = scratch.free_cos[i], scratch.free_sin[i]
        scratch.near_jaw[n] = scratch.free_jaw[i]
        scratch.near_from_x[n], scratch.near_from_y[n] = robot.x[i], robot.y[i]
        scratch.near_held[n] = robot.held[i]
        scratch.near_grip_x[n], scratch.near_grip_y[n] = robot.grip_x[i], robot.grip_y[i]
        scratch.near_touches[n] = 0.0
    for j in range(walls.shape[0]):
        count = with_wall(near, scratch, count, j)
        wall_x, wall_y, end_x, end_y, inverse, wall_nx, wall_ny, wall_offset = packed_wall(
            near, walls[j], scratch, count
        )
        for n in range(rounded_up(count, lanes)):
            x1, y1, ex, ey, share = at(wall_x, n), at(wall_y, n), at(end_x, n), at(end_y, n), at(inverse, n)
            nx, ny, offset = at(wall_nx, n), at(wall_ny, n), at(wall_offset, n)
            x, y = scratch.near_x[n], scratch.near_y[n]
            cos, sin = scratch.near_cos[n], scratch.near_sin[n]
            wide = half_gap(scratch.near_jaw[n]) + FINGER_THICKNESS
            # The side of the wall on which the robot is now.
            side = nx * scratch.near_from_x[n] + ny * scratch.near_from_y[n] - offset
            side = math.copysign(1.0, side)
            off = side * (nx * x + ny * y - offset)
            t = ((x - x1) * ex + (y - y1) * ey) * share
            t = min(1.0, max(0.0, t))
            dx, dy = x - x1 - t * ex, y - y1 - t * ey
            body = dx * dx + dy * dy < RADIUS * RADIUS
            # The parts of the robot's forward and left directions that lead away from the wall.
            ahead, aside = side * (nx * cos + ny * sin), abs(nx * -sin + ny * cos)
            tip = off + FINGER_TIP * ahead - wide * aside < 0.0
            root = off + JAW_ROOT * ahead - _PALM * aside < 0.0
            held = scratch.near_held[n] >= 0.0
            grip = (
                held
                and off + scratch.near_grip_x[n] * ahead - aside * abs(scratch.near_grip_y[n]) < FOOD_RADIUS
            )
            # Beyond its ends a wall touches nothing.
            along = (x - x1) * ex + (y - y1) * ey
            reach = _EXTENT * math.sqrt(ex * ex + ey * ey)
            beside = along > -reach and along < ex * ex + ey * ey + reach
            if body or (beside and (tip or root or grip)):
                scratch.near_touches[n] = 1.0
    for n in range(packed):
        i = scratch.lane[n]
        scratch.touches[i] = max(scratch.touches[i], scratch.near_touches[n])


@kernel
def find_corner_contacts(robot: Any, scratch: Any, near: Any, corners: Any) -> None:
    """Mark the worlds whose robot would touch a corner in this round."""
    if corners.shape[0] == 0:
        return
    lanes = robot.x.shape[0]
    packed = count = pack_near_corner(near, scratch)
    for n in range(count):
        i = scratch.lane[n]
        scratch.near_x[n], scratch.near_y[n] = scratch.free_x[i], scratch.free_y[i]
        scratch.near_cos[n], scratch.near_sin[n] = scratch.free_cos[i], scratch.free_sin[i]
        scratch.near_jaw[n], scratch.near_travel[n] = scratch.free_jaw[i], scratch.travel[i]
        scratch.near_touches[n] = 0.0
    for j in range(corners.shape[0]):
        count = with_corner(near, scratch, count, j)
        x, y = packed_corner(near, corners[j], scratch, count)
        for n in range(rounded_up(count, lanes)):
            dx, dy = at(x, n) - scratch.near_x[n], at(y, n) - scratch.near_y[n]
            cos, sin = scratch.near_cos[n], scratch.near_sin[n]
            u, v = dx * cos + dy * sin, dy * cos - dx * sin
            # Within a round a finger can pass a corner: all of its way counts.
            reach, jaw = scratch.near_travel[n], scratch.near_jaw[n]
            if finger_overlap(u, v, jaw, reach) > 0.0 or palm_overlap(u, v, reach) > 0.0:
                scratch.near_touches[n] = 1.0
    for n in range(packed):
        i = scratch.lane[n]
        scratch.touches[i] = max(scratch.touches[i], scratch.near_touches[n])


@kernel
def find_food_contacts(robot: Any, foods: Any, scratch: Any) -> None:
    """Mark the worlds whose robot would touch food, other than held food, at the free end of the round."""
    for k in range(foods.shape[0]):
        food = foods[k]
        for i in range(robot.x.shape[0]):
            dx, dy = food.x[i] - scratch.free_x[i], food.y[i] - scratch.free_y[i]
            cos, sin = scratch.free_cos[i], scratch.free_sin[i]
            u, v = dx * cos + dy * sin, dy * cos - dx * sin
            low = robot.arm[i] >= ARM_ON_FLOOR
            held = robot.held[i]
            reach = RADIUS + FOOD_RADIUS
            body = u * u + v * v < reach * reach
            fingers = finger_overlap(u, v, scratch.free_jaw[i], FOOD_RADIUS) > 0.0
            palm = palm_overlap(u, v, FOOD_RADIUS) > 0.0
            gx, gy = u - robot.grip_x[i], v - robot.grip_y[i]
            other = held >= 0.0 and gx * gx + gy * gy < 4 * FOOD_RADIUS * FOOD_RADIUS
            fast = scratch.travel[i] > _FAR and u * u + v * v < (FINGER_TIP + 2 * FOOD_RADIUS) ** 2
            if held != k and (body or (low and (fingers or palm or other or fast))):
                scratch.touches[i] = 1.0
