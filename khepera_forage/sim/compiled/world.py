"""`CompiledWorld`: robots, food and a camera in compiled functions. Needs numba (extra `fast`).

What is its own are rounds in which a robot touches something, step by step (`move_in_contact`): walls turn it or hold
it back, and it pushes food.

Positions are corrected; no forces are integrated. Overlapping bodies are moved apart at once: food yields to robots,
and all yield to walls. The wheels resist a shift with 0.6 of the robot's weight, and a turn with the same force at
the wheels. So a wall that touches a point further than half a wheel base aside of the robot's middle turns the robot,
and a wall that touches a nearer point shifts it. Another robot is an obstacle like a wall. A robot stays where it is
if the food before it cannot move. A finger drags food along by friction, which keeps food before a closed jaw while
the robot turns a little. Pushed food stops with the robot: at friction 0.3 it would slide on by 1 mm from the fastest
push.

Arguments have the names and meanings of `sim.driving`.
"""

import math
from functools import cached_property
from typing import Any

import numpy as np

from khepera_forage import counter_rng
from khepera_forage.compilation import entry, overload, register, rule
from khepera_forage.geometry import plane
from khepera_forage.geometry.plane import Wall, cosine_sine, from_wall, is_near
from khepera_forage.records import array_of, dtype_of
from khepera_forage.robots import khepera
from khepera_forage.robots.khepera import ARM_ON_FLOOR, FINGER_THICKNESS, FINGER_TIP, FOOD_RADIUS, RADIUS, half_gap
from khepera_forage.sim import driving, sensing
from khepera_forage.sim.arena import Arena
from khepera_forage.sim.driving import (
    SUBSTEPS,
    begin_round,
    behind_wall,
    glide,
    grip_place,
    move_jaw,
    push_out,
    seen_from,
    tip_of,
)
from khepera_forage.sim.records import Constants, Enclosure, FoodDetection, FoodState, RobotState
from khepera_forage.sim.sensing import begin, look, sense_all
from khepera_forage.sim.simulation import Simulation
from khepera_forage.vision import association, shapes
from khepera_forage.vision.association import Track

# The rules that Python calls become known to numba, so that compiled worlds execute the same ones.
_1, _2, _4, _12, _27, _30, _31, _56 = map(np.uint64, (1, 2, 4, 12, 27, 30, 31, 56))
_GOLDEN = np.uint64(0x9E3779B97F4A7C15)
_FIRST, _SECOND = np.uint64(0xBF58476D1CE4E5B9), np.uint64(0x94D049BB133111EB)
_5S, _3S, _0F, _01 = map(np.uint64, (0x5555555555555555, 0x3333333333333333, 0x0F0F0F0F0F0F0F0F, 0x0101010101010101))


# Python's whole numbers have no size; these wrap around at 64 bits.
@overload(counter_rng.random_bits)
def _random_bits(key: Any, number: Any) -> Any:
    def bits(key: Any, number: Any) -> Any:
        z = key + np.uint64(number) * _GOLDEN
        z = (z ^ (z >> _30)) * _FIRST
        z = (z ^ (z >> _27)) * _SECOND
        return z ^ (z >> _31)

    return bits


@overload(counter_rng.unit)
def _unit(bits: Any) -> Any:
    def number(bits: Any) -> Any:
        return (np.float64(bits >> _12) + 0.5) * 2.0**-52

    return number


@overload(counter_rng.heads)
def _heads(bits: Any) -> Any:
    def count(bits: Any) -> Any:
        n = bits - ((bits >> _1) & _5S)
        n = (n & _3S) + ((n >> _2) & _3S)
        n = (n + (n >> _4)) & _0F
        return (n * _01) >> _56

    return count


for _function in (
    *(counter_rng.uniform, counter_rng.standard_normal, counter_rng.draw),
    *(counter_rng.upper, counter_rng.lower, counter_rng.normal),
):
    rule(_function)
register(plane, khepera, shapes, association, driving, sensing)

_REPEATS = 4
_REACH = FINGER_TIP + 2 * FOOD_RADIUS
"""mm from a robot's centre within which the robot, or food in its gripper, can touch a wall."""
_TOLERATED = 0.5
"""mm of overlap up to which a robot is not held back."""
_FINER = 8
"""Parts of a step in which a robot moves past a corner that it would leap over."""
_SETTLED = 1e-6
"""mm of movement below which everything is in its place."""
_FRICTION = 0.04
"""Friction of a finger along food: pymunk multiplies 0.2 of each."""


@rule
def move_in_contact(robots: Any, i: int, foods: Any, walls: Any, corners: Any, constants: Any) -> None:
    """Move a robot that touches something for one round."""
    robot = robots[i]
    duration = constants.timing.round_duration / SUBSTEPS
    jaw_step = constants.timing.jaw_speed * duration
    allowed = max(_TOLERATED, _overlap(robots, i, foods, walls, corners))
    driven, turned = robot.forward * duration, robot.turn * duration
    for _ in range(SUBSTEPS):
        move_jaw(robots, i, foods, walls, jaw_step)
        # A step that is longer than the radius could end behind a wall.
        parts, part = (_FINER if abs(driven) > RADIUS else 1), 0
        while part < parts:
            leapt = _move_on(robots, i, foods, walls, corners, driven / parts, turned / parts, allowed)
            part += 1
            if leapt and parts == 1:
                parts, part = _FINER, 0


@rule
def _move_on(
    robots: Any, i: int, foods: Any, walls: Any, corners: Any, driven: float, turned: float, allowed: float
) -> bool:
    """Drive some mm and turn by some radians, and give way to what is touched; or stay, if that cannot give way.

    Overlaps up to `allowed` mm hold nothing back.

    Returns:
        Whether the robot stays because it leapt: a finger that has swung across a corner would be pushed out on the
        wrong side of it.
    """
    robot = robots[i]
    x, y, heading = robot.x, robot.y, robot.heading
    furthest = 2.0 * (abs(driven) + abs(turned) * FINGER_TIP + allowed)
    cos, sin = robot.cos, robot.sin
    if turned != 0.0:
        cos, sin = cosine_sine(heading + turned / 2)
    put(robot, x + driven * cos, y + driven * sin, heading + turned)
    moved = 1.0
    for _ in range(_REPEATS):
        moved = _give_way(robots, i, walls, corners)
        moved += _push_food(robots, i, foods, walls, driven, turned)
        if moved < _SETTLED:
            break
        driven = turned = 0.0
    leapt = bool(abs(robot.x - x) + abs(robot.y - y) + abs(robot.heading - heading) * FINGER_TIP > furthest)
    if leapt or (moved >= _SETTLED and _overlap(robots, i, foods, walls, corners) > allowed):
        put(robot, x, y, heading)
    return leapt


@rule
def put(robot: Any, x: float, y: float, heading: float) -> None:
    """Set the pose of a robot."""
    robot.x, robot.y = x, y
    if heading != robot.heading:
        robot.heading = heading
        robot.cos, robot.sin = cosine_sine(heading)


@rule
def _yield_at(robot: Any, u: float, v: float, nx: float, ny: float, depth: float) -> None:
    """Give way to something that pushes at (u, v) of the robot's frame, by `depth` mm along (nx, ny)."""
    cos, sin = robot.cos, robot.sin
    lever = (u * cos - v * sin) * ny - (u * sin + v * cos) * nx
    if abs(lever) > robot.wheel_base / 2:
        put(robot, robot.x, robot.y, robot.heading + depth / lever)
    else:
        put(robot, robot.x + nx * depth, robot.y + ny * depth, robot.heading)


@rule
def _give_way(robots: Any, i: int, walls: Any, corners: Any) -> float:
    """Move the robot out of all walls and other robots; returns the sum of the overlaps, mm."""
    robot, moved = robots[i], 0.0
    wide = half_gap(robot.jaw) + FINGER_THICKNESS
    for k in range(len(walls)):
        wall = walls[k]
        if not is_near(robot.x, robot.y, wall, _REACH):
            continue
        far, nx, ny = from_wall(robot.x, robot.y, wall)
        if far < RADIUS:
            robot.x += nx * (RADIUS - far)
            robot.y += ny * (RADIUS - far)
            moved += RADIUS - far
        for corner in range(4 if robot.has_gripper else 0):
            u, v, depth, nx, ny = behind_wall(robot, corner, wide, wall)
            if depth > 0.0:
                _yield_at(robot, u, v, nx, ny, depth)
                moved += depth
        if robot.held >= 0:
            x, y = grip_place(robot)
            far, nx, ny = from_wall(x, y, wall)
            if far < FOOD_RADIUS:
                _yield_at(robot, robot.grip_x, robot.grip_y, nx, ny, FOOD_RADIUS - far)
                moved += FOOD_RADIUS - far
    for k in range(len(corners)):
        moved += _give_way_to_disc(robot, corners[k].x, corners[k].y, 0.0)
    for j in range(len(robots)):
        if j != i:
            moved += _give_way_to_robot(robot, robots[j])
    return moved


@rule
def _give_way_to_disc(robot: Any, x: float, y: float, radius: float) -> float:
    """Move the gripper out of a disc on the floor; returns the overlap, mm."""
    if not robot.has_gripper:
        return 0.0
    u, v = seen_from(robot, x, y)
    depth, along, aside = push_out(u, v, tip_of(robot), robot.jaw, radius)
    if depth <= 0.0:
        return 0.0
    cos, sin = robot.cos, robot.sin
    _yield_at(robot, u, v, -(along * cos - aside * sin), -(along * sin + aside * cos), depth)
    return depth


@rule
def _give_way_to_robot(robot: Any, other: Any) -> float:
    """Move a robot out of another one; returns the sum of the overlaps, mm."""
    dx, dy = robot.x - other.x, robot.y - other.y
    far = math.sqrt(dx * dx + dy * dy)
    if far > _REACH + RADIUS:
        return 0.0
    moved = 0.0
    if 1e-9 < far < 2 * RADIUS:
        moved = 2 * RADIUS - far
        robot.x, robot.y = robot.x + dx * moved / far, robot.y + dy * moved / far
    return moved + _give_way_to_disc(robot, other.x, other.y, RADIUS)


@rule
def _overlap(robots: Any, i: int, foods: Any, walls: Any, corners: Any) -> float:
    """The largest remaining overlap in mm: robot with walls, robots or food, food with walls or other food."""
    robot, worst = robots[i], 0.0
    low = robot.arm >= ARM_ON_FLOOR
    wide = half_gap(robot.jaw) + FINGER_THICKNESS
    for k in range(len(walls)):
        if not is_near(robot.x, robot.y, walls[k], _REACH):
            continue
        worst = max(worst, RADIUS - from_wall(robot.x, robot.y, walls[k])[0])
        for corner in range(4 if robot.has_gripper else 0):
            worst = max(worst, behind_wall(robot, corner, wide, walls[k])[2])
    for k in range(len(corners) if robot.has_gripper else 0):
        u, v = seen_from(robot, corners[k].x, corners[k].y)
        worst = max(worst, push_out(u, v, tip_of(robot), robot.jaw, 0.0)[0])
    for j in range(len(robots)):
        if j != i:
            u, v = seen_from(robot, robots[j].x, robots[j].y)
            worst = max(worst, 2 * RADIUS - math.sqrt(u * u + v * v))
            if robot.has_gripper:
                worst = max(worst, push_out(u, v, tip_of(robot), robot.jaw, RADIUS)[0])
    for k in range(len(foods)):
        x, y = foods[k].x, foods[k].y
        u, v = seen_from(robot, x, y)
        if u * u + v * v > (FINGER_TIP + 8 * FOOD_RADIUS) ** 2:
            continue
        if k == robot.held:
            x, y = grip_place(robot)
        for n in range(len(walls)):
            if is_near(x, y, walls[n], FOOD_RADIUS):
                worst = max(worst, FOOD_RADIUS - from_wall(x, y, walls[n])[0])
        if k == robot.held:
            continue
        worst = max(worst, RADIUS + FOOD_RADIUS - math.sqrt(u * u + v * v))
        if low:
            worst = max(worst, push_out(u, v, tip_of(robot), robot.jaw, FOOD_RADIUS)[0])
        for n in range(k):
            if n != robot.held:
                dx, dy = foods[n].x - x, foods[n].y - y
                worst = max(worst, 2 * FOOD_RADIUS - math.sqrt(dx * dx + dy * dy))
    return worst


@rule
def _push_food(robots: Any, i: int, foods: Any, walls: Any, forward: float, turn: float) -> float:
    """Move food out of the robot's way, out of walls and away from other food and robots; returns how many mm in all.

    The robot has just moved by `forward` mm and turned by `turn` radians: its fingers drag food that they touch.
    """
    robot, moved = robots[i], 0.0
    low = robot.arm >= ARM_ON_FLOOR
    for k in range(len(foods)):
        if _is_held(robots, k):
            continue
        from_x, from_y = foods[k].x, foods[k].y
        u, v = seen_from(robot, from_x, from_y)
        if u * u + v * v > (FINGER_TIP + 4 * FOOD_RADIUS) ** 2:
            continue
        u, v = _apart(u, v, 0.0, 0.0, RADIUS + FOOD_RADIUS)
        if low:
            if robot.held >= 0:
                u, v = _apart(u, v, robot.grip_x, robot.grip_y, 2 * FOOD_RADIUS)
            depth, along, aside = push_out(u, v, tip_of(robot), robot.jaw, FOOD_RADIUS)
            if depth > 0.0:
                # Within the cone of friction food moves with the point of the finger that it touches; beyond the cone
                # it slips along the finger.
                slip = along * turn * u - aside * (forward - turn * v)
                drag = min(_FRICTION * depth, max(-_FRICTION * depth, slip))
                u, v = u + depth * along - drag * aside, v + depth * aside + drag * along
        cos, sin = robot.cos, robot.sin
        x, y = robot.x + u * cos - v * sin, robot.y + u * sin + v * cos
        foods[k].x, foods[k].y = x, y
        moved += abs(x - from_x) + abs(y - from_y)
    if moved > 0.0:
        # The nearest first, or food that lies further away would push it back.
        settled = -1.0
        for _ in range(len(foods)):
            nearest, least = -1, math.inf
            for k in range(len(foods)):
                dx, dy = foods[k].x - robot.x, foods[k].y - robot.y
                squared = dx * dx + dy * dy
                if settled < squared < least and not _is_held(robots, k):
                    nearest, least = k, squared
            if nearest < 0:
                break
            moved += _settle(robots, i, foods, nearest, walls)
            settled = least
    return moved


@rule
def _is_held(robots: Any, k: int) -> bool:
    """Whether any robot has a food object between its fingers."""
    for j in range(len(robots)):  # noqa: SIM110 (numba compiles no generator expressions)
        if robots[j].held == k:
            return True
    return False


@rule
def _settle(robots: Any, i: int, foods: Any, k: int, walls: Any) -> float:
    """Move food object `k` out of walls and other robots, and others away from it; returns the sum of the distances."""
    x, y, moved = foods[k].x, foods[k].y, 0.0
    for n in range(len(walls)):
        if is_near(x, y, walls[n], FOOD_RADIUS):
            far, nx, ny = from_wall(x, y, walls[n])
            x, y = x + nx * (FOOD_RADIUS - far), y + ny * (FOOD_RADIUS - far)
            moved += FOOD_RADIUS - far
    for j in range(len(robots)):
        if j != i:
            from_x, from_y = x, y
            x, y = _apart(x, y, robots[j].x, robots[j].y, RADIUS + FOOD_RADIUS)
            moved += abs(x - from_x) + abs(y - from_y)
    foods[k].x, foods[k].y = x, y
    for n in range(len(foods)):
        if n != k and not _is_held(robots, n):
            from_x, from_y = foods[n].x, foods[n].y
            foods[n].x, foods[n].y = _apart(from_x, from_y, x, y, 2 * FOOD_RADIUS)
            moved += abs(foods[n].x - from_x) + abs(foods[n].y - from_y)
    return moved


@rule
def _apart(x: float, y: float, from_x: float, from_y: float, distance: float) -> tuple[float, float]:
    """A place, moved away from another to at least this distance."""
    dx, dy = x - from_x, y - from_y
    far = math.sqrt(dx * dx + dy * dy)
    if far >= distance or far < 1e-9:
        return x, y
    return from_x + dx * distance / far, from_y + dy * distance / far


@rule
def advance(enclosure: Enclosure, anchor_x: float, anchor_y: float, constants: Any) -> None:
    """One round in an arena, once motors are commanded: everything moves, robots sense, the camera takes a frame.

    The robots' cables hang from the anchor.
    """
    robots, foods, walls, corners = enclosure.robots, enclosure.foods, enclosure.walls, enclosure.corners
    for i in range(len(robots)):
        begin_round(robots, i, foods, constants)
    for i in range(len(robots)):
        if not glide(robots, i, foods, walls, corners, constants):
            move_in_contact(robots, i, foods, walls, corners, constants)
    sense_all(enclosure, constants)
    look(enclosure, anchor_x, anchor_y, constants.noise)


_begin, _sense, _advance = entry(begin), entry(sense_all), entry(advance)


robot_dtype, food_dtype, detection_dtype, constants_dtype, track_dtype, wall_dtype = map(
    dtype_of, (RobotState, FoodState, FoodDetection, Constants, Track, Wall)
)
corner_dtype = np.dtype([("x", "f8"), ("y", "f8")])
"""A corner of walls that points into the floor."""


class CompiledWorld(Simulation):
    """A `Simulation` in compiled functions, in which `move_in_contact` moves the robots that touch something."""

    backend = "compiled"

    def _empty(self, arena: Arena, robots: int, foods: int) -> Enclosure:
        return Enclosure(
            np.zeros(robots, robot_dtype),
            np.zeros(foods, food_dtype),
            np.zeros(2 * foods, track_dtype),
            np.zeros(foods, detection_dtype),
            np.array(list(map(tuple, arena.wall_records)), wall_dtype),
            np.array([(x, y) for x, y, _, _ in arena.corners], corner_dtype),
        )

    def show_only(self, robots: Any, foods: Any, tracks: Any) -> None:
        """Be the world of these records, which others change: those of its only arena."""
        empty = self._empty(self.arenas[0], 0, len(foods))
        enclosure = empty._replace(robots=robots, foods=foods, tracks=tracks)
        self._show([enclosure], [0] * len(robots), [0] * len(foods))

    @cached_property
    def _numbers(self) -> Any:
        """`constants` as compiled functions take them."""
        return array_of(self.constants)[0]

    def _begin(self, enclosure: Enclosure) -> None:
        _begin(enclosure, self._numbers)

    def _sense(self, enclosure: Enclosure) -> None:
        _sense(enclosure, self._numbers)

    def _advance(self, number: int, enclosure: Enclosure) -> None:
        _advance(enclosure, *self._anchor, self._numbers)
