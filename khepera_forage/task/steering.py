"""How a robot drives towards a place: arcs and turns on the spot, round its home, off walls and obstacles."""

import math

from khepera_forage.geometry.angles import arcsine, bearing_of, turn_to
from khepera_forage.robots.khepera import ARM_ON_FLOOR, FINGER_TIP, FOOD_RADIUS, MAX_SPEED
from khepera_forage.task.arena_map import EVERY_SIDE
from khepera_forage.task.decisions import DecisionValues
from khepera_forage.task.perception import RawData
from khepera_forage.vision.scene import MM_PER_PIXEL

_CAREFUL = 8.0
"""Speed units in front of an obstacle, and back from one."""
_ON_THE_SPOT = 35.0
"""Degrees off course beyond which a robot turns on the spot rather than in an arc."""
_SWING = (FINGER_TIP + FOOD_RADIUS + 5.0) / MM_PER_PIXEL
"""Pixels that a robot turning on the spot with its gripper and food needs to the walls."""
_AROUND_HOME = 6.0
"""Pixels by which a searching robot passes its home."""
_SQUARE = 40.0
"""Degrees of detour from which the home counts as squarely in the way."""
_OBSTACLE = 150
"""Infra-red reading (about 32 mm) from which a robot turns aside."""
_BLOCKED = 600
"""Infra-red reading (about 14 mm) in front from which it backs off."""


def is_home_across(raw: RawData) -> bool:
    """Whether the home lies between a searching robot and where it drives for food, or beside that way."""
    if not raw.food_seen or raw.home_distance <= raw.home_radius:
        return False
    fx, fy = raw.food_way_x - raw.x, raw.food_way_y - raw.y
    along = (raw.home_x - raw.x) * fx + (raw.home_y - raw.y) * fy
    return 0.0 < along < fx * fx + fy * fy


def detour(raw: RawData) -> float:
    """Degrees by which a searching robot aims past its home when that lies across the way to the food."""
    home = raw.home_distance
    # A home behind walls, to which the way is longer than the distance, does not lie across any way.
    if not is_home_across(raw) or raw.home_path > home:
        return 0.0
    aside = turn_to(raw.food_bearing, raw.home_bearing)
    berth = arcsine(min(1.0, (raw.home_radius + _AROUND_HOME) / home))
    if abs(aside) >= berth:
        return 0.0
    side = math.copysign(1.0, aside)
    if raw.home_opening != EVERY_SIDE and berth - abs(aside) > _SQUARE:
        # Past the open side of the home, which may stand against a wall. Every robot on that way finds the same side.
        robot = turn_to(bearing_of(raw.x - raw.home_x, raw.y - raw.home_y), raw.home_opening)
        food = turn_to(bearing_of(raw.food_way_x - raw.home_x, raw.food_way_y - raw.home_y), raw.home_opening)
        side = math.copysign(1.0, robot - food)
    return math.copysign(berth, side) - aside


def steer(
    raw: RawData, error: float, speed: float, decisions: DecisionValues, by_infra_reds: bool = True
) -> tuple[float, float]:
    """Wheels that turn by `error` degrees while driving, off walls and obstacles.

    Args:
        raw: What is perceived now.
        error: Degrees to turn by, left positive.
        speed: Speed units.
        decisions: `DecisionValues`.
        by_infra_reds: Whether to turn away from what the infra-reds show; a lowered arm hides it.
    """
    if abs(error) > _ON_THE_SPOT:
        return _turn_on_the_spot(raw, error, decisions)
    turn = error * (0.3 if abs(error) > 10.0 else 0.2)
    if by_infra_reds and raw.arm < ARM_ON_FLOOR:
        near = raw.proximity
        if near[2] > _BLOCKED and near[3] > _BLOCKED:
            return -_CAREFUL, -_CAREFUL
        left, right = max(near[0] // 2, near[1], near[2]), max(near[5] // 2, near[4], near[3])
        if left > _OBSTACLE or right > _OBSTACLE:
            speed = min(speed, _CAREFUL)
            turn = math.copysign(speed, right - left)
    turn = clip(turn, min(speed, MAX_SPEED - speed) if raw.arm < ARM_ON_FLOOR else speed / 2)
    return speed - turn, speed + turn


def _turn_on_the_spot(raw: RawData, error: float, decisions: DecisionValues) -> tuple[float, float]:
    """Wheels for a turn on the spot, the long way round if the gripper would sweep a wall on the short one."""
    turn = math.copysign(decisions.quick_turn_speed if abs(error) > 70.0 else decisions.turn_speed, error)
    wall = raw.wall_bearing
    if raw.wall_distance < _SWING:
        if abs(wall) < 30.0:
            return -_CAREFUL, -_CAREFUL
        if wall * error > 0.0 and abs(wall) < abs(error) + 30.0:
            turn = -turn
    return -turn, turn


def wander(raw: RawData, speed: float, decisions: DecisionValues) -> tuple[float, float]:
    """Wheels that drive straight on, and turn left wherever something is ahead: a corner then holds no robot."""
    bearing = abs(raw.wall_bearing)
    if raw.wall_distance < _SWING and bearing < 30.0:
        return -_CAREFUL, -_CAREFUL
    near = raw.proximity
    wall_ahead = raw.wall_distance < _SWING + 2.0 and bearing < 60.0
    if wall_ahead or max(near[1], near[2], near[3], near[4]) > _OBSTACLE:
        return -decisions.turn_speed, decisions.turn_speed
    return speed, speed


def clip(value: float, limit: float) -> float:
    """A value within -limit..limit."""
    return -limit if value < -limit else limit if value > limit else value
