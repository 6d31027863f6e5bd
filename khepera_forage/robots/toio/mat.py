"""The printed mat: positions of the mat, and the same on the plan of an arena."""

import math
from typing import NamedTuple

from khepera_forage.robots.model import TOIO

MM_PER_UNIT = 560 / 411
"""Millimetres of the mat for one unit of its positions (toio-sdk-for-unity)."""
_PLAN = MM_PER_UNIT / TOIO.scale


class CubePose(NamedTuple):
    """A place on the plan: x and y in mm, x to the right and y up; heading in radians, counter-clockwise from x."""

    x: float
    y: float
    heading: float


class Mat(NamedTuple):
    """A mat.

    The plan's origin is the mat's lower left corner.

    Attributes:
        left: Smallest x of its positions.
        right: Largest x.
        top: Smallest y: on a mat, y points down.
        bottom: Largest y.
    """

    left: int
    right: int
    top: int
    bottom: int

    @property
    def size(self) -> tuple[float, float]:
        """Width and height on the plan, in mm."""
        return (self.right - self.left) * _PLAN, (self.bottom - self.top) * _PLAN

    def to_plan(self, x: float, y: float, angle: float) -> CubePose:
        """Convert a position of the mat, whose angle is in degrees clockwise from x."""
        heading = math.remainder(-math.radians(angle), math.tau)
        return CubePose((x - self.left) * _PLAN, (self.bottom - y) * _PLAN, heading)

    def to_mat(self, pose: CubePose) -> tuple[int, int, int]:
        """Convert a place on the plan."""
        angle = round(math.degrees(-pose.heading)) % 360
        return round(self.left + pose.x / _PLAN), round(self.bottom - pose.y / _PLAN), angle


SIMPLE_MAT = Mat(98, 402, 142, 358)
"""The A3 sheet that comes with each cube: 414 x 294 mm, on the plan 712 x 506 mm. Both corridors fit."""
