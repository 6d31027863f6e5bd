"""The gripper turret on a pymunk body: arm, two fingers, optical barrier, and the grip on food.

Nothing teleports: the fingers push what they touch, a closing jaw holds what is between them, a raised
arm takes it off the floor, and opening leaves it where it is.
"""

import math
from collections.abc import Sequence

import pymunk

from khepera_forage.geometry.polygon import Segment
from khepera_forage.robots.khepera import (
    ARM_ON_FLOOR,
    ARM_RAISED,
    BARRIER,
    FINGER_THICKNESS,
    FOOD_RADIUS,
    JAW_ON_FOOD,
    JAW_OPEN,
    JAW_ROOT,
    RADIUS,
    half_gap,
)
from khepera_forage.sim.pymunk import collision_filters as layers
from khepera_forage.sim.pymunk.food import PymunkFood
from khepera_forage.sim.world import Timing

_THIN = FINGER_THICKNESS / 2
_TOUCH = 0.5
"""mm of play within which the fingers count as touching food."""


class PymunkGripper:
    """Arm and jaw at finite speed, raised and open to begin with.

    Args:
        space: The pymunk space to live in.
        body: Of the robot.
        fingers: Their length, mm.
        timing: How fast arm and jaw move.

    Attributes:
        arm: Position 255 (down) to 215 (raised).
        jaw: Position 200 (open) to 0 (closed).
        held: The food between the closed fingers, or None.
    """

    def __init__(self, space: pymunk.Space, body: pymunk.Body, fingers: float, timing: Timing) -> None:
        self._timing = timing
        self._space = space
        self._body = body
        self._tip = JAW_ROOT + fingers
        self.arm = float(ARM_RAISED)
        self.jaw = float(JAW_OPEN)
        self.held: PymunkFood | None = None
        palm = JAW_ROOT - _THIN
        wide = half_gap(JAW_OPEN) + _THIN
        self._palm = pymunk.Segment(body, (palm, -wide), (palm, wide), _THIN)
        self._left = pymunk.Segment(body, (JAW_ROOT, wide), (self._tip - _THIN, wide), _THIN)
        self._right = pymunk.Segment(body, (JAW_ROOT, -wide), (self._tip - _THIN, -wide), _THIN)
        self._shapes = (self._palm, self._left, self._right)
        for shape in self._shapes:
            shape.friction = 0.2
            shape.filter = layers.RAISED_FINGERS
        space.add(*self._shapes)

    @property
    def on_floor(self) -> bool:
        """Whether the fingers reach down to food on the floor."""
        return self.arm >= ARM_ON_FLOOR

    def interrupted(
        self, x: float, y: float, cosine: float, sine: float, foods: Sequence[PymunkFood]
    ) -> bool:
        """Whether something crossed the optical barrier between the fingers at the end of the last round.

        Args:
            x: Of the robot then, mm.
            y: Of the robot then, mm.
            cosine: Of its heading then.
            sine: Of its heading then.
            foods: All food.
        """
        held = self.held
        if held is None and self.arm < ARM_ON_FLOOR:  # `not on_floor`, without a call in every round
            return False
        gap = half_gap(self.jaw)
        for food in foods if held is None else (held,):
            food_x, food_y = food.place
            dx, dy = food_x - x, food_y - y
            ahead = dx * cosine + dy * sine - BARRIER
            aside = abs(dy * cosine - dx * sine) - gap
            squared = ahead * ahead + (aside * aside if aside > 0.0 else 0.0)
            crosses = squared < FOOD_RADIUS * FOOD_RADIUS
            if crosses and (food is held or not food.lifted):
                return True
        return False

    def move_arm(
        self, target: float, dt: float, foods: Sequence[PymunkFood], others: Sequence[pymunk.Body]
    ) -> None:
        """Move the arm towards a position for `dt` seconds; it does not come down on food or robots.

        Args:
            target: Commanded position.
            dt: Seconds.
            foods: All food that could be in the way.
            others: Bodies of the other robots.
        """
        was_on_floor = self.on_floor
        step = self._timing.arm_speed * dt
        arm = min(target, self.arm + step) if target > self.arm else max(target, self.arm - step)
        if arm >= ARM_ON_FLOOR and not was_on_floor and not self._room_below(foods, others):
            self.arm = ARM_ON_FLOOR - 1.0
            return
        self.arm = arm
        if self.on_floor != was_on_floor:
            for shape in self._shapes:
                shape.filter = layers.FINGERS if self.on_floor else layers.RAISED_FINGERS
            if self.held is not None:
                self.held.set_lifted(not self.on_floor)

    def _room_below(self, foods: Sequence[PymunkFood], others: Sequence[pymunk.Body]) -> bool:
        """Whether the arm can come down: the fingers on nothing, held food on no other food or robot."""
        if self.held is not None and not self._floor_free(foods, others):
            return False
        finger = half_gap(self.jaw) + _THIN
        for food in foods:
            if food.lifted:
                continue
            x, y = self._body.world_to_local(food.position)
            ahead = max(JAW_ROOT - x, x - self._tip, 0.0)
            aside = max(abs(abs(y) - finger) - _THIN, 0.0)
            behind_palm = max(abs(y) - finger, 0.0)
            near = (FOOD_RADIUS - _TOUCH) ** 2
            if ahead**2 + aside**2 < near or (x - JAW_ROOT + _THIN) ** 2 + behind_palm**2 < near:
                return False
        return True

    def _floor_free(self, foods: Sequence[PymunkFood], others: Sequence[pymunk.Body]) -> bool:
        assert self.held is not None
        place = self.held.position
        return not any(
            food is not self.held and math.dist(place, food.position) < 2 * FOOD_RADIUS for food in foods
        ) and not any(math.dist(place, body.position) < FOOD_RADIUS + RADIUS for body in others)

    def wants_to_move_jaw(self, target: float) -> bool:
        """Whether the jaw is on its way: a jaw that holds food closes no further."""
        return target != self.jaw and (self.held is None or target > self.jaw)

    def move_jaw(
        self,
        target: float,
        dt: float,
        foods: Sequence[PymunkFood],
        others: Sequence[pymunk.Body],
        walls: Sequence[Segment],
    ) -> None:
        """Move the jaw towards a position for `dt` seconds; closing on food holds it, opening lets it go.

        Args:
            target: Commanded position.
            dt: Seconds.
            foods: All food that could be between the fingers or in the way.
            others: Bodies of the other robots.
            walls: Those near the robot; a finger does not open into one.
        """
        if not self.wants_to_move_jaw(target):
            return
        step = self._timing.jaw_speed * dt
        jaw = min(target, self.jaw + step) if target > self.jaw else max(target, self.jaw - step)
        if jaw > self.jaw and walls and self._open_into_wall(jaw, walls):
            return
        if self.held is not None:
            if not self.on_floor and not self._floor_free(foods, others):
                return
            self.held.let_go()
            self.held = None
        elif jaw < self.jaw and self.on_floor and (food := self._between(jaw, foods)) is not None:
            jaw = JAW_ON_FOOD
            if abs(self._body.world_to_local(food.position)[1]) < 2 * _TOUCH:
                food.hold(self._body)
                self.held = food
        self.jaw = jaw
        y = half_gap(jaw) + _THIN
        self._left.unsafe_set_endpoints((JAW_ROOT, y), (self._tip - _THIN, y))
        self._right.unsafe_set_endpoints((JAW_ROOT, -y), (self._tip - _THIN, -y))

    def _open_into_wall(self, jaw: float, walls: Sequence[Segment]) -> bool:
        """Whether a finger at this position of the jaw would stand in a wall, seen from the robot's side of it."""
        centre_x, centre_y = self._body.position
        cosine, sine = math.cos(self._body.angle), math.sin(self._body.angle)
        aside = half_gap(jaw) + FINGER_THICKNESS
        corners = [
            (centre_x + ahead * cosine - left * sine, centre_y + ahead * sine + left * cosine)
            for ahead in (JAW_ROOT, self._tip)
            for left in (aside, -aside)
        ]
        for x1, y1, x2, y2 in walls:
            ex, ey = x2 - x1, y2 - y1
            side = math.copysign(1.0 / math.hypot(ex, ey), ex * (centre_y - y1) - ey * (centre_x - x1))
            for x, y in corners:
                along = ((x - x1) * ex + (y - y1) * ey) / (ex * ex + ey * ey)
                if 0.0 <= along <= 1.0 and (ex * (y - y1) - ey * (x - x1)) * side < -_TOUCH:
                    return True
        return False

    def _between(self, jaw: float, foods: Sequence[PymunkFood]) -> PymunkFood | None:
        """The food between the fingers when they close on it: they shift it to the middle and stop there."""
        if half_gap(jaw) > FOOD_RADIUS:
            return None
        for food in foods:
            x, y = self._body.world_to_local(food.position)
            if JAW_ROOT < x < self._tip and abs(y) < half_gap(self.jaw) and not food.lifted:
                return food
        return None
