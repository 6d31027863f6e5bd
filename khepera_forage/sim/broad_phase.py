"""Which walls a simulated robot senses, and which it could touch: looked up once a round, from its centre."""

import math
from collections.abc import Sequence

from khepera_forage.geometry.polygon import Segment, distance, line_of
from khepera_forage.robots.khepera import FINGER_TIP, FOOD_RADIUS, RADIUS
from khepera_forage.robots.proximity import REACH
from khepera_forage.sim.arena import Pose

PUSHED = FINGER_TIP + 2 * FOOD_RADIUS
"""Food that a lowered gripper may be pushing lies within this of the robot's centre, mm."""
SHOVED = RADIUS + FOOD_RADIUS + 1.0
"""Food that the body itself may push lies within this of its centre, mm."""
GRIPPER_AHEAD, GRIPPER_RADIUS = 56.0, 40.0
"""A circle around the gripper and what it holds, mm."""
_GRIPPER_REACH = GRIPPER_AHEAD + GRIPPER_RADIUS


class WallWatch:
    """The walls of a robot's own enclosure.

    Args:
        walls: Its segments.

    Attributes:
        near: Those in range of the infra-reds.
    """

    def __init__(self, walls: Sequence[Segment]) -> None:
        self._walls = [(wall, *line_of(wall)) for wall in walls]
        self.near: list[Segment] = []
        # Where all walls were last looked at, how far the nearest line of a wall was then, and how far the robot has
        # moved since.
        self._x = self._y = self._nearest_line = self._moved = 0.0

    def survey(self, x: float, y: float) -> None:
        """Look which walls are near a robot at this place, mm."""
        # Lines come nearer by no more than the robot moves: mostly none can be in range yet.
        dx, dy = x - self._x, y - self._y
        moved = self._moved = math.sqrt(dx * dx + dy * dy)
        if self._nearest_line > REACH + moved:
            return
        # The distance from a wall's line is cheap, and mostly shows that the wall is out of range.
        nearest = math.inf
        near = []
        for wall, normal_x, normal_y, offset in self._walls:
            off_line = abs(normal_x * x + normal_y * y - offset)
            if off_line < nearest:
                nearest = off_line
            if off_line < REACH and distance(x, y, wall) < REACH:
                near.append(wall)
        self.near = near
        self._x, self._y, self._nearest_line, self._moved = x, y, nearest, 0.0

    def clear(self, pose: Pose, travel: float, pushing: bool) -> bool:
        """Whether nothing of the robot, or that it pushes, can touch a wall.

        Args:
            pose: Of the robot, where the walls were last surveyed.
            travel: How far any point of it gets, mm.
            pushing: Whether there is something that it may push.
        """
        nearest = self._nearest_line - self._moved - travel
        if nearest > (PUSHED if pushing else _GRIPPER_REACH):
            return True
        x, y, angle = pose
        reach, gripper_reach = travel + (PUSHED if pushing else RADIUS), travel + GRIPPER_RADIUS
        beside = nearest < (PUSHED if pushing else RADIUS)
        tip_x, tip_y = x + GRIPPER_AHEAD * math.cos(angle), y + GRIPPER_AHEAD * math.sin(angle)
        for wall, normal_x, normal_y, offset in self._walls:
            # As in `survey`, the distance from the wall's line mostly shows that the wall is out of reach.
            if beside and abs(normal_x * x + normal_y * y - offset) < reach and distance(x, y, wall) < reach:
                return False
            off_line = abs(normal_x * tip_x + normal_y * tip_y - offset)
            if off_line < gripper_reach and distance(tip_x, tip_y, wall) < gripper_reach:
                return False
        return True
