"""Checks of arenas and layouts, with errors that quote what is wrong: the same in every world."""

from collections.abc import Sequence

from khepera_forage.robots.footprint import discs_are_apart, gripper_is_free
from khepera_forage.robots.khepera import FINGER_TIP, FOOD_RADIUS, RADIUS
from khepera_forage.sim.arena import Arena, Point, Pose
from khepera_forage.sim.world import Layout
from khepera_forage.vision.scene import MM_PER_PIXEL
from khepera_forage.vision.shapes import PICTURE_HEIGHT, PICTURE_WIDTH

_WIDTH, _HEIGHT = PICTURE_WIDTH * MM_PER_PIXEL, PICTURE_HEIGHT * MM_PER_PIXEL
"""Of the picture, in mm."""


def check_seen(arenas: Sequence[Arena]) -> None:
    """Complain about arenas that the camera does not see.

    Raises:
        ValueError: One reaches outside the picture of 640 x 480 pixels of 5 mm.
    """
    if not all(map(is_seen, arenas)):
        x1, y1, x2, y2 = _bounds(arenas)
        raise ValueError(
            f"arenas reach from ({x1:g}, {y1:g}) to ({x2:g}, {y2:g}) mm; "
            f"allowed: (0, 0) to ({_WIDTH:g}, {_HEIGHT:g}), what the camera sees"
        )


def is_seen(arena: Arena) -> bool:
    """Whether the camera sees all of an arena."""
    x1, y1, x2, y2 = arena.bounds
    return x1 >= 0 and y1 >= 0 and x2 <= _WIDTH and y2 <= _HEIGHT


def cable_anchor(arenas: Sequence[Arena]) -> tuple[float, float]:
    """Where the robots' cables hang from (3.7), as seen from above: the middle of all arenas, in mm."""
    x1, y1, x2, y2 = _bounds(arenas)
    return (x1 + x2) / 2, (y1 + y2) / 2


def _bounds(arenas: Sequence[Arena]) -> tuple[float, float, float, float]:
    left, bottom, right, top = zip(*(arena.bounds for arena in arenas), strict=True)
    return min(left), min(bottom), max(right), max(top)


def arena_of(arenas: Sequence[Arena], what: str, place: Point | Pose, radius: float) -> Arena:
    """The arena in which something stands.

    Raises:
        ValueError: It does not stand on the free floor of any.
    """
    nearest = arenas[0] if len(arenas) == 1 else max(arenas, key=lambda arena: arena.clearance(place))
    nearest.check_free(what, place, radius)
    return nearest


def check_robot(arena: Arena, pose: Pose) -> None:
    """Complain if a robot, or its open gripper, would stand in a wall.

    Raises:
        ValueError: It would; the message quotes the pose.
    """
    arena.check_free("robot", pose, RADIUS)
    if not gripper_is_free(pose.x, pose.y, pose.heading, 0.0, arena.wall_records):
        raise ValueError(
            f"{arena.name}: robot at ({pose.x:g}, {pose.y:g}) mm has its gripper in a wall; "
            f"allowed: {FINGER_TIP:g} mm ahead of its centre free"
        )


def check_apart(layout: Layout) -> None:
    """Complain about robots and food on top of one another.

    Raises:
        ValueError: Two discs overlap.
    """
    discs = [("robot", start[0], start[1], RADIUS) for start in layout.starts]
    discs += [("food", food[0], food[1], FOOD_RADIUS) for food in layout.foods]
    for i, (what, x, y, radius) in enumerate(discs):
        for other, ox, oy, other_radius in discs[:i]:
            if not discs_are_apart(x, y, ox, oy, radius + other_radius):
                raise ValueError(
                    f"{what} at ({x:g}, {y:g}) mm overlaps {other} at ({ox:g}, {oy:g}) mm; "
                    f"allowed: at least {radius + other_radius:g} mm apart"
                )


def check_starts(layout: Layout, robots: int) -> None:
    """Complain unless there is one start a robot.

    Raises:
        ValueError: There is not.
    """
    if len(layout.starts) != robots:
        raise ValueError(f"{len(layout.starts)} starts for {robots} robots; allowed: one each")


def check_layout(arenas: Sequence[Arena], layout: Layout) -> None:
    """Complain unless every robot can stand in its own arena, and the food in any.

    Args:
        arenas: One a robot.
        layout: Where they should stand.

    Raises:
        ValueError: Something cannot stand where it should.
    """
    check_starts(layout, len(arenas))
    for arena, start in zip(arenas, layout.starts, strict=True):
        check_robot(arena, start)
    for food in layout.foods:
        arena_of(arenas, "food", food, FOOD_RADIUS)
    check_apart(layout)
