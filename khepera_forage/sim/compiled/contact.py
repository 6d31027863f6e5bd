"""Rounds in which a robot touches something, step by step: walls turn it or hold it back, and it pushes food.

Positions are corrected; no forces are integrated. Overlapping bodies are moved apart at once: food yields to the robot,
and both yield to walls. The wheels resist a shift with 0.6 of the robot's weight, and a turn with the same force at the
wheels. So a wall that touches a point further than half a wheel base aside of the robot's middle turns the robot, and a
wall that touches a nearer point shifts it. A robot stays where it is if the food before it cannot move. A finger drags
food along by friction, which keeps food before a closed jaw while the robot turns a little. Pushed food stops with the
robot: at friction 0.3 it would slide on by 1 mm from the fastest push.
"""

import math
from typing import Any

from khepera_forage.compilation.decorators import inline, kernel
from khepera_forage.compilation.packing import pack
from khepera_forage.compilation.trigonometry import cosine_sine
from khepera_forage.robots.khepera import (
    ARM_ON_FLOOR,
    FINGER_THICKNESS,
    FINGER_TIP,
    FOOD_RADIUS,
    RADIUS,
    WHEEL_BASE,
    half_gap,
)
from khepera_forage.sim.compiled.gripper import push_out, seen_from
from khepera_forage.sim.compiled.jaw import move_jaw
from khepera_forage.sim.compiled.listed_walls import corner_in, wall_in, walls_beside
from khepera_forage.sim.compiled.parameters import Parameters
from khepera_forage.sim.compiled.pushing import push_food
from khepera_forage.sim.compiled.walls import from_wall, gripper_behind, squared_from_wall
from khepera_forage.sim.pymunk.khepera import SUBSTEPS as STEPS

_REPEATS = 4
_REACH = FINGER_TIP + 2 * FOOD_RADIUS
"""mm from a robot's centre within which the robot, or food in its gripper, can touch a wall."""
_TOLERATED = 0.5
"""mm of overlap up to which a robot is not held back."""
_SETTLED = 1e-6

half_gap = inline(half_gap)


@kernel
def move_in_contact(robot: Any, foods: Any, scratch: Any, near: Any, parameters: Parameters) -> None:
    """Move the robots that touch something, step by step."""
    constants = parameters.constants
    duration = constants[0].round_duration / STEPS
    jaw_step = constants[0].jaw_speed * constants[0].round_duration / STEPS
    for n in range(pack(scratch.touches, scratch.lane, 0)):
        i = scratch.lane[n]
        # Robots away from walls need not look at any.
        walls, corners = walls_beside(near, parameters, i)
        walls = walls[: walls.shape[0] if scratch.near_wall[i] != 0.0 else 0]
        late = scratch.lag[i] * STEPS
        allowed = max(_TOLERATED, _overlap(robot, foods, i, walls, corners))
        for step in range(STEPS):
            share = late if step == 0 else 0.0
            goes = scratch.forward[i] + share * (robot.last_forward[i] - scratch.forward[i])
            turns = scratch.turn[i] + share * (robot.last_turn[i] - scratch.turn[i])
            x, y, heading = robot.x[i], robot.y[i], robot.heading[i]
            move_jaw(robot, foods, i, walls, jaw_step)
            turn, forward = turns * duration, goes * duration
            cos, sin = robot.cos[i], robot.sin[i]
            if turn != 0.0:
                cos, sin = cosine_sine(heading + turn / 2)
            _put(robot, i, x + forward * cos, y + forward * sin, heading + turn)
            moved = 1.0
            for _ in range(_REPEATS):
                moved = _off_walls(robot, i, walls, corners) + push_food(
                    robot, foods, i, walls, forward, turn
                )
                if moved < _SETTLED:
                    break
                forward = turn = 0.0
            held_back = moved >= _SETTLED and _overlap(robot, foods, i, walls, corners) > allowed
            if held_back:
                _put(robot, i, x, y, heading)
            if step == STEPS - 1:
                robot.last_forward[i] = 0.0 if held_back else scratch.forward[i]
                robot.last_turn[i] = 0.0 if held_back else scratch.turn[i]


@inline
def _put(robot: Any, i: int, x: float, y: float, heading: float) -> None:
    robot.x[i], robot.y[i] = x, y
    if heading != robot.heading[i]:
        robot.heading[i] = heading
        robot.cos[i], robot.sin[i] = cosine_sine(heading)


@inline
def _yield(robot: Any, i: int, u: float, v: float, nx: float, ny: float, depth: float) -> None:
    """Give way to a wall that pushes at (u, v) of the robot's frame, by `depth` mm along (nx, ny)."""
    cos, sin = robot.cos[i], robot.sin[i]
    lever = (u * cos - v * sin) * ny - (u * sin + v * cos) * nx
    x, y, heading = robot.x[i], robot.y[i], robot.heading[i]
    if abs(lever) > WHEEL_BASE / 2:
        _put(robot, i, x, y, heading + depth / lever)
    else:
        robot.x[i], robot.y[i] = x + nx * depth, y + ny * depth


@inline
def _off_walls(robot: Any, i: int, walls: Any, corners: Any) -> float:
    """Move the robot out of all walls; returns the sum of the overlaps, mm."""
    moved = 0.0
    wide = half_gap(robot.jaw[i]) + FINGER_THICKNESS
    for j in range(walls.shape[0]):
        wall = wall_in(walls, j, i)
        if squared_from_wall(robot.x[i], robot.y[i], wall) > _REACH * _REACH:
            continue
        far, nx, ny = from_wall(robot.x[i], robot.y[i], wall)
        if far < RADIUS:
            robot.x[i] += nx * (RADIUS - far)
            robot.y[i] += ny * (RADIUS - far)
            moved += RADIUS - far
        for corner in range(4):
            u, v, depth, nx, ny = gripper_behind(robot, i, corner, wide, wall)
            if depth > 0.0:
                _yield(robot, i, u, v, nx, ny, depth)
                moved += depth
        if robot.held[i] >= 0.0:
            u, v = robot.grip_x[i], robot.grip_y[i]
            cos, sin = robot.cos[i], robot.sin[i]
            far, nx, ny = from_wall(robot.x[i] + u * cos - v * sin, robot.y[i] + u * sin + v * cos, wall)
            if far < FOOD_RADIUS:
                _yield(robot, i, u, v, nx, ny, FOOD_RADIUS - far)
                moved += FOOD_RADIUS - far
    for j in range(corners.shape[0]):
        corner = corner_in(corners, j, i)
        dx, dy = corner.x - robot.x[i], corner.y - robot.y[i]
        cos, sin = robot.cos[i], robot.sin[i]
        u, v = dx * cos + dy * sin, dy * cos - dx * sin
        depth, along, aside = push_out(u, v, robot.jaw[i], 0.0)
        if depth > 0.0:
            _yield(robot, i, u, v, -(along * cos - aside * sin), -(along * sin + aside * cos), depth)
            moved += depth
    return moved


@inline
def _overlap(robot: Any, foods: Any, i: int, walls: Any, corners: Any) -> float:
    """The largest remaining overlap in mm: robot with walls or food, food with walls or other food."""
    worst = 0.0
    held = robot.held[i]
    low = robot.arm[i] >= ARM_ON_FLOOR
    cos, sin = robot.cos[i], robot.sin[i]
    wide = half_gap(robot.jaw[i]) + FINGER_THICKNESS
    for j in range(walls.shape[0]):
        wall = wall_in(walls, j, i)
        squared = squared_from_wall(robot.x[i], robot.y[i], wall)
        if squared > _REACH * _REACH:
            continue
        worst = max(worst, RADIUS - math.sqrt(squared))
        for corner in range(4):
            _, _, depth, _, _ = gripper_behind(robot, i, corner, wide, wall)
            worst = max(worst, depth)
    for j in range(corners.shape[0]):
        corner = corner_in(corners, j, i)
        dx, dy = corner.x - robot.x[i], corner.y - robot.y[i]
        depth, _, _ = push_out(dx * cos + dy * sin, dy * cos - dx * sin, robot.jaw[i], 0.0)
        worst = max(worst, depth)
    for k in range(foods.shape[0]):
        food = foods[k]
        u, v = seen_from(robot, food, i)
        if u * u + v * v > (FINGER_TIP + 8 * FOOD_RADIUS) ** 2:
            continue
        x, y = food.x[i], food.y[i]
        if k == held:
            x, y = (robot.x[i] + robot.grip_x[i] * cos, robot.y[i] + robot.grip_x[i] * sin)
        for j in range(walls.shape[0]):
            wall = wall_in(walls, j, i)
            worst = max(worst, FOOD_RADIUS - math.sqrt(squared_from_wall(x, y, wall)))
        if k == held:
            continue
        worst = max(worst, RADIUS + FOOD_RADIUS - math.sqrt(u * u + v * v))
        if low:
            depth, _, _ = push_out(u, v, robot.jaw[i], FOOD_RADIUS)
            worst = max(worst, depth)
        for n in range(k):
            if n != held:
                dx, dy = foods[n].x[i] - x, foods[n].y[i] - y
                worst = max(worst, 2 * FOOD_RADIUS - math.sqrt(dx * dx + dy * dy))
    return worst
