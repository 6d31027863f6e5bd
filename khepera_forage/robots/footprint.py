"""Whether a robot's body and gripper stand free of walls. Plain functions, also compiled. Millimetres, radians."""

from typing import Any

from khepera_forage.geometry.plane import clearance, cosine_sine
from khepera_forage.robots.khepera import FINGER_THICKNESS, FINGER_TIP, JAW_OPEN, JAW_ROOT, RADIUS, half_gap

GRIPPER_HALF_WIDTH = half_gap(JAW_OPEN) + FINGER_THICKNESS
"""Half the width of the open gripper, mm."""
_BACK = JAW_ROOT - FINGER_THICKNESS
"""mm from a robot's centre forward to the back of the palm."""


def body_is_free(x: float, y: float, margin: float, walls: Any) -> bool:
    """Whether the robot's body is at least `margin` mm from every wall."""
    return bool(clearance(x, y, walls) >= RADIUS + margin)


def gripper_is_free(x: float, y: float, heading: float, margin: float, walls: Any) -> bool:
    """Whether no wall reaches into the open gripper, and its corners are at least `margin` mm from every wall.

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
    # A thin wall can reach into the gripper while all corners are free.
    middle, half_length = (_BACK + FINGER_TIP + margin) / 2.0, (FINGER_TIP + margin - _BACK) / 2.0
    middle_x, middle_y = x + middle * cosine, y + middle * sine
    for k in range(len(walls)):
        if _meets_rectangle(walls[k], middle_x, middle_y, cosine, sine, half_length, wide):
            return False
    return True


def _meets_rectangle(
    wall: Any, x: float, y: float, cosine: float, sine: float, half_length: float, half_width: float
) -> bool:
    """Whether a wall reaches into a rectangle: nothing separates them along its sides, or across the wall."""
    ahead, aside = ((wall.x1 - x) * cosine + (wall.y1 - y) * sine, (wall.y1 - y) * cosine - (wall.x1 - x) * sine)
    other_ahead, other_aside = (ahead + wall.ex * cosine + wall.ey * sine, aside + wall.ey * cosine - wall.ex * sine)
    if min(ahead, other_ahead) >= half_length or max(ahead, other_ahead) <= -half_length:
        return False
    if min(aside, other_aside) >= half_width or max(aside, other_aside) <= -half_width:
        return False
    off = wall.normal_x * x + wall.normal_y * y - wall.offset
    along = abs(wall.normal_x * cosine + wall.normal_y * sine)
    across = abs(wall.normal_y * cosine - wall.normal_x * sine)
    return bool(abs(off) < half_length * along + half_width * across)


def discs_are_apart(x: float, y: float, other_x: float, other_y: float, distance: float) -> bool:
    """Whether two centres are at least `distance` mm apart."""
    dx, dy = x - other_x, y - other_y
    return bool(dx * dx + dy * dy >= distance * distance)
