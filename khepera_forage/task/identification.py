"""When food is identified, and when it is delivered (4.2.3, 5.3)."""

from typing import Any

from khepera_forage.robots.khepera import ARM_DOWN, JAW_OPEN, Motors, Senses
from khepera_forage.task.arena_map import ArenaMap

_DOWN = ARM_DOWN - 3
_OPEN = JAW_OPEN - 5


def explored(before: Senses, after: Senses, applied: Motors) -> bool:
    """Whether food was in the barrier, arm down, jaw open and wheels still, for one whole round.

    Args:
        before: What the robot sensed when the round began.
        after: What it senses now.
        applied: What its motors did in between.
    """
    return (
        before.object_presence != 0
        and after.object_presence != 0
        and before.arm >= _DOWN
        and after.arm >= _DOWN
        and before.jaw >= _OPEN
        and after.jaw >= _OPEN
        and applied.left == 0
        and applied.right == 0
    )


def drawn_type(draw: float, odds: Any) -> int:
    """The type of food that a uniform draw stands for (3.7, 4.2.3).

    Args:
        draw: Uniform in [0, 1).
        odds: Of each `FoodType` but UNKNOWN, in their order; adding up to 1.
    """
    left = draw
    for k in range(len(odds)):
        left -= odds[k]
        if left < 0.0:
            return k + 1
    return len(odds)


def at_home(x: float, y: float, arena: ArenaMap) -> bool:
    """Whether a food object's centre, in pixels, is inside the home."""
    dx, dy = x - arena.home_x, y - arena.home_y
    return dx * dx + dy * dy <= arena.home_radius * arena.home_radius
