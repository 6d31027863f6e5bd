"""The ten hand-coded behaviours (table 4.1): raw data to motors, one step at a time, with no memory.

What each commands. Speeds and readings are fields of `Decisions`:

| behaviour | wheels | arm | jaw |
|---|---|---|---|
| SEARCH FOR FOOD | `search_speed` to the food, round the home; `search_without_food` if none is seen | 215 | open |
| MOVE SLOWLY | `slow_speed` towards the food, round the home | 215 | open |
| ORIENT WITH FOOD | turn, `orient_speed` on; back to lower the arm or to retry | 255 if aimed | open; shut to retry |
| EXPLORE FOOD | 0 | 255 | open |
| PICK UP FOOD | 0 (2 while nothing is between the fingers) | 255, then 215 | closes, then the arm rises |
| PUSH FOOD | 0 until the jaw has closed, then `push_speed` home | 255 | closed |
| AVOID FOOD | `slow_speed` backwards | 255 | open |
| GO HOME | `home_speed` home | 215 once the jaw is shut | closed |
| AVOID HOME | out by its open side: `retreat_speed` back when facing it, otherwise `slow_speed` | 215 | open |
| RELEASE FOOD | `slow_speed` into the home, turning while the arm comes down; back | 255 | opens once it is down |
| WAIT | 0 | as it is | as it is |

"Back" is at `retreat_speed`, and at `lowering_speed` to lower the arm. SEARCH and MOVE SLOWLY also back off food that
is too near, and MOVE SLOWLY while the arm is still down (`beside_food`, `back_off_distance`, `arm_after_orienting`).
A raised arm leaves the infra-reds free to keep the robot off obstacles; a lowered one hides them, and the camera
keeps it off the walls (3.4).

A robot without a gripper only pushes food. Its arm counts as lowered and its jaw as open, and its infra-reds are never
hidden. A decision, because the thesis has no such robot:

| behaviour | wheels |
|---|---|
| SEARCH, MOVE SLOWLY, ORIENT | around the food until it lies between robot and home; then to it |
| EXPLORE FOOD | 0, which identifies the food |
| PUSH FOOD, GO HOME | home at `push_speed`; the infra-reds show where food touches. Back if it is far aside |
| RELEASE FOOD | turn on the spot, until the food is no longer before the robot |
| AVOID FOOD | `slow_speed` backwards |
| AVOID HOME | turn, then drive out |
| PICK UP FOOD | does not occur: 0 |
"""

import math

from khepera_forage.geometry.plane import arcsine, bearing_of, cosine_sine, turn_to
from khepera_forage.robots.khepera import (
    ARM_DOWN,
    ARM_ON_FLOOR,
    ARM_RAISED,
    FINGER_TIP,
    FOOD_RADIUS,
    JAW_CLOSED,
    JAW_ON_FOOD,
    JAW_OPEN,
    MAX_SPEED,
    RADIUS,
    Motors,
    applicable,
)
from khepera_forage.task.arena_map import EVERY_SIDE, ArenaMap, path_home
from khepera_forage.task.decisions import AS_IT_IS, BACK_OFF, DRIVE_ON, LOWERED_OVER_FOOD, WANDER, DecisionValues
from khepera_forage.task.food_tracking import KnownFood
from khepera_forage.task.perception import RawData, paths_home_can_bend, perceives_paths
from khepera_forage.task.states import Behaviour
from khepera_forage.vision.scene import MM_PER_PIXEL

_CLEAR = (FINGER_TIP + FOOD_RADIUS + 1.0) / MM_PER_PIXEL
"""Pixels from which the fingers can come down, and swing, without touching the food."""
_IN_RANGE = (RADIUS + 32.0 + FOOD_RADIUS) / MM_PER_PIXEL
"""Pixels from which the infra-reds turn a robot away from food."""
_BEHIND = 9.0
"""Pixels to a wall behind from which a robot does not back off further."""
_BESIDE = (RADIUS + FOOD_RADIUS + 15.0) / MM_PER_PIXEL
"""Pixels from food on a way around it, for a robot without a gripper."""
_BEHIND_FOOD, _ASTRAY_BEHIND = 25.0, 55.0
"""Degrees off the line from the home through the food within which a robot drives to the food, and beyond which it does
not go on pushing."""
_PUSHING_ASIDE = 14.0
"""Largest bearing of pushed food in degrees; at 23 degrees it would no longer lie before the robot."""
_JAW_SHUT = JAW_ON_FOOD + 3.0
_ARM_SETTLED = ARM_DOWN - 3
_STALLED = ARM_ON_FLOOR - 1
"""Position of an arm that has come down on something and stopped just above the floor."""
_CAREFUL = 8.0
"""Speed units in front of an obstacle, and back from one."""
_ON_THE_SPOT = 35.0
"""Degrees off course beyond which a robot turns on the spot rather than in an arc."""
_SWING = (FINGER_TIP + FOOD_RADIUS + 5.0) / MM_PER_PIXEL
"""Pixels that a robot turning on the spot with its gripper and food needs to the walls."""
_AROUND_HOME = 6.0
"""Pixels by which a searching robot passes its home."""
_AT_RIM = 2.0
"""Pixels: a robot this near to its home is about to be in it, and a way this near leads through it."""
_SQUARE = 40.0
"""Degrees of detour from which the home counts as squarely in the way."""
_OBSTACLE = 150
"""Infra-red reading (about 32 mm) from which a robot turns aside."""
_BLOCKED = 600
"""Infra-red reading (about 14 mm) in front from which it backs off."""


# Numbers of the behaviours: looking up members of an enum would take a quarter of `command`.
(
    _SEARCH_FOR_FOOD,
    _MOVE_SLOWLY,
    _ORIENT_WITH_FOOD,
    _EXPLORE_FOOD,
    _PICK_UP_FOOD,
    _PUSH_FOOD,
    _AVOID_FOOD,
    _GO_HOME,
    _AVOID_HOME,
    _RELEASE_FOOD,
    _,
) = (behaviour.value for behaviour in Behaviour)


def command(behaviour: int, raw: RawData, decisions: DecisionValues) -> Motors:
    """Motors for one step of a behaviour.

    Args:
        behaviour: A `Behaviour`, 0..10.
        raw: What the robot perceives now.
        decisions: `DecisionValues`.
    """
    if not decisions.has_gripper:
        left, right = _wheels_without_gripper(behaviour, raw, decisions)
        return Motors(left, right, ARM_DOWN, JAW_OPEN)
    if behaviour == _SEARCH_FOR_FOOD:
        return _search(raw, decisions)
    if behaviour == _MOVE_SLOWLY:
        return _approach(raw, decisions.slow_speed, _is_left_down(raw, decisions), decisions)
    if behaviour == _ORIENT_WITH_FOOD:
        if decisions.orienting == LOWERED_OVER_FOOD:
            return _orient_over_food(raw, decisions)
        return _orient(raw, decisions)
    if behaviour == _EXPLORE_FOOD:
        return Motors(0.0, 0.0, ARM_DOWN, JAW_OPEN)
    if behaviour == _PICK_UP_FOOD:
        return _pick_up(raw)
    if behaviour == _PUSH_FOOD:
        return _push(raw, decisions)
    if behaviour == _AVOID_FOOD:
        return Motors(-decisions.slow_speed, -decisions.slow_speed, ARM_DOWN, JAW_OPEN)
    if behaviour == _GO_HOME:
        return _go_home(raw, decisions)
    if behaviour == _AVOID_HOME:
        return _avoid_home(raw, decisions)
    if behaviour == _RELEASE_FOOD:
        return _release(raw, decisions)
    return wait(raw)


def path_home_for(
    behaviour: int, raw: RawData, known: KnownFood, arena: ArenaMap, decisions: DecisionValues
) -> tuple[float, float]:
    """`home_bearing` and `home_path` of raw data, looked up by `path_home` if a behaviour uses them."""
    used = behaviour in (_PUSH_FOOD, _GO_HOME, _AVOID_HOME, _RELEASE_FOOD)
    if behaviour in (_SEARCH_FOR_FOOD, _MOVE_SLOWLY):
        used = is_home_across(raw)
    if not used or perceives_paths(decisions) or not paths_home_can_bend(known, arena):
        return raw.home_bearing, raw.home_path
    x, y, path = path_home(raw.x, raw.y, known, arena)
    bearing = turn_to(bearing_of(x - raw.x, y - raw.y), raw.orientation)
    return bearing, path if path > raw.home_distance else raw.home_distance


def wait(raw: RawData) -> Motors:
    """Stand still and keep arm and jaw as they are."""
    return Motors(0.0, 0.0, raw.arm, JAW_CLOSED if raw.jaw <= _JAW_SHUT else JAW_OPEN)


def _search(raw: RawData, decisions: DecisionValues) -> Motors:
    if not raw.food_seen and raw.arm < ARM_ON_FLOOR:
        left, right = _look_around(raw, decisions)
        return Motors(left, right, ARM_RAISED, JAW_OPEN)
    return _approach(raw, decisions.search_speed, False, decisions)


def _look_around(raw: RawData, decisions: DecisionValues) -> tuple[float, float]:
    """Wheels while no food is seen."""
    if decisions.search_without_food == WANDER:
        return wander(raw, decisions.search_speed, decisions)
    # Turning uncovers what the robot's own marker hides; that it is a small circle takes two robots of which one
    # is just at home out of there (on the spot they would turn for ever).
    return decisions.circle_speed - decisions.turn_speed, decisions.circle_speed + decisions.turn_speed


def _is_left_down(raw: RawData, decisions: DecisionValues) -> bool:
    """Whether MOVE SLOWLY leaves the arm down."""
    return bool(decisions.arm_after_orienting == AS_IT_IS) and raw.arm >= ARM_ON_FLOOR


def _approach(raw: RawData, speed: float, arm_down: bool, decisions: DecisionValues) -> Motors:
    """Drive towards the food, past the home, with the arm up unless it is to stay down."""
    near = raw.food_seen and raw.food_distance < decisions.back_off_distance
    if (near and decisions.beside_food == BACK_OFF) or (raw.arm >= ARM_ON_FLOOR and not arm_down):
        # First clear of what may lie between the fingers, such as poison.
        return Motors(-decisions.retreat_speed, -decisions.retreat_speed, ARM_RAISED, JAW_OPEN)
    # Otherwise the infra-reds, which show food like any obstacle, would turn the robot away from it.
    shove = raw.food_seen and raw.food_distance < _IN_RANGE and decisions.beside_food == DRIVE_ON
    left, right = steer(raw, raw.food_bearing + detour(raw), speed, decisions, not shove)
    return Motors(left, right, ARM_DOWN if arm_down else ARM_RAISED, JAW_OPEN)


def _orient(raw: RawData, decisions: DecisionValues) -> Motors:
    if raw.object_presence:
        return Motors(0.0, 0.0, ARM_DOWN, JAW_OPEN)
    if not raw.food_seen:
        return Motors(-decisions.orient_speed, decisions.orient_speed, ARM_DOWN, JAW_OPEN)
    distance = raw.food_distance
    error = raw.food_bearing
    if abs(error) > decisions.astray:
        # Far off course: turn with the arm up, so that the fingers do not sweep the food away.
        turn = math.copysign(decisions.turn_speed, error) if raw.arm < ARM_ON_FLOOR or distance >= _CLEAR else 0.0
        return Motors(-turn, turn, ARM_RAISED, JAW_OPEN)
    # The jaw is the memory of a missed try: closed, it means backing off until there is room for another. A robot that
    # is about to drive into its home backs off as well: in there, it would only AVOID HOME, and come back.
    near_home = raw.home_distance < raw.home_radius + _AT_RIM
    into_home = near_home and abs(raw.home_bearing) < _half_width_of_home(raw, 0.0)
    missed = raw.jaw < JAW_OPEN - 5 or distance < decisions.missed_distance
    if distance < _CLEAR and (missed or into_home):
        return Motors(-decisions.retreat_speed, -decisions.retreat_speed, ARM_DOWN, JAW_CLOSED)
    if raw.arm < _ARM_SETTLED:
        # What the arm has come down on: back off that too.
        back = -decisions.lowering_speed if distance < _CLEAR or raw.arm == _STALLED else 0.0
        turn = clip(error / 8.0, 2.0)
        return Motors(back - turn, back + turn, ARM_DOWN, JAW_OPEN)
    if abs(error) > decisions.aimed:
        turn = math.copysign(1.0, error)
        return Motors(-turn, turn, ARM_DOWN, JAW_OPEN)
    turn = clip(error / 5.0, 1.0)
    return Motors(decisions.orient_speed - turn, decisions.orient_speed + turn, ARM_DOWN, JAW_OPEN)


def _orient_over_food(raw: RawData, decisions: DecisionValues) -> Motors:
    """ORIENT that turns to the food, lowers the open fingers around it, and drives on until it is in the barrier."""
    if raw.object_presence:
        return Motors(0.0, 0.0, ARM_DOWN, JAW_OPEN)
    if not raw.food_seen:
        return Motors(-decisions.orient_speed, decisions.orient_speed, ARM_DOWN, JAW_OPEN)
    error = raw.food_bearing
    if raw.food_distance < decisions.missed_distance:
        return Motors(-decisions.retreat_speed, -decisions.retreat_speed, ARM_RAISED, JAW_OPEN)
    if abs(error) > (decisions.aimed if raw.arm < ARM_ON_FLOOR else decisions.astray):
        size = decisions.turn_speed if abs(error) > decisions.astray else 1.0
        turn = math.copysign(size, error) if raw.arm < ARM_ON_FLOOR else 0.0
        return Motors(-turn, turn, ARM_RAISED, JAW_OPEN)
    if raw.arm < _ARM_SETTLED:
        return Motors(0.0, 0.0, ARM_DOWN, JAW_OPEN)
    forward = decisions.orient_speed if abs(error) <= decisions.aimed else 0.0
    turn = clip(error / 5.0, 1.0)
    return Motors(forward - turn, forward + turn, ARM_DOWN, JAW_OPEN)


def _pick_up(raw: RawData) -> Motors:
    if raw.jaw > _JAW_SHUT or raw.object_presence:
        reach = 0.0 if raw.object_presence else 2.0
        return Motors(reach, reach, _arm_after_jaw(raw), JAW_CLOSED if raw.object_presence else JAW_OPEN)
    return Motors(0.0, 0.0, ARM_RAISED, JAW_CLOSED)


def _push(raw: RawData, decisions: DecisionValues) -> Motors:
    if raw.jaw > _JAW_SHUT:
        return Motors(0.0, 0.0, ARM_DOWN, JAW_CLOSED)
    left, right = steer(raw, raw.home_bearing, decisions.push_speed, decisions)
    return Motors(left, right, ARM_DOWN, JAW_CLOSED)


def _go_home(raw: RawData, decisions: DecisionValues) -> Motors:
    left, right = steer(raw, raw.home_bearing, decisions.home_speed, decisions)
    return Motors(left, right, _arm_after_jaw(raw), JAW_CLOSED)


def _avoid_home(raw: RawData, decisions: DecisionValues) -> Motors:
    error = _error_to_leave_home(raw)
    blocked = raw.wall_distance < _BEHIND and abs(raw.wall_bearing) > 90.0
    if not blocked and (abs(error) > 90.0 or raw.arm >= ARM_ON_FLOOR):
        # Facing the home, with what was released in front of it, a robot leaves backwards.
        return Motors(-decisions.retreat_speed, -decisions.retreat_speed, ARM_RAISED, JAW_OPEN)
    left, right = steer(raw, error, decisions.slow_speed, decisions)
    return Motors(left, right, ARM_RAISED, JAW_OPEN)


def _error_to_leave_home(raw: RawData) -> float:
    """Degrees by which to turn to drive out of the home."""
    away = raw.orientation + raw.home_bearing + 180.0
    if raw.home_opening != EVERY_SIDE:
        # Behind the home there is no way out: out means its open side.
        away = raw.home_opening + clip(turn_to(away, raw.home_opening), 80.0)
    return turn_to(away, raw.orientation)


def _release(raw: RawData, decisions: DecisionValues) -> Motors:
    if raw.jaw > _JAW_SHUT:
        back = -decisions.retreat_speed if raw.jaw > JAW_OPEN - 20 else 0.0
        return Motors(back, back, ARM_DOWN, JAW_OPEN)
    if raw.home_distance > raw.home_radius - decisions.release_depth:
        left, right = steer(raw, raw.home_bearing, decisions.slow_speed, decisions)
        return Motors(left, right, ARM_DOWN, JAW_CLOSED)
    if raw.arm < _ARM_SETTLED:
        # Turning meanwhile finds a free place: an arm does not come down on other food. Once it has stopped on some,
        # the robot turns in a small circle, because there may be no free place around the present one.
        return Motors(-3.0 if raw.arm == _STALLED else -1.0, 1.0, ARM_DOWN, JAW_CLOSED)
    return Motors(0.0, 0.0, ARM_DOWN, JAW_OPEN)


def _arm_after_jaw(raw: RawData) -> int:
    return ARM_RAISED if raw.jaw <= _JAW_SHUT else ARM_DOWN


def _wheels_without_gripper(behaviour: int, raw: RawData, decisions: DecisionValues) -> tuple[float, float]:
    """Wheels of a robot that only pushes food."""
    if behaviour in (_SEARCH_FOR_FOOD, _MOVE_SLOWLY, _ORIENT_WITH_FOOD):
        if not raw.food_seen:
            return _look_around(raw, decisions)
        if behaviour == _ORIENT_WITH_FOOD:
            return _approach_from_behind(raw, decisions.orient_speed, decisions)
        speed = decisions.search_speed if behaviour == _SEARCH_FOR_FOOD else decisions.slow_speed
        return _approach_from_behind(raw, speed, decisions)
    if behaviour in (_PUSH_FOOD, _GO_HOME):
        return _push_ahead(raw, decisions.push_speed, decisions)
    if behaviour == _RELEASE_FOOD:
        # On the spot, so that it remains at home until the food no longer lies before it.
        turn = -math.copysign(decisions.turn_speed, _bearing_of_pushed(raw))
        return -turn, turn
    if behaviour == _AVOID_FOOD:
        return -decisions.slow_speed, -decisions.slow_speed
    if behaviour == _AVOID_HOME:
        return steer(raw, _error_to_leave_home(raw), decisions.slow_speed, decisions)
    return 0.0, 0.0


def _off_line(raw: RawData) -> float:
    """Degrees around the food from the side that faces away from the home to the robot, left positive."""
    away = bearing_of(raw.food_x - raw.home_x, raw.food_y - raw.home_y)
    return turn_to(bearing_of(raw.x - raw.food_x, raw.y - raw.food_y), away)


def _approach_from_behind(raw: RawData, speed: float, decisions: DecisionValues) -> tuple[float, float]:
    """Wheels to food that will be pushed: around it, until it lies between robot and home."""
    past_home = detour(raw)
    if past_home != 0.0:
        return steer(raw, raw.food_bearing + past_home, speed, decisions)
    off = _off_line(raw)
    if abs(off) <= _BEHIND_FOOD or raw.food_path > raw.food_distance:
        error = raw.food_bearing
        if raw.food_distance < _IN_RANGE and abs(error) > decisions.aimed:
            turn = math.copysign(decisions.turn_speed if abs(error) > decisions.astray else 1.0, error)
            return -turn, turn
        return steer(raw, error, speed, decisions, raw.food_distance >= _IN_RANGE)
    ahead = off - math.copysign(min(abs(off), 50.0), off)
    angle = math.radians(bearing_of(raw.food_x - raw.home_x, raw.food_y - raw.home_y) + ahead)
    cosine, sine = cosine_sine(angle)
    x, y = raw.food_x + _BESIDE * cosine - raw.x, raw.food_y + _BESIDE * sine - raw.y
    error = turn_to(bearing_of(x, y), raw.orientation)
    return steer(raw, error, speed, decisions, raw.food_distance >= _IN_RANGE)


def _push_ahead(raw: RawData, speed: float, decisions: DecisionValues) -> tuple[float, float]:
    """Wheels that push food home: the infra-reds show where it touches the robot.

    Food moves away from the robot's centre. Food that lies to the left of the heading slips further to the left, so
    that the robot comes to its right: this steers it.
    """
    food = _bearing_of_pushed(raw)
    off = raw.home_bearing - food
    if abs(off) > _ASTRAY_BEHIND:
        return -decisions.retreat_speed, -decisions.retreat_speed
    turn = clip(0.2 * (food - clip(0.5 * off, _PUSHING_ASIDE)), speed / 2)
    return speed - turn, speed + turn


def _bearing_of_pushed(raw: RawData) -> float:
    """Degrees to the left at which food touches a robot, as the four front infra-reds show."""
    near = raw.proximity
    sides = near[1] + near[2] + near[3] + near[4]
    return (45.0 * (near[1] - near[4]) + 10.0 * (near[2] - near[3])) / sides if sides > 0 else 0.0


def behaviour_of_motors(motors: Motors, state: int, correct: Motors, decisions: DecisionValues) -> int:
    """The behaviour that motors amount to: the teacher's if it commands the same in this state, and WAIT otherwise.

    States and behaviours correspond one to one (4.4.1). Of a robot without a gripper only wheels count.
    """
    a, b = applicable(motors), applicable(correct)
    same = a.left == b.left and a.right == b.right
    if decisions.has_gripper:
        same = same and a.arm == b.arm and a.jaw == b.jaw
    return int(state) if same else Behaviour.WAIT.value


def decode_motors(left: float, right: float, arm: float, jaw: float) -> Motors:
    """Motors that an action commands.

    Args:
        left: -1..1 is -20..20 speed units.
        right: -1..1 is -20..20 speed units.
        arm: -1 is 255, down; +1 is 215, raised.
        jaw: Above 0 closes.
    """
    position = math.floor((ARM_DOWN + ARM_RAISED) / 2 - arm * (ARM_DOWN - ARM_RAISED) / 2 + 0.5)
    return Motors(left * MAX_SPEED, right * MAX_SPEED, position, JAW_CLOSED if jaw > 0 else JAW_OPEN)


def is_home_across(raw: RawData) -> bool:
    """Whether the home lies between a searching robot and where it drives for food, or beside that way."""
    if not raw.food_seen or raw.home_distance <= raw.home_radius:
        return False
    fx, fy = raw.food_waypoint_x - raw.x, raw.food_waypoint_y - raw.y
    along = (raw.home_x - raw.x) * fx + (raw.home_y - raw.y) * fy
    return 0.0 < along < fx * fx + fy * fy


def detour(raw: RawData) -> float:
    """Degrees by which a searching robot aims past its home when that lies across the way to the food."""
    home = raw.home_distance
    # A home behind walls, to which the way is longer than the distance, does not lie across any way.
    if not is_home_across(raw) or raw.home_path > home:
        return 0.0
    aside = turn_to(raw.food_bearing, raw.home_bearing)
    berth = _half_width_of_home(raw, _AROUND_HOME)
    if abs(aside) >= _half_width_of_home(raw, _AT_RIM):
        return 0.0
    side = math.copysign(1.0, aside)
    if raw.home_opening != EVERY_SIDE and berth - abs(aside) > _SQUARE:
        # Past the open side of the home, which may stand against a wall. Every robot on that way finds the same side.
        robot = turn_to(bearing_of(raw.x - raw.home_x, raw.y - raw.home_y), raw.home_opening)
        food = turn_to(bearing_of(raw.food_waypoint_x - raw.home_x, raw.food_waypoint_y - raw.home_y), raw.home_opening)
        side = math.copysign(1.0, robot - food)
    return math.copysign(berth, side) - aside


def _half_width_of_home(raw: RawData, margin: float) -> float:
    """Degrees off the home's centre within which a straight way leads through the home, or past it within `margin`."""
    return arcsine(min(1.0, (raw.home_radius + margin) / max(raw.home_distance, 1e-9)))


def steer(
    raw: RawData, error: float, speed: float, decisions: DecisionValues, by_infra_reds: bool = True
) -> tuple[float, float]:
    """Wheels that turn by `error` degrees, left positive, while driving at some speed units, off walls and obstacles.

    With `by_infra_reds` they turn away from what the infra-reds show; a lowered arm hides it.
    """
    if abs(error) > _ON_THE_SPOT:
        return _turn_on_the_spot(raw, error, decisions)
    turn = error * (0.3 if abs(error) > 10.0 else 0.2)
    is_up = raw.arm < ARM_ON_FLOOR or not decisions.has_gripper
    if by_infra_reds and is_up:
        near = raw.proximity
        if near[2] > _BLOCKED and near[3] > _BLOCKED:
            return -_CAREFUL, -_CAREFUL
        left, right = max(near[0] // 2, near[1], near[2]), max(near[5] // 2, near[4], near[3])
        if left > _OBSTACLE or right > _OBSTACLE:
            speed = min(speed, _CAREFUL)
            turn = math.copysign(speed, right - left)
    turn = clip(turn, min(speed, MAX_SPEED - speed) if is_up else speed / 2)
    return speed - turn, speed + turn


def _turn_on_the_spot(raw: RawData, error: float, decisions: DecisionValues) -> tuple[float, float]:
    """Wheels for a turn on the spot, the long way round if the gripper would sweep a wall on the short one."""
    turn = math.copysign(decisions.quick_turn_speed if abs(error) > 70.0 else decisions.turn_speed, error)
    wall = raw.wall_bearing
    if raw.wall_distance < _SWING and decisions.has_gripper:
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
