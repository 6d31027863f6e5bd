"""The gripper turret: where its fingers and its palm are, which food they touch, and the jaw that grips it.

Plain functions, also compiled.
"""

import math
from typing import Any

from khepera_forage.robots.khepera import (
    ARM_ON_FLOOR,
    BARRIER,
    FINGER_THICKNESS,
    FINGER_TIP,
    FOOD_RADIUS,
    JAW_ON_FOOD,
    JAW_OPEN,
    JAW_ROOT,
    RADIUS,
    half_gap,
)

_THIN = FINGER_THICKNESS / 2
_TOUCH = 0.5
"""mm of play within which the fingers count as touching food, and by which one may overlap a wall."""
_CENTRED = 1.0
"""mm from the middle within which food counts as between both fingers."""
_PALM, _PALM_HALF = JAW_ROOT - _THIN, half_gap(JAW_OPEN) + _THIN
"""Middle and half length of the palm, mm."""
_PALM_END = half_gap(JAW_OPEN) + FINGER_THICKNESS
"""From the middle to the outside of the palm, mm."""


def tip_of(robot: Any) -> float:
    """Mm from a robot's centre forward to the tips of its fingers."""
    return float(FINGER_TIP - robot.finger_shortage)


def seen_from(robot: Any, x: float, y: float) -> tuple[float, float]:
    """A place in the robot's frame, mm forward and left."""
    dx, dy = x - robot.x, y - robot.y
    return dx * robot.cos + dy * robot.sin, dy * robot.cos - dx * robot.sin


def grip_place(robot: Any) -> tuple[float, float]:
    """Where held food is."""
    u, v, cos, sin = robot.grip_x, robot.grip_y, robot.cos, robot.sin
    return robot.x + u * cos - v * sin, robot.y + u * sin + v * cos


def finger_overlap(u: float, v: float, tip: float, jaw: float, radius: float) -> float:
    """Overlap in mm of a disc at (u, v) in the robot's frame with the nearer finger; negative when clear."""
    along = u - min(tip - _THIN, max(JAW_ROOT, u))
    aside = abs(v) - half_gap(jaw) - _THIN
    return radius + _THIN - math.sqrt(along * along + aside * aside)


def palm_overlap(u: float, v: float, radius: float) -> float:
    """Overlap in mm of a disc at (u, v) with the palm behind the fingers; negative when clear."""
    along = u - _PALM
    aside = max(abs(v) - _PALM_HALF, 0.0)
    return radius + _THIN - math.sqrt(along * along + aside * aside)


def push_out(u: float, v: float, tip: float, jaw: float, radius: float) -> tuple[float, float, float]:
    """Overlap in mm of a disc with the gripper, and the way out as a unit vector in the robot's frame."""
    fingers, palm = finger_overlap(u, v, tip, jaw, radius), palm_overlap(u, v, radius)
    if fingers >= palm:
        depth = fingers
        along = u - min(tip - _THIN, max(JAW_ROOT, u))
        aside = math.copysign(1.0, v) * (abs(v) - half_gap(jaw) - _THIN)
    else:
        depth = palm
        along = u - _PALM
        aside = math.copysign(1.0, v) * max(abs(v) - _PALM_HALF, 0.0)
    far = math.sqrt(along * along + aside * aside)
    if far < 1e-9:
        return depth, 1.0, 0.0
    return depth, along / far, aside / far


def behind_wall(robot: Any, corner: int, wide: float, wall: Any) -> tuple[float, float, float, float, float]:
    """How far a corner of the gripper is behind a wall.

    A corner counts only if the gripper's own way to it crosses the wall: a finger from its root, the palm from the
    robot's centre. Beyond the end of a wall of an obstacle, a corner is behind its line without being in the obstacle.

    Args:
        robot: The robot.
        corner: 0 and 1 for the tips of the right and the left finger, 2 and 3 for the ends of the palm.
        wide: From the middle to the outside of the fingers, mm.
        wall: The wall.

    Returns:
        The corner in the robot's frame (mm forward, mm left), its depth behind the wall seen from the robot's side in
        mm (negative if the way to it does not cross the wall), and the wall's unit normal on the robot's side.
    """
    from_u, u = (JAW_ROOT, tip_of(robot)) if corner < 2 else (0.0, JAW_ROOT)
    v = wide if corner < 2 else _PALM_END
    v = v if corner & 1 else -v
    from_v = v if corner < 2 else 0.0
    cos, sin = robot.cos, robot.sin
    nx, ny = wall.normal_x, wall.normal_y
    off = nx * robot.x + ny * robot.y - wall.offset
    side = math.copysign(1.0, off)
    from_x, from_y = from_u * cos - from_v * sin, from_u * sin + from_v * cos
    dx, dy = (u - from_u) * cos - (v - from_v) * sin, (u - from_u) * sin + (v - from_v) * cos
    front = side * (off + nx * from_x + ny * from_y)
    depth = -front - side * (nx * dx + ny * dy)
    if front < 0.0 or depth <= 0.0:
        return u, v, -1.0, side * nx, side * ny
    share = front / max(front + depth, 1e-9)
    x, y = robot.x + from_x + share * dx, robot.y + from_y + share * dy
    t = ((x - wall.x1) * wall.ex + (y - wall.y1) * wall.ey) * wall.share
    return u, v, (depth if 0.0 <= t <= 1.0 else -1.0), side * nx, side * ny


def in_barrier(u: float, v: float, jaw: float) -> bool:
    """Whether a food disc at (u, v) in the robot's frame cuts the optical barrier between the fingers."""
    lateral = max(abs(v) - half_gap(jaw), 0.0)
    ahead = u - BARRIER
    return ahead * ahead + lateral * lateral < FOOD_RADIUS * FOOD_RADIUS


def room_below(robots: Any, i: int, foods: Any) -> bool:
    """Whether the arm can be lowered: no food below the fingers, and nothing below held food."""
    robot = robots[i]
    if robot.held >= 0 and not _floor_free(robots, i, foods):
        return False
    finger, near = half_gap(robot.jaw) + _THIN, (FOOD_RADIUS - _TOUCH) ** 2
    for k in range(len(foods)):
        if k == robot.held:
            continue
        u, v = seen_from(robot, foods[k].x, foods[k].y)
        ahead = max(JAW_ROOT - u, u - tip_of(robot), 0.0)
        aside = max(abs(abs(v) - finger) - _THIN, 0.0)
        behind = max(abs(v) - finger, 0.0)
        palm = u - JAW_ROOT + _THIN
        if ahead * ahead + aside * aside < near or palm * palm + behind * behind < near:
            return False
    return True


def _floor_free(robots: Any, i: int, foods: Any) -> bool:
    """Whether held food could be set down without touching other food or a robot."""
    robot = robots[i]
    for k in range(len(foods)):
        u, v = seen_from(robot, foods[k].x, foods[k].y)
        du, dv = u - robot.grip_x, v - robot.grip_y
        if k != robot.held and du * du + dv * dv < 4 * FOOD_RADIUS * FOOD_RADIUS:
            return False
    for j in range(len(robots)):
        u, v = seen_from(robot, robots[j].x, robots[j].y)
        du, dv = u - robot.grip_x, v - robot.grip_y
        if j != i and du * du + dv * dv < (FOOD_RADIUS + RADIUS) ** 2:
            return False
    return True


def moves_jaw(robot: Any) -> bool:
    """Whether the jaw is on its way: one that holds food closes no further."""
    return bool(robot.jaw_target > robot.jaw or (robot.jaw_target < robot.jaw and robot.held < 0))


def move_jaw(robots: Any, i: int, foods: Any, walls: Any, step: float) -> None:
    """Move the jaw of one robot: closing on food grips it, opening releases it.

    Args:
        robots: All robots of the world.
        i: Number of the robot.
        foods: The food objects.
        walls: The walls near the robot; a finger does not open into one.
        step: The largest change of the jaw's position.
    """
    robot = robots[i]
    jaw, target, held = robot.jaw, robot.jaw_target, robot.held
    if not moves_jaw(robot):
        return
    new = min(target, jaw + step) if target > jaw else max(target, jaw - step)
    if new > jaw and _opens_into_wall(robot, new, walls):
        return
    low = robot.arm >= ARM_ON_FLOOR
    if held >= 0:
        if not low and not _floor_free(robots, i, foods):
            return
        foods[held].x, foods[held].y = grip_place(robot)
        robot.held = -1
    elif new < jaw and low:
        k = _between(robot, foods, new)
        if k >= 0:
            new = JAW_ON_FOOD
            u, v = seen_from(robot, foods[k].x, foods[k].y)
            if abs(v) < _CENTRED:
                robot.held, robot.grip_x, robot.grip_y = k, u, v
    robot.jaw = new


def _between(robot: Any, foods: Any, jaw: float) -> int:
    """Number of the food object that the fingers hold when the jaw closes to this position; -1 without."""
    if half_gap(jaw) <= FOOD_RADIUS:
        for k in range(len(foods)):
            u, v = seen_from(robot, foods[k].x, foods[k].y)
            if JAW_ROOT < u < tip_of(robot) and abs(v) < half_gap(robot.jaw):
                return k
    return -1


def _opens_into_wall(robot: Any, jaw: float, walls: Any) -> bool:
    """Whether a finger at this position of the jaw would overlap a wall."""
    aside = half_gap(jaw) + FINGER_THICKNESS
    for k in range(len(walls)):
        for corner in range(4):
            if behind_wall(robot, corner, aside, walls[k])[2] > _TOUCH:
                return True
    return False
