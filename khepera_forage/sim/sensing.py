"""What robots sense at the end of a round: optical barrier, arm, jaw, and the eight infra-reds.

Plain functions, also compiled. `robots.proximity` says where the response of the infra-reds comes from.
"""

import math
from typing import Any

from khepera_forage.robots.khepera import ARM_DOWN, ARM_ON_FLOOR, FOOD_RADIUS, JAW_OPEN, PRESENT, RADIUS
from khepera_forage.robots.proximity import (
    HIDDEN_BY_ARM,
    MAX_READING,
    RANGE,
    REACH,
    RESPONSE_AT_RANGE,
    RESPONSE_GAIN,
    RESPONSE_OFFSET,
)
from khepera_forage.sim.draws import DRAW_PROXIMITY, draw, lower, upper
from khepera_forage.sim.gripper import grip_place, in_barrier, seen_from

_FRONT = 6
"""Sensors that a lowered arm hides."""
_HIDDEN_LOW, _HIDDEN_VALUES = float(HIDDEN_BY_ARM[0]), float(HIDDEN_BY_ARM[1] - HIDDEN_BY_ARM[0] + 1)


def sense(robots: Any, i: int, foods: Any, walls: Any, constants: Any) -> None:
    """Read all sensors of one robot; food in its gripper has moved along.

    Args:
        robots: All robots of the arena.
        i: Number of the robot.
        foods: The food objects.
        walls: The walls of its arena, `Wall` records in mm.
        constants: `Constants`.
    """
    robot = robots[i]
    if robot.has_gripper:
        _sense_gripper(robot, foods)
    else:
        _sense_food_ahead(robot, foods, constants.reach)
    for sensor in range(8):
        robot.proximity[sensor] = 0.0
    first = _FRONT if robot.arm >= ARM_ON_FLOOR else 0
    for k in range(len(walls)):
        wall = walls[k]
        if abs(wall.normal_x * robot.x + wall.normal_y * robot.y - wall.offset) < REACH:
            _see_wall(robot, wall, first, constants.sensors)
    for k in range(len(foods)):
        dx, dy = foods[k].x - robot.x, foods[k].y - robot.y
        lifted = robot.held == k and robot.arm < ARM_ON_FLOOR
        if dx * dx + dy * dy < (REACH + FOOD_RADIUS) ** 2 and not lifted:
            _see_disc(robot, foods[k].x, foods[k].y, FOOD_RADIUS, first, constants.sensors)
    for j in range(len(robots)):
        dx, dy = robots[j].x - robot.x, robots[j].y - robot.y
        if j != i and dx * dx + dy * dy < (REACH + RADIUS) ** 2:
            _see_disc(robot, robots[j].x, robots[j].y, RADIUS, first, constants.sensors)
    for pair in range(4):
        bits = draw(robot, DRAW_PROXIMITY + pair)
        one, other = 2 * pair, 2 * pair + 1
        robot.proximity[one] = _measured(robot, one, one < first, constants, upper(bits))
        robot.proximity[other] = _measured(robot, other, one < first, constants, lower(bits))


def _sense_gripper(robot: Any, foods: Any) -> None:
    robot.object_presence = 0
    raised = (1.0 + robot.arm_reading_error) * (ARM_DOWN - robot.arm)
    robot.arm_reading, robot.jaw_reading = math.floor(ARM_DOWN - raised + 0.5), math.floor(robot.jaw + 0.5)
    if robot.held >= 0:
        foods[robot.held].x, foods[robot.held].y = grip_place(robot)
    for k in range(len(foods)):
        if robot.held == k or (robot.held < 0 and robot.arm >= ARM_ON_FLOOR):
            u, v = seen_from(robot, foods[k].x, foods[k].y)
            if in_barrier(u, v, robot.jaw):
                robot.object_presence = PRESENT


def _sense_food_ahead(robot: Any, foods: Any, reach: float) -> None:
    """What stands for the readings of a gripper: an object is present while food lies before the robot."""
    robot.object_presence, robot.arm_reading, robot.jaw_reading = 0, ARM_DOWN, JAW_OPEN
    for k in range(len(foods)):
        ahead, aside = seen_from(robot, foods[k].x, foods[k].y)
        if 0.0 < ahead <= reach and abs(aside) <= FOOD_RADIUS:
            robot.object_presence = PRESENT


def _see_wall(robot: Any, wall: Any, first: int, sensors: Any) -> None:
    """Keep the readings of a wall that are the largest; `first` is the first sensor that is not hidden."""
    cos, sin = robot.cos, robot.sin
    dx, dy = wall.x1 - robot.x, wall.y1 - robot.y
    ahead, aside = dx * cos + dy * sin, dy * cos - dx * sin
    along, across = wall.ex * cos + wall.ey * sin, wall.ey * cos - wall.ex * sin
    for sensor in range(first, 8):
        dx, dy = ahead - sensors[4 * sensor], aside - sensors[4 * sensor + 1]
        t = min(1.0, max(0.0, -(dx * along + dy * across) * wall.share))
        _keep_largest(robot, sensor, dx + t * along, dy + t * across, 0.0, sensors)


def _see_disc(robot: Any, x: float, y: float, radius: float, first: int, sensors: Any) -> None:
    """Keep the readings of food or another robot that are the largest; `first` as for `_see_wall`."""
    ahead, aside = seen_from(robot, x, y)
    for sensor in range(first, 8):
        dx, dy = ahead - sensors[4 * sensor], aside - sensors[4 * sensor + 1]
        _keep_largest(robot, sensor, dx, dy, radius, sensors)


def _keep_largest(robot: Any, sensor: int, dx: float, dy: float, radius: float, sensors: Any) -> None:
    """Keep the reading of an obstacle (dx, dy) mm from a sensor, if it is the largest (see `robots.proximity`)."""
    along = dx * sensors[4 * sensor + 2] + dy * sensors[4 * sensor + 3]
    if along <= 0.0:
        return
    distance = math.sqrt(dx * dx + dy * dy)
    if distance - radius >= RANGE or 2.0 * along <= distance:
        return
    near = max(distance - radius, 0.0) + RESPONSE_OFFSET
    # One division gives both 1 / near ** 2 and along / distance.
    inverse = 1.0 / (near * near * distance)
    response = min(float(MAX_READING), RESPONSE_GAIN * (inverse * distance - RESPONSE_AT_RANGE))
    reading = response * (2.0 * along * (inverse * near * near) - 1.0)
    robot.proximity[sensor] = max(robot.proximity[sensor], reading)


def _measured(robot: Any, sensor: int, hidden: bool, constants: Any, uniform: float) -> int:
    """The reading of a sensor as a robot reports it: a whole number with noise."""
    if hidden:
        return math.floor(_HIDDEN_LOW + _HIDDEN_VALUES * (uniform if constants.proximity_gain > 0.0 else 0.5))
    clean = robot.proximity[sensor] * (1.0 + robot.infra_red_error)
    reading = min(clean * (1.0 + constants.proximity_gain * (2.0 * uniform - 1.0)), float(MAX_READING))
    floor = constants.proximity_floor
    if reading <= floor and floor > 0.0:
        reading = (floor + 1.0) * uniform
    return math.floor(float(reading))
