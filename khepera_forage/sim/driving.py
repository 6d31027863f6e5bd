"""How robots drive where nothing resists, and what their grippers touch and hold.

The arm moves, the wheels slip, and the robot goes to the end of its round: `glide` moves a robot that touches nothing
on its way. The others are moved by a backend: by `sim.pymunk.world`, or by `sim.compiled.world`. Plain functions, also
compiled.

Arguments that functions have in common: all `robots` of an arena, the number `i` of the one in question, the `foods`,
the `walls` (`Wall` records in mm), the `corners` that point into the floor, and `Constants`.
"""

import math
from typing import Any

from khepera_forage.counter_rng import DRAW_BIAS, DRAW_WHEELS, draw, normal
from khepera_forage.geometry.plane import cosine_sine, is_near
from khepera_forage.robots.khepera import (
    ARM_DOWN,
    ARM_ON_FLOOR,
    ARM_RAISED,
    BARRIER,
    FINGER_THICKNESS,
    FINGER_TIP,
    FOOD_RADIUS,
    JAW_ON_FOOD,
    JAW_OPEN,
    JAW_ROOT,
    PULSE,
    RADIUS,
    SPEED_UNIT,
    Motors,
    half_gap,
)

SUBSTEPS = 5
"""Steps of a round in which something is pushed; with pymunk more, if they would be longer than 20 ms."""
_THIN = FINGER_THICKNESS / 2
_TOUCH = 0.5
"""mm of play within which the fingers count as touching food, and by which one may overlap a wall."""
_CENTRED = 1.0
"""mm from the middle within which food counts as between both fingers."""
_PALM, _PALM_HALF = JAW_ROOT - _THIN, half_gap(JAW_OPEN) + _THIN
"""Middle and half length of the palm, mm."""
_PALM_END = half_gap(JAW_OPEN) + FINGER_THICKNESS
"""From the middle to the outside of the palm, mm."""
_EXTENT = 94.0
"""mm from a robot's centre to the furthest point of the robot and the food in its gripper."""
_FAR = 30.0
"""mm a round from which a finger could pass through food unnoticed: the robot then counts as touching it."""


def put_down(robot: Any, constants: Any) -> None:
    """Put a robot down at its pose for an episode: at rest, its gripper raised and open, and not seen yet."""
    bits = draw(robot, DRAW_BIAS)  # these smooth both numbers; in `begin_round` the last of three does
    bias = constants.noise.wheel_bias
    robot.bias_left = robot.left_wheel_error + bias * normal(draw(robot, DRAW_BIAS + 2), bits)
    robot.bias_right = bias * normal(draw(robot, DRAW_BIAS + 1), bits >> 32)
    robot.cos, robot.sin = cosine_sine(robot.heading)
    robot.arm = robot.arm_target = float(ARM_RAISED)
    robot.jaw = robot.jaw_target = float(JAW_OPEN)
    robot.held = -1
    robot.has_gripper, robot.wheel_base, robot.max_speed = (
        constants.has_gripper,
        constants.wheel_base,
        constants.max_speed,
    )
    robot.left = robot.right = robot.forward = robot.turn = 0.0
    robot.left_pulses = robot.right_pulses = 0.0
    robot.senses.object_presence = 0
    robot.marker_x = robot.marker_y = robot.marker_heading = 0.0
    robot.marker_found = robot.marker_lost = False
    robot.first_frame = True
    robot.next_label = 0


def set_motors(robot: Any, motors: Motors) -> Motors:
    """Give a robot a command that `applicable` has made; returns it as the robot executes it."""
    top = robot.max_speed
    left, right = min(top, max(-top, motors.left)), min(top, max(-top, motors.right))
    robot.left, robot.right = left, right
    if not robot.has_gripper:
        return Motors(left, right, ARM_DOWN, JAW_OPEN)
    robot.arm_target, robot.jaw_target = motors.arm, motors.jaw
    return Motors(left, right, motors.arm, motors.jaw)


def begin_round(robots: Any, i: int, foods: Any, constants: Any) -> None:
    """Move the arm of a robot, and fix how fast its wheels turn in this round."""
    robot, duration = robots[i], constants.timing.round_duration
    robot.round += 1
    arm = _towards(robot.arm_target, robot.arm, constants.timing.arm_speed * duration)
    # It does not come down on food or robots.
    if arm >= ARM_ON_FLOOR and robot.arm < ARM_ON_FLOOR and not _room_below(robots, i, foods):
        arm = ARM_ON_FLOOR - 1.0
    robot.arm = arm
    bits, slip = draw(robot, DRAW_WHEELS + 2), constants.noise.wheel_slip
    left_share = 1.0 + robot.bias_left + slip * normal(draw(robot, DRAW_WHEELS), bits)
    right_share = 1.0 + robot.bias_right + slip * normal(draw(robot, DRAW_WHEELS + 1), bits >> 32)
    left, right = robot.left * SPEED_UNIT * left_share, robot.right * SPEED_UNIT * right_share
    robot.forward, robot.turn = (left + right) / 2, (right - left) / robot.wheel_base
    pulses = SPEED_UNIT * duration / PULSE
    robot.left_pulses += robot.left * pulses
    robot.right_pulses += robot.right * pulses


def glide(robots: Any, i: int, foods: Any, walls: Any, corners: Any, constants: Any) -> bool:
    """Move a robot for one round if it touches nothing on its way; returns whether it has moved."""
    robot, duration = robots[i], constants.timing.round_duration
    travel = travel_of(robot, duration)
    jaw = robot.jaw
    if robot.held < 0:
        jaw = _towards(robot.jaw_target, jaw, constants.timing.jaw_speed * duration)
    elif robot.jaw_target > jaw:
        return False  # A jaw that opens and releases food moves step by step; one that holds food closes no further.
    if travel == 0.0 and jaw == robot.jaw:
        return True
    driven, turned = robot.forward * duration, robot.turn * duration
    # The chord of an arc has the direction of the arc's middle.
    cos, sin = cosine_sine(robot.heading + turned / 2)
    x, y = robot.x + driven * cos, robot.y + driven * sin
    heading = robot.heading + turned
    cos, sin = cosine_sine(heading)
    if (
        _touches_wall(robot, walls, x, y, cos, sin, jaw, abs(driven))
        or _touches_corner(robot, corners, x, y, cos, sin, jaw, travel)
        or _touches_food(robot, foods, x, y, cos, sin, jaw, travel)
        or _touches_robot(robots, i, x, y, cos, sin, jaw, travel)
    ):
        return False
    robot.x, robot.y, robot.heading, robot.cos, robot.sin, robot.jaw = x, y, heading, cos, sin, jaw
    return True


def _towards(target: float, value: float, step: float) -> float:
    """A value moved by at most `step` towards a target."""
    return min(target, value + step) if target > value else max(target, value - step)


def _touches_wall(
    robot: Any, walls: Any, x: float, y: float, cos: float, sin: float, jaw: float, driven: float
) -> bool:
    """Whether the robot would touch a wall at the free end of the round: that pose, and the jaw's position.

    A robot that has driven further than its radius could be behind the wall then.
    """
    tip, wide = tip_of(robot), half_gap(jaw) + FINGER_THICKNESS
    for k in range(len(walls)):
        wall = walls[k]
        nx, ny = wall.normal_x, wall.normal_y
        # The side of the wall on which the robot is now.
        side = math.copysign(1.0, nx * robot.x + ny * robot.y - wall.offset)
        off = side * (nx * x + ny * y - wall.offset)
        if off > _EXTENT:
            continue
        if is_near(x, y, wall, RADIUS) or (off < 0.0 and is_near(robot.x, robot.y, wall, driven)):
            return True
        if not robot.has_gripper:
            continue
        # Beyond its ends a wall touches nothing.
        squared = wall.ex * wall.ex + wall.ey * wall.ey
        along, reach = (x - wall.x1) * wall.ex + (y - wall.y1) * wall.ey, _EXTENT * math.sqrt(squared)
        if along <= -reach or along >= squared + reach:
            continue
        # The parts of the robot's forward and left directions that lead away from the wall.
        ahead, aside = side * (nx * cos + ny * sin), abs(nx * -sin + ny * cos)
        if off + tip * ahead - wide * aside < 0.0 or off + JAW_ROOT * ahead - _PALM_END * aside < 0.0:
            return True
        if robot.held >= 0 and off + robot.grip_x * ahead - aside * abs(robot.grip_y) < FOOD_RADIUS:
            return True
    return False


def _touches_corner(
    robot: Any, corners: Any, x: float, y: float, cos: float, sin: float, jaw: float, travel: float
) -> bool:
    """Whether the gripper would touch a corner; within a round a finger can pass one, so all of its way counts."""
    tip, reach = tip_of(robot), _EXTENT + travel
    for k in range(len(corners) if robot.has_gripper else 0):
        dx, dy = corners[k].x - x, corners[k].y - y
        if dx * dx + dy * dy < reach * reach:
            u, v = dx * cos + dy * sin, dy * cos - dx * sin
            if finger_overlap(u, v, tip, jaw, travel) > 0.0 or palm_overlap(u, v, travel) > 0.0:
                return True
    return False


def _touches_food(
    robot: Any, foods: Any, x: float, y: float, cos: float, sin: float, jaw: float, travel: float
) -> bool:
    """Whether the robot would touch food, other than held food, at the free end of the round."""
    low, tip = robot.arm >= ARM_ON_FLOOR, tip_of(robot)
    for k in range(len(foods)):
        dx, dy = foods[k].x - x, foods[k].y - y
        squared = dx * dx + dy * dy
        if k == robot.held or squared > (FINGER_TIP + 4 * FOOD_RADIUS) ** 2:
            continue
        u, v = dx * cos + dy * sin, dy * cos - dx * sin
        if squared < (RADIUS + FOOD_RADIUS) ** 2:
            return True
        if not low:
            continue
        if finger_overlap(u, v, tip, jaw, FOOD_RADIUS) > 0.0 or palm_overlap(u, v, FOOD_RADIUS) > 0.0:
            return True
        gx, gy = u - robot.grip_x, v - robot.grip_y
        if robot.held >= 0 and gx * gx + gy * gy < 4 * FOOD_RADIUS * FOOD_RADIUS:
            return True
        if travel > _FAR and squared < (FINGER_TIP + 2 * FOOD_RADIUS) ** 2:
            return True
    return False


def _touches_robot(robots: Any, i: int, x: float, y: float, cos: float, sin: float, jaw: float, travel: float) -> bool:
    """Whether the robot, or food in its gripper, could touch another robot on its way."""
    robot = robots[i]
    tip, near = tip_of(robot), RADIUS + travel
    for j in range(len(robots)):
        if j == i:
            continue
        dx, dy = robots[j].x - x, robots[j].y - y
        u, v = dx * cos + dy * sin, dy * cos - dx * sin
        if u * u + v * v < (RADIUS + near) ** 2:
            return True
        if not robot.has_gripper:
            continue
        if max(finger_overlap(u, v, tip, jaw, near), palm_overlap(u, v, near)) > 0.0:
            return True
        gx, gy = u - robot.grip_x, v - robot.grip_y
        if robot.held >= 0 and gx * gx + gy * gy < (FOOD_RADIUS + near) ** 2:
            return True
    return False


def travel_of(robot: Any, duration: float) -> float:
    """The furthest way of any point of a robot in this round, mm."""
    return float((abs(robot.forward) + abs(robot.turn) * FINGER_TIP) * duration)


def moves_jaw(robot: Any) -> bool:
    """Whether the jaw is on its way: one that holds food closes no further."""
    return bool(robot.jaw_target > robot.jaw or (robot.jaw_target < robot.jaw and robot.held < 0))


def move_jaw(robots: Any, i: int, foods: Any, walls: Any, step: float) -> None:
    """Move the jaw of one robot by at most `step`: closing on food grips it, opening releases it.

    A finger does not open into a wall.
    """
    robot = robots[i]
    jaw, target, held = robot.jaw, robot.jaw_target, robot.held
    if not moves_jaw(robot):
        return
    new = _towards(target, jaw, step)
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
        for corner in range(4 if is_near(robot.x, robot.y, walls[k], _EXTENT) else 0):
            if behind_wall(robot, corner, aside, walls[k])[2] > _TOUCH:
                return True
    return False


def _room_below(robots: Any, i: int, foods: Any) -> bool:
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


def in_barrier(u: float, v: float, jaw: float) -> bool:
    """Whether a food disc at (u, v) in the robot's frame cuts the optical barrier between the fingers."""
    lateral = max(abs(v) - half_gap(jaw), 0.0)
    ahead = u - BARRIER
    return ahead * ahead + lateral * lateral < FOOD_RADIUS * FOOD_RADIUS


def tip_of(robot: Any) -> float:
    """Mm from a robot's centre forward to the tips of its fingers."""
    return float(FINGER_TIP - robot.finger_shortage)


def seen_from(robot: Any, x: float, y: float) -> tuple[float, float]:
    """A place in the robot's frame, mm forward and left."""
    dx, dy = x - robot.x, y - robot.y
    return dx * robot.cos + dy * robot.sin, dy * robot.cos - dx * robot.sin


def is_lifted(robots: Any, k: int) -> bool:
    """Whether a raised gripper holds food object `k`, so that nothing on the floor touches or sees it."""
    for j in range(len(robots)):  # noqa: SIM110 (numba compiles no generator expressions)
        if robots[j].held == k and robots[j].arm < ARM_ON_FLOOR:
            return True
    return False


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
    """Overlap in mm of a disc with the gripper, and the way out as a unit vector in the robot's frame.

    The overlap is negative when clear, and -1 out of reach.
    """
    if not (u + radius > JAW_ROOT - FINGER_THICKNESS and u - radius < tip and abs(v) < _PALM_END + radius):
        return -1.0, 1.0, 0.0
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
