"""Robots on a mat, which report their own places: a laboratory of them needs no camera."""

import math
from abc import abstractmethod
from collections.abc import Callable
from typing import ClassVar, NamedTuple

from khepera_forage.robots.khepera import CONTROL_PERIOD, RADIUS
from khepera_forage.robots.real_robot import RealRobot

COMMAND_DURATION = 300
"""Milliseconds that a motor command lasts, or two periods: the robot of a program that has ended stops by itself."""
_LOOK_AHEAD = 8.0
"""mm on the plan in which a wall before the robot stops it."""
_ALONG = 1.0
"""mm by which a robot may come nearer to a wall: it drives along it."""


class MatPose(NamedTuple):
    """A place on the plan: x and y in mm, x to the right and y up; heading in radians, counter-clockwise from x."""

    x: float
    y: float
    heading: float


class MatRobot(RealRobot):
    """A robot that reports its place on a mat. See `RealRobot`.

    Attributes:
        mat_size: Width and height of the mat on the plan in mm; the origin is its lower left corner.
        pose: Its last place on the plan.
        on_mat: Whether it sees the mat.
        clearance: Distance in mm from a place on the plan to the nearest wall, negative behind it; None without walls.
            A mat has no walls, so that the driver itself keeps the robot within them: it turns it along the wall.
    """

    mat_size: ClassVar[tuple[float, float]]

    def __init__(self, port: str, *, max_speed: int | None = None, period: float | None = CONTROL_PERIOD) -> None:
        super().__init__(port, max_speed=max_speed, period=period)
        self.pose = MatPose(0.0, 0.0, 0.0)
        self.on_mat = False
        self.clearance: Callable[[float, float], float] | None = None
        self._travel = (0.0, 0.0)
        """mm on the plan that the wheels have driven."""

    @abstractmethod
    def turn_for(self, left: float, right: float, milliseconds: int) -> None:
        """Turn the wheels for a short time, at speeds in speed units or slower."""

    def _note_place(self, pose: MatPose) -> None:
        """Take a new place, and add what the wheels have driven to it."""
        if self.on_mat:
            last = self.pose
            turn = math.remainder(pose.heading - last.heading, math.tau)
            middle = last.heading + turn / 2
            forward = (pose.x - last.x) * math.cos(middle) + (pose.y - last.y) * math.sin(middle)
            side = turn * self.model.plan_base / 2
            self._travel = self._travel[0] + forward - side, self._travel[1] + forward + side
        self.pose, self.on_mat = pose, True

    def _along_walls(self, left: float, right: float) -> tuple[float, float]:
        """Wheel speeds that leave a robot within the walls: a wall turns it along, to the side with more room."""
        forward = (left + right) / 2
        if forward and self.clearance is not None:
            x, y, heading = self.pose
            ahead = math.copysign(_LOOK_AHEAD, forward)
            here = self.clearance(x, y)
            after, to_right, to_left = (
                self.clearance(x + ahead * math.cos(heading + turn), y + ahead * math.sin(heading + turn))
                for turn in (0.0, -0.5, 0.5)
            )
            if after < min(RADIUS, here) - _ALONG:
                turn = math.copysign(abs(forward), to_left - to_right)
                return -turn, turn
        return left, right
