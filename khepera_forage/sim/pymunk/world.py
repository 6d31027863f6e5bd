"""`PymunkWorld`: robots that touch something are moved by pymunk's rigid bodies."""

import math
from collections.abc import Sequence
from typing import Any

import pymunk

from khepera_forage.geometry.plane import is_near
from khepera_forage.robots.khepera import (
    ARM_ON_FLOOR,
    FINGER_THICKNESS,
    FINGER_TIP,
    FOOD_RADIUS,
    JAW_OPEN,
    JAW_ROOT,
    MASS,
    RADIUS,
    half_gap,
)
from khepera_forage.sim.arena import Arena, Point
from khepera_forage.sim.driving import (
    SUBSTEPS,
    begin_round,
    glide,
    grip_place,
    move_jaw,
    moves_jaw,
    push_out,
    seen_from,
    tip_of,
    travel_of,
)
from khepera_forage.sim.records import Enclosure, FoodDetection, FoodState, RobotState
from khepera_forage.sim.sensing import begin, look, sense_all
from khepera_forage.sim.simulation import Simulation
from khepera_forage.vision.association import Track

FOOD_MASS = 0.013
"""kg: 22 cubic centimetres of soft wood (3.1: light enough for a Khepera to lift). Assumption: 0.6 g/cm3."""
_INERTIA = 0.1 * FOOD_MASS
"""kg that resist when food is pushed: pymunk shares an overlap out by inertia, and a finger that begins to push would
turn its robot back, though the wheels hold five times as well as the food. Pushed food stops at once either way."""
FLOOR_FRICTION = 0.3 * FOOD_MASS * 9810.0
"""kg mm/s2: wood on a painted floor, coefficient 0.3. Assumption."""
TRACTION = 0.6 * MASS * 9810.0
"""kg mm/s2 that the wheels can pull: rubber on a painted floor, coefficient 0.6. Assumption."""
_THIN = FINGER_THICKNESS / 2
_FRICTION = 0.2
_FINE_TRAVEL = 0.8
"""How far a point of a robot may travel in one step near something, in mm: overlaps then stay below 1 mm."""
_PUSHED = FINGER_TIP + 2 * FOOD_RADIUS
"""Food that the robot may be pushing lies within this of its centre, mm."""
_GRIPPER_AHEAD, _GRIPPER_RADIUS = 56.0, 40.0
"""A circle around the gripper and what it holds, mm."""

# Which shapes touch which: a raised gripper and lifted food pass above food on the floor (23 mm high).
_WALL, _ROBOT, _FOOD, _FINGERS, _ABOVE = (1 << i for i in range(5))
WALLS = pymunk.ShapeFilter(categories=_WALL)
ROBOTS = pymunk.ShapeFilter(categories=_ROBOT)
FOOD = pymunk.ShapeFilter(categories=_FOOD, mask=_WALL | _ROBOT | _FOOD | _FINGERS)
FINGERS = pymunk.ShapeFilter(categories=_FINGERS, mask=_WALL | _ROBOT | _FOOD)
ABOVE = pymunk.ShapeFilter(categories=_ABOVE, mask=_WALL | _ROBOT)
NOTHING = pymunk.ShapeFilter(categories=0, mask=0)


class Bodies:
    """The bodies of an arena.

    Args:
        enclosure: Everything in the arena; its records change from round to round.
    """

    def __init__(self, enclosure: Enclosure) -> None:
        self._enclosure = enclosure
        space = self._space = pymunk.Space()
        space.collision_bias = 0.7**60
        # Enough for a row of food squeezed against a wall to stay out of it: with ten it gave way by 1.6 mm.
        space.iterations = 40
        # Contacts are not carried over from step to step: their impulses, scaled to a step of another length, would
        # throw a robot that pressed a finger against a wall.
        space.collision_persistence = 1
        for wall in enclosure.walls:
            ends = (wall.x1, wall.y1), (wall.x1 + wall.ex, wall.y1 + wall.ey)
            self._add(pymunk.Segment(space.static_body, *ends, 0), WALLS)
        self._robots = [_RobotBody(space, robot, self._add) for robot in enclosure.robots]
        self._foods = [self._food() for _ in enclosure.foods]
        self._held: set[int] = set()

    def _add(self, shape: pymunk.Shape, filter: pymunk.ShapeFilter) -> None:
        shape.friction, shape.filter = _FRICTION, filter
        self._space.add(shape)

    def _food(self) -> tuple[pymunk.Body, pymunk.Shape]:
        """A wooden disc that is pushed by contact and slows on the floor."""
        space = self._space
        body = pymunk.Body(_INERTIA, pymunk.moment_for_circle(_INERTIA, 0, FOOD_RADIUS))
        slide = pymunk.PivotJoint(space.static_body, body, (0, 0), (0, 0))
        spin = pymunk.GearJoint(space.static_body, body, 0, 1)
        slide.max_bias = spin.max_bias = 0
        slide.max_force, spin.max_force = FLOOR_FRICTION, FLOOR_FRICTION * FOOD_RADIUS * 2 / 3
        space.add(body, slide, spin)
        disc = pymunk.Circle(body, FOOD_RADIUS)
        self._add(disc, FOOD)
        return body, disc

    def advance(self, moving: Sequence[int], constants: Any) -> None:
        """One round of physics.

        Pushed food stops at its end: at friction 0.3 it would slide on by 1 mm from the fastest push.

        Args:
            moving: Numbers of the robots whose wheels turn in it; the others have moved, and brake.
            constants: `Constants`.
        """
        robots, foods = self._enclosure.robots, self._enclosure.foods
        walls, duration = self._enclosure.walls, constants.timing.round_duration
        steps = max(_steps(robots[i], foods, walls, duration) for i in moving)
        dt = duration / steps
        for i, robot in enumerate(robots):
            self._robots[i].put(robot, *((robot.forward, robot.turn) if i in moving else (0.0, 0.0)))
        for food, (body, _) in zip(foods, self._foods, strict=True):
            body.position, body.velocity, body.angular_velocity = (food.x, food.y), (0, 0), 0
        self._shape()
        for _ in range(steps):
            for i in moving:
                self._robots[i].pull(robots[i])
                if moves_jaw(robots[i]):
                    self._record()
                    move_jaw(robots, i, foods, walls, constants.timing.jaw_speed * dt)
                    self._slide_aside(robots[i])
                    self._shape()
            self._space.step(dt)
        self._record()

    def _slide_aside(self, robot: Any) -> None:
        """Let food on the floor slide out of the way of a moving jaw.

        Left to pymunk, an overlap would turn the robot as well.
        """
        if robot.arm < ARM_ON_FLOOR:
            return
        for k, (food, (body, _)) in enumerate(zip(self._enclosure.foods, self._foods, strict=True)):
            u, v = seen_from(robot, food.x, food.y)
            depth, along, aside = push_out(u, v, tip_of(robot), robot.jaw, FOOD_RADIUS)
            if depth > 0.0 and k != robot.held:
                food.x += depth * (along * robot.cos - aside * robot.sin)
                food.y += depth * (along * robot.sin + aside * robot.cos)
                body.position = food.x, food.y

    def _shape(self) -> None:
        """Give grippers and food the shapes that their records say: held food is one rigid body with its robot."""
        held = {robot.held for robot in self._enclosure.robots if robot.held >= 0}
        for robot, shapes in zip(self._enclosure.robots, self._robots, strict=True):
            shapes.shape(robot)
        for k in held ^ self._held:
            (body, disc), food = self._foods[k], self._enclosure.foods[k]
            body.position, body.velocity, body.angular_velocity = (food.x, food.y), (0, 0), 0
            disc.filter = NOTHING if k in held else FOOD
        self._held = held

    def _record(self) -> None:
        """Write down where everything has got."""
        foods = self._enclosure.foods
        for food, (body, _) in zip(foods, self._foods, strict=True):
            food.x, food.y = body.position
        for robot, its in zip(self._enclosure.robots, self._robots, strict=True):
            robot.x, robot.y = its.body.position
            robot.heading = heading = its.body.angle
            robot.cos, robot.sin = math.cos(heading), math.sin(heading)
            if robot.held >= 0:
                foods[robot.held].x, foods[robot.held].y = grip_place(robot)


def _steps(robot: Any, foods: Any, walls: Any, duration: float) -> int:
    """Steps of physics in a round: more if the robot, or food that it pushes, could touch something in it."""
    travel = travel_of(robot, duration)
    x, y = robot.x + _GRIPPER_AHEAD * robot.cos, robot.y + _GRIPPER_AHEAD * robot.sin
    near = any(
        is_near(robot.x, robot.y, wall, travel + _PUSHED) or is_near(x, y, wall, travel + _GRIPPER_RADIUS)
        for wall in walls
    )
    if robot.arm >= ARM_ON_FLOOR:
        near = near or any(math.dist((robot.x, robot.y), (food.x, food.y)) < travel + _PUSHED for food in foods)
    return max(SUBSTEPS, math.ceil(travel / _FINE_TRAVEL)) if near else SUBSTEPS


class _RobotBody:
    """A robot: its body, its gripper, what it holds, and wheels that pull to a speed within their traction.

    The wheels are joints to a second body, which never moves but has the velocity to which they pull.
    """

    def __init__(self, space: pymunk.Space, robot: Any, add: Any) -> None:
        body = self.body = pymunk.Body(MASS, MASS * RADIUS**2 / 2)
        self._wheels = pymunk.Body(body_type=pymunk.Body.KINEMATIC)
        pull, twist = (
            pymunk.PivotJoint(self._wheels, body, (0, 0), (0, 0)),
            pymunk.GearJoint(self._wheels, body, 0, 1),
        )
        pull.max_bias = twist.max_bias = 0
        pull.max_force, twist.max_force = TRACTION, TRACTION * robot.wheel_base / 2
        space.add(body, self._wheels, pull, twist)
        palm, wide, self._end = JAW_ROOT - _THIN, half_gap(JAW_OPEN) + _THIN, tip_of(robot) - _THIN
        self._fingers = [
            (side, pymunk.Segment(body, (JAW_ROOT, side * wide), (self._end, side * wide), _THIN)) for side in (1, -1)
        ]
        self._gripper = [pymunk.Segment(body, (palm, -wide), (palm, wide), _THIN)]
        self._gripper += [finger for _, finger in self._fingers]
        self._held = pymunk.Circle(body, FOOD_RADIUS)
        add(pymunk.Circle(body, RADIUS), ROBOTS)
        for shape in (*self._gripper, self._held):
            add(shape, NOTHING)

    def put(self, robot: Any, forward: float, turn: float) -> None:
        """Stand where the record says, with this speed, to which the wheels pull as well."""
        self.body.position, self.body.angle = (robot.x, robot.y), robot.heading
        self.body.velocity = self._wheels.velocity = forward * robot.cos, forward * robot.sin
        self.body.angular_velocity = self._wheels.angular_velocity = turn

    def pull(self, robot: Any) -> None:
        """Let the wheels pull ahead to the speed of this round."""
        angle = self.body.angle
        self._wheels.velocity = robot.forward * math.cos(angle), robot.forward * math.sin(angle)
        self._wheels.angular_velocity = robot.turn

    def shape(self, robot: Any) -> None:
        """Arm, fingers and held food as the record says."""
        layer = FINGERS if robot.arm >= ARM_ON_FLOOR else ABOVE
        if not robot.has_gripper:
            layer = NOTHING
        for shape in self._gripper:
            shape.filter = layer
        aside = half_gap(robot.jaw) + _THIN
        for side, finger in self._fingers:
            finger.unsafe_set_endpoints((JAW_ROOT, side * aside), (self._end, side * aside))
        self._held.filter = NOTHING
        if robot.held >= 0:
            self._held.unsafe_set_offset((robot.grip_x, robot.grip_y))
            self._held.filter = FOOD if robot.arm >= ARM_ON_FLOOR else ABOVE


class PymunkWorld(Simulation):
    """A `Simulation` in which pymunk moves the robots that touch something."""

    backend = "pymunk"

    def _empty(self, arena: Arena, robots: int, foods: int) -> Enclosure:
        return Enclosure(
            [RobotState() for _ in range(robots)],
            [FoodState() for _ in range(foods)],
            [Track() for _ in range(2 * foods)],
            [FoodDetection() for _ in range(foods)],
            arena.wall_records,
            [Point(x, y) for x, y, _, _ in arena.corners],
        )

    def _begin(self, enclosure: Enclosure) -> None:
        self._bodies: dict[int, Bodies] = {}
        begin(enclosure, self.constants)

    def _sense(self, enclosure: Enclosure) -> None:
        sense_all(enclosure, self.constants)

    def _advance(self, number: int, enclosure: Enclosure) -> None:
        robots, foods, _, _, walls, corners = enclosure
        for i in range(len(robots)):
            begin_round(robots, i, foods, self.constants)
        touching = [i for i in range(len(robots)) if not glide(robots, i, foods, walls, corners, self.constants)]
        if touching:
            if number not in self._bodies:
                self._bodies[number] = Bodies(enclosure)
            self._bodies[number].advance(touching, self.constants)
        sense_all(enclosure, self.constants)
        look(enclosure, *self._anchor, self.noise)

    def __getstate__(self) -> dict[str, Any]:
        # A copy continues like its original, bit for bit: both make new bodies.
        self._bodies = {}
        return super().__getstate__()
