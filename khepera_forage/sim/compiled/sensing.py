"""The end of a round: held food moves along; optical barrier, arm, jaw and the eight infra-reds are read."""

import math
from typing import Any

import numpy as np

from khepera_forage.compilation.decorators import inline, kernel
from khepera_forage.compilation.packing import pack, rounded_up
from khepera_forage.counter_rng import random_bits
from khepera_forage.robots.khepera import ARM_ON_FLOOR, FOOD_RADIUS, PRESENT
from khepera_forage.robots.proximity import HIDDEN_BY_ARM, MAX_READING, RANGE, REACH, SENSORS
from khepera_forage.robots.proximity import RESPONSE_AT_RANGE as AT_RANGE
from khepera_forage.robots.proximity import RESPONSE_GAIN as GAIN
from khepera_forage.robots.proximity import RESPONSE_OFFSET as OFFSET
from khepera_forage.sim.compiled.gripper import in_barrier
from khepera_forage.sim.compiled.listed_walls import at, packed_share
from khepera_forage.sim.compiled.numbers import DRAW_PROXIMITY, DRAWS, lower, upper

_DRAWS = np.uint64(DRAWS)
_FIRST = np.uint64(DRAW_PROXIMITY)
_SENSORS = np.array(SENSORS)
_FRONT = 6
"""Sensors that a lowered arm hides."""
_LOW, _SPAN = float(HIDDEN_BY_ARM[0]), float(HIDDEN_BY_ARM[1] - HIDDEN_BY_ARM[0] + 1)


@kernel
def end_round(robot: Any, foods: Any) -> None:
    """Move held food along, and read barrier, arm and jaw."""
    lanes = robot.x.shape[0]
    for i in range(lanes):
        robot.object_presence[i] = 0.0
        robot.arm_reading[i] = math.floor(robot.arm[i] + 0.5)
        robot.jaw_reading[i] = math.floor(robot.jaw[i] + 0.5)
    for k in range(foods.shape[0]):
        food = foods[k]
        for i in range(lanes):
            held = robot.held[i]
            cos, sin = robot.cos[i], robot.sin[i]
            x, y = robot.x[i], robot.y[i]
            u, v = robot.grip_x[i], robot.grip_y[i]
            food_x = x + u * cos - v * sin if held == k else food.x[i]
            food_y = y + u * sin + v * cos if held == k else food.y[i]
            food.x[i] = food_x
            food.y[i] = food_y
            dx, dy = food_x - x, food_y - y
            crossed = in_barrier(dx * cos + dy * sin, dy * cos - dx * sin, robot.jaw[i])
            reached = held == k or (held < 0.0 and robot.arm[i] >= ARM_ON_FLOOR)
            robot.object_presence[i] = PRESENT if crossed and reached else robot.object_presence[i]


@kernel
def cast(robot: Any, foods: Any, scratch: Any, walls: Any) -> None:
    """Noise-free readings of all sensors: `robots.proximity.cast` in every world of a block."""
    lanes = robot.x.shape[0]
    for sensor in range(8):
        for i in range(lanes):
            robot.proximity[sensor, i] = 0.0
    for j in range(walls.shape[0]):
        wall = walls[j]
        nx, ny, offset = wall.normal_x, wall.normal_y, wall.offset
        for i in range(lanes):
            off = abs(at(nx, i) * robot.x[i] + at(ny, i) * robot.y[i] - at(offset, i))
            _mark(robot, scratch, i, off < REACH)
        visible = pack(scratch.in_range, scratch.lane, 0)
        count = pack(scratch.in_range_arm_down, scratch.lane, visible)
        _cast_wall(robot, scratch, wall, visible, count)
    for k in range(foods.shape[0]):
        food = foods[k]
        for i in range(lanes):
            dx, dy = food.x[i] - robot.x[i], food.y[i] - robot.y[i]
            lifted = robot.held[i] == k and robot.arm[i] < ARM_ON_FLOOR
            _mark(robot, scratch, i, dx * dx + dy * dy < (REACH + FOOD_RADIUS) ** 2 and not lifted)
        visible = pack(scratch.in_range, scratch.lane, 0)
        count = pack(scratch.in_range_arm_down, scratch.lane, visible)
        _cast_food(robot, food, scratch, visible, count)


@inline
def _mark(robot: Any, scratch: Any, i: int, near: bool) -> None:
    """Mark whether an obstacle is in range, separately for robots whose arm hides the front sensors."""
    hidden = robot.arm[i] >= ARM_ON_FLOOR
    scratch.in_range[i] = 1.0 if near and not hidden else 0.0
    scratch.in_range_arm_down[i] = 1.0 if near and hidden else 0.0


@inline
def _cast_wall(robot: Any, scratch: Any, wall: Any, visible: int, count: int) -> None:
    """Readings of one wall in the packed lanes.

    Args:
        robot: A block of robots.
        scratch: The scratch record.
        wall: The wall.
        visible: How many lanes there are whose arm does not hide the front sensors; these come first.
        count: How many packed lanes there are.
    """
    lanes = robot.x.shape[0]
    x1, y1, ex, ey, share = wall.x1, wall.y1, wall.ex, wall.ey, wall.share
    for n in range(count):
        i = scratch.lane[n]
        cos, sin = robot.cos[i], robot.sin[i]
        dx, dy, wall_x, wall_y = at(x1, i) - robot.x[i], at(y1, i) - robot.y[i], at(ex, i), at(ey, i)
        scratch.ahead[n] = dx * cos + dy * sin
        scratch.aside[n] = dy * cos - dx * sin
        scratch.along[n] = wall_x * cos + wall_y * sin
        scratch.across[n] = wall_y * cos - wall_x * sin
    (shares,) = packed_share(share, scratch, count)
    for sensor in range(8):
        reached = visible if sensor < _FRONT else count
        forward, left = _SENSORS[sensor, 0], _SENSORS[sensor, 1]
        axis, across = _SENSORS[sensor, 2], _SENSORS[sensor, 3]
        for n in range(rounded_up(reached, lanes)):
            along, aside = scratch.along[n], scratch.across[n]
            dx, dy = scratch.ahead[n] - forward, scratch.aside[n] - left
            t = min(1.0, max(0.0, -(dx * along + dy * aside) * at(shares, n)))
            scratch.reading[n] = _reading(dx + t * along, dy + t * aside, axis, across, 0.0)
        _keep_largest(robot, scratch, sensor, reached)


@inline
def _cast_food(robot: Any, food: Any, scratch: Any, visible: int, count: int) -> None:
    """Readings of one food object in the packed lanes; arguments as for `_cast_wall`."""
    lanes = robot.x.shape[0]
    for n in range(count):
        i = scratch.lane[n]
        cos, sin = robot.cos[i], robot.sin[i]
        dx, dy = food.x[i] - robot.x[i], food.y[i] - robot.y[i]
        scratch.ahead[n] = dx * cos + dy * sin
        scratch.aside[n] = dy * cos - dx * sin
    for sensor in range(8):
        reached = visible if sensor < _FRONT else count
        forward, left = _SENSORS[sensor, 0], _SENSORS[sensor, 1]
        axis, across = _SENSORS[sensor, 2], _SENSORS[sensor, 3]
        for n in range(rounded_up(reached, lanes)):
            dx, dy = scratch.ahead[n] - forward, scratch.aside[n] - left
            scratch.reading[n] = _reading(dx, dy, axis, across, FOOD_RADIUS)
        _keep_largest(robot, scratch, sensor, reached)


@inline
def _reading(dx: float, dy: float, axis: float, across: float, radius: float) -> float:
    """Reading of one sensor of an obstacle (dx, dy) mm from it: `response` times the share for its bearing."""
    along = dx * axis + dy * across
    distance = math.sqrt(dx * dx + dy * dy)
    near = max(distance - radius, 0.0) + OFFSET
    # One division gives both 1 / near ** 2 and along / distance.
    inverse = 1.0 / (near * near * distance)
    response = min(float(MAX_READING), GAIN * (inverse * distance - AT_RANGE))
    reading = response * (2.0 * along * (inverse * near * near) - 1.0)
    seen = along > 0.0 and distance - radius < RANGE and 2.0 * along > distance
    return reading if seen else 0.0


@inline
def _keep_largest(robot: Any, scratch: Any, sensor: int, count: int) -> None:
    """Keep the largest reading of one sensor."""
    for n in range(count):
        i = scratch.lane[n]
        robot.proximity[sensor, i] = max(robot.proximity[sensor, i], scratch.reading[n])


@kernel
def measure(robot: Any, constants: Any) -> None:
    """Readings as a robot reports them: `robots.proximity.measured` in every world of a block."""
    gain, floor = constants[0].proximity_gain, constants[0].proximity_floor
    for pair in range(4):
        number = _FIRST + np.uint64(pair)
        one, other = 2 * pair, 2 * pair + 1
        front = one < _FRONT
        for i in range(robot.x.shape[0]):
            bits = random_bits(robot.key[i], robot.round[i] * _DRAWS + number)
            hidden = front and robot.arm[i] >= ARM_ON_FLOOR
            robot.proximity[one, i] = _measured(robot.proximity[one, i], hidden, gain, floor, upper(bits))
            robot.proximity[other, i] = _measured(robot.proximity[other, i], hidden, gain, floor, lower(bits))


@inline
def _measured(clean: float, hidden: bool, gain: float, floor: float, draw: float) -> float:
    reading = min(clean * (1.0 + gain * (2.0 * draw - 1.0)), float(MAX_READING))
    low = (floor + 1.0) * draw if floor > 0.0 else reading
    reading = low if reading <= floor else reading
    behind = _LOW + _SPAN * (draw if gain > 0.0 else 0.5)
    return math.floor(behind if hidden else reading)
