"""Whether a robot's body and gripper stand free of walls. Plain functions, also compiled. Millimetres, radians."""

from typing import Any

from khepera_forage.geometry.angles import cosine_sine
from khepera_forage.geometry.walls import clearance
from khepera_forage.robots.khepera import (
    FINGER_THICKNESS,
    FINGER_TIP,
    JAW_OPEN,
    JAW_ROOT,
    RADIUS,
    half_gap,
)

GRIPPER_HALF_WIDTH = half_gap(JAW_OPEN) + FINGER_THICKNESS
"""Half the width of the open gripper, mm."""


def body_is_free(x: float, y: float, margin: float, walls: Any) -> bool:
    """Whether the robot's body is at least `margin` mm from every wall."""
    return bool(clearance(x, y, walls) >= RADIUS + margin)


def gripper_is_free(x: float, y: float, heading: float, margin: float, walls: Any) -> bool:
    """Whether the open gripper stands in no wall, and its corners are at least `margin` mm from every wall.

    Args:
        x: Of the robot's centre.
        y: Of the robot's centre.
        heading: Radians.
        margin: In mm; the gripper also counts as wider by it.
        walls: `Wall` records.
    """
    cosine, sine = cosine_sine(heading)
    wide = GRIPPER_HALF_WIDTH + margin
    for corner in range(4):
        ahead = FINGER_TIP if corner < 2 else JAW_ROOT
        aside = wide if corner & 1 else -wide
        corner_x, corner_y = x + ahead * cosine - aside * sine, y + ahead * sine + aside * cosine
        if clearance(corner_x, corner_y, walls) < margin:
            return False
    # The end of a thin wall can stand between the fingers while all corners of the gripper are free.
    for k in range(len(walls)):
        dx, dy = walls[k].x1 - x, walls[k].y1 - y
        ahead, aside = dx * cosine + dy * sine, dy * cosine - dx * sine
        if JAW_ROOT < ahead < FINGER_TIP + margin and abs(aside) < wide:
            return False
    return True


def discs_are_apart(x: float, y: float, other_x: float, other_y: float, distance: float) -> bool:
    """Whether two centres are at least `distance` mm apart."""
    dx, dy = x - other_x, y - other_y
    return bool(dx * dx + dy * dy >= distance * distance)
