"""A round of the bodies: the arm moves, the wheels slip, and the robot goes where nothing resists, or step by step.

The free end of a round is where the robot gets if nothing resists. A robot that touches nothing goes there at once;
`contact` moves the others.
"""

import math
from typing import Any

from khepera_forage.compilation import rule
from khepera_forage.geometry.angles import cosine_sine
from khepera_forage.robots.khepera import (
    ARM_ON_FLOOR,
    ARM_RAISED,
    FINGER_THICKNESS,
    FINGER_TIP,
    FOOD_RADIUS,
    JAW_OPEN,
    JAW_ROOT,
    PULSE,
    RADIUS,
    SPEED_UNIT,
    WHEEL_BASE,
    half_gap,
)
from khepera_forage.sim.broad_phase import GRIPPER_AHEAD, GRIPPER_RADIUS, PUSHED, SHOVED
from khepera_forage.sim.compiled.contact import move_in_contact, squared_from_wall
from khepera_forage.sim.compiled.gripper import finger_overlap, palm_overlap, room_below
from khepera_forage.sim.compiled.random import DRAW_BIAS, DRAW_WHEELS, draw, halves, normal
from khepera_forage.sim.world import FINE_TRAVEL, SUBSTEPS

_PALM = half_gap(JAW_OPEN) + FINGER_THICKNESS
_EXTENT = 94.0
"""mm from a robot's centre to the furthest point of the robot and the food in its gripper."""
_FAR = 30.0
"""mm a round from which a finger could pass through food unnoticed: the round is then calculated step by step."""


@rule
def put_down(robot: Any, x: float, y: float, heading: float, constants: Any) -> None:
    """Put a robot down at the start of an episode, at rest, with its gripper raised and open; it is not seen yet.

    Args:
        robot: The robot, with the key of its random numbers.
        x: Place in mm.
        y: Place in mm.
        heading: Radians.
        constants: `Constants`.
    """
    left, right = halves(draw(robot, DRAW_BIAS))
    mean, bias = constants.wheel_speed - 1.0, constants.wheel_bias
    robot.bias_left = mean + bias * normal(draw(robot, DRAW_BIAS + 2), left)
    robot.bias_right = mean + bias * normal(draw(robot, DRAW_BIAS + 1), right)
    robot.x, robot.y, robot.heading = x, y, heading
    robot.cos, robot.sin = cosine_sine(heading)
    robot.arm = robot.arm_target = ARM_RAISED
    robot.jaw = robot.jaw_target = JAW_OPEN
    robot.held = -1
    robot.left = robot.right = robot.last_forward = robot.last_turn = 0.0
    robot.left_pulses = robot.right_pulses = 0.0
    robot.object_presence = robot.arm_reading = robot.jaw_reading = 0
    robot.marker_x = robot.marker_y = robot.marker_heading = 0.0
    robot.marker_found = robot.marker_lost = False
    robot.first_frame = True
    robot.next_label = 0


@rule
def move(robots: Any, i: int, foods: Any, walls: Any, corners: Any, constants: Any) -> None:
    """Move one robot, and what it pushes, for one round.

    Args:
        robots: All robots of the world.
        i: Number of the robot.
        foods: The food objects.
        walls: The walls of its arena, `Wall` records in mm.
        corners: The corners that point into its floor.
        constants: `Constants`.
    """
    robot, duration = robots[i], constants.round_duration
    _move_arm(robots, i, foods, constants.arm_speed * duration)
    left, right = halves(draw(robot, DRAW_WHEELS + 2))
    slip = constants.wheel_slip
    left_share = 1.0 + robot.bias_left + slip * normal(draw(robot, DRAW_WHEELS), left)
    right_share = 1.0 + robot.bias_right + slip * normal(draw(robot, DRAW_WHEELS + 1), right)
    left_speed, right_speed = robot.left * SPEED_UNIT * left_share, robot.right * SPEED_UNIT * right_share
    forward, turn = (left_speed + right_speed) / 2, (right_speed - left_speed) / WHEEL_BASE
    travel = (abs(forward) + abs(turn) * FINGER_TIP) * duration
    pulses = SPEED_UNIT * duration / PULSE
    robot.left_pulses += robot.left * pulses
    robot.right_pulses += robot.right * pulses

    # A jaw that holds food closes no further. One that opens and releases food is moved step by step.
    opens = robot.held >= 0 and robot.jaw_target > robot.jaw
    jaw = (
        robot.jaw
        if robot.held >= 0
        else _towards(robot.jaw_target, robot.jaw, constants.jaw_speed * duration)
    )
    moves = travel != 0.0 or jaw != robot.jaw
    near_food = _is_near_food(robots, i, foods, travel)
    near_wall = _is_near_wall(robot, walls, travel, near_food)
    # Chipmunk moves bodies by the speed of the step before. So where `PymunkWorld` needs physics, near walls and
    # food, a robot changes its speed one physics step late: 20 ms, or less near a wall, where steps are finer.
    lag = 0.0
    if moves and (near_wall or near_food):
        lag = 1.0 / (max(float(SUBSTEPS), math.ceil(travel / FINE_TRAVEL)) if near_wall else float(SUBSTEPS))
    goes = forward + lag * (robot.last_forward - forward)
    turns = turn + lag * (robot.last_turn - turn)
    # The chord of an arc has the direction of the arc's middle.
    cos, sin = cosine_sine(robot.heading + turns * duration / 2)
    heading = robot.heading + turns * duration
    x, y = robot.x + goes * cos * duration, robot.y + goes * sin * duration
    cos, sin = cosine_sine(heading)

    moves = moves or robot.last_forward != 0.0 or robot.last_turn != 0.0
    touches = opens
    if moves and not touches and near_wall:
        touches = _touches_wall(robot, walls, x, y, cos, sin, jaw)
    if moves and not touches:
        touches = _touches_corner(corners, x, y, cos, sin, jaw, travel)
    if moves and not touches:
        touches = _touches_food(robot, foods, x, y, cos, sin, jaw, travel)
    if moves and not touches:
        touches = _touches_robot(robots, i, x, y, cos, sin, jaw, travel)
    if touches:
        some = walls[: len(walls) if near_wall else 0]
        move_in_contact(robots, i, foods, some, corners, constants, forward, turn, lag)
    else:
        robot.x, robot.y, robot.heading, robot.cos, robot.sin, robot.jaw = x, y, heading, cos, sin, jaw
        robot.last_forward, robot.last_turn = forward, turn


@rule
def _towards(target: float, value: float, step: float) -> float:
    """A value moved by at most `step` towards a target."""
    return min(target, value + step) if target > value else max(target, value - step)


@rule
def _move_arm(robots: Any, i: int, foods: Any, step: float) -> None:
    """Move the arm; it does not come down on food or robots."""
    robot = robots[i]
    arm = _towards(robot.arm_target, robot.arm, step)
    if arm >= ARM_ON_FLOOR and robot.arm < ARM_ON_FLOOR and not room_below(robots, i, foods):
        arm = ARM_ON_FLOOR - 1.0
    robot.arm = arm


@rule
def _is_near_food(robots: Any, i: int, foods: Any, travel: float) -> bool:
    """Whether the robot could push food that it does not hold, or another robot, in this round."""
    robot = robots[i]
    reach = (PUSHED if robot.arm >= ARM_ON_FLOOR else SHOVED) + travel
    for k in range(len(foods)):
        dx, dy = foods[k].x - robot.x, foods[k].y - robot.y
        if dx * dx + dy * dy < reach * reach and robot.held != k:
            return True
    for j in range(len(robots)):
        dx, dy = robots[j].x - robot.x, robots[j].y - robot.y
        if j != i and dx * dx + dy * dy < (PUSHED + RADIUS + travel) ** 2:
            return True
    return False


@rule
def _is_near_wall(robot: Any, walls: Any, travel: float, near_food: bool) -> bool:
    """Whether the robot, or food that it pushes, could touch a wall in this round."""
    body_reach = travel + (PUSHED if near_food else RADIUS)
    gripper_reach = travel + GRIPPER_RADIUS
    furthest = max(body_reach, gripper_reach + GRIPPER_AHEAD) + 1.0
    for k in range(len(walls)):
        wall = walls[k]
        # The distance from a wall's line is cheap, and mostly shows that the wall is out of reach.
        if abs(wall.normal_x * robot.x + wall.normal_y * robot.y - wall.offset) > furthest:
            continue
        if squared_from_wall(robot.x, robot.y, wall) < body_reach * body_reach:
            return True
        x, y = robot.x + GRIPPER_AHEAD * robot.cos, robot.y + GRIPPER_AHEAD * robot.sin
        if squared_from_wall(x, y, wall) < gripper_reach * gripper_reach:
            return True
    return False


@rule
def _touches_wall(robot: Any, walls: Any, x: float, y: float, cos: float, sin: float, jaw: float) -> bool:
    """Whether the robot would touch a wall at the free end of the round: that pose, and the jaw's position."""
    wide = half_gap(jaw) + FINGER_THICKNESS
    for k in range(len(walls)):
        wall = walls[k]
        nx, ny = wall.normal_x, wall.normal_y
        # The side of the wall on which the robot is now.
        side = math.copysign(1.0, nx * robot.x + ny * robot.y - wall.offset)
        off = side * (nx * x + ny * y - wall.offset)
        if squared_from_wall(x, y, wall) < RADIUS * RADIUS:
            return True
        # Beyond its ends a wall touches nothing.
        squared = wall.ex * wall.ex + wall.ey * wall.ey
        along, reach = (x - wall.x1) * wall.ex + (y - wall.y1) * wall.ey, _EXTENT * math.sqrt(squared)
        if along <= -reach or along >= squared + reach:
            continue
        # The parts of the robot's forward and left directions that lead away from the wall.
        ahead, aside = side * (nx * cos + ny * sin), abs(nx * -sin + ny * cos)
        if off + FINGER_TIP * ahead - wide * aside < 0.0 or off + JAW_ROOT * ahead - _PALM * aside < 0.0:
            return True
        if robot.held >= 0 and off + robot.grip_x * ahead - aside * abs(robot.grip_y) < FOOD_RADIUS:
            return True
    return False


@rule
def _touches_corner(
    corners: Any, x: float, y: float, cos: float, sin: float, jaw: float, travel: float
) -> bool:
    """Whether the gripper would touch a corner; within a round a finger can pass one, so all of its way counts."""
    reach = FINGER_TIP + JAW_OPEN / 2 + travel
    for k in range(len(corners)):
        dx, dy = corners[k].x - x, corners[k].y - y
        if dx * dx + dy * dy < reach * reach:
            u, v = dx * cos + dy * sin, dy * cos - dx * sin
            if finger_overlap(u, v, jaw, travel) > 0.0 or palm_overlap(u, v, travel) > 0.0:
                return True
    return False


@rule
def _touches_food(
    robot: Any, foods: Any, x: float, y: float, cos: float, sin: float, jaw: float, travel: float
) -> bool:
    """Whether the robot would touch food, other than held food, at the free end of the round."""
    low = robot.arm >= ARM_ON_FLOOR
    for k in range(len(foods)):
        dx, dy = foods[k].x - x, foods[k].y - y
        squared = dx * dx + dy * dy
        if k == robot.held or squared > (PUSHED + 2 * FOOD_RADIUS + travel) ** 2:
            continue
        u, v = dx * cos + dy * sin, dy * cos - dx * sin
        if u * u + v * v < (RADIUS + FOOD_RADIUS) ** 2:
            return True
        if not low:
            continue
        if finger_overlap(u, v, jaw, FOOD_RADIUS) > 0.0 or palm_overlap(u, v, FOOD_RADIUS) > 0.0:
            return True
        gx, gy = u - robot.grip_x, v - robot.grip_y
        if robot.held >= 0 and gx * gx + gy * gy < 4 * FOOD_RADIUS * FOOD_RADIUS:
            return True
        if travel > _FAR and u * u + v * v < (FINGER_TIP + 2 * FOOD_RADIUS) ** 2:
            return True
    return False


@rule
def _touches_robot(
    robots: Any, i: int, x: float, y: float, cos: float, sin: float, jaw: float, travel: float
) -> bool:
    """Whether the robot, or food in its gripper, could touch another robot on its way."""
    robot = robots[i]
    for j in range(len(robots)):
        if j == i:
            continue
        dx, dy = robots[j].x - x, robots[j].y - y
        u, v = dx * cos + dy * sin, dy * cos - dx * sin
        if u * u + v * v < (2 * RADIUS + travel) ** 2:
            return True
        if max(finger_overlap(u, v, jaw, RADIUS + travel), palm_overlap(u, v, RADIUS + travel)) > 0.0:
            return True
        gx, gy = u - robot.grip_x, v - robot.grip_y
        if robot.held >= 0 and gx * gx + gy * gy < (RADIUS + FOOD_RADIUS + travel) ** 2:
            return True
    return False
