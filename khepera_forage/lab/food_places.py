"""Where food was last known to be: as the camera sees it, or in the gripper that has it."""

import math
from collections.abc import Sequence

from khepera_forage.lab.survey import place_of, within
from khepera_forage.robots.khepera import ARM_ON_FLOOR, FINGER_LENGTH, JAW_ROOT, Senses
from khepera_forage.sim.arena import Arena, Point, Pose
from khepera_forage.sim.world import FoodPlace
from khepera_forage.vision.scene import Scene

_BETWEEN_FINGERS = JAW_ROOT + FINGER_LENGTH / 2


class FoodWatch:
    """The food objects of a laboratory, in the order of its layout.

    A region without holes keeps to the object it was first taken for; a new one is the nearest object that no region
    shows. While a robot's optical barrier is interrupted, the object nearest to its gripper is in it.

    Args:
        places: Where each object was put.
        arenas: Regions outside them are no food.
    """

    def __init__(self, places: Sequence[Point], arenas: Sequence[Arena]) -> None:
        self._foods = [FoodPlace(x, y, False) for x, y in places]
        self._arenas = arenas
        self._shown: dict[int, int] = {}
        self._held: dict[int, int] = {}

    def places(self) -> tuple[FoodPlace, ...]:
        """Where each object is."""
        return tuple(self._foods)

    def held_by(self, robot: int) -> int | None:
        """Number of the object in a robot's gripper."""
        return self._held.get(robot)

    def update(self, scene: Scene, robots: Sequence[tuple[Pose, Senses]]) -> None:
        """Take in a round.

        Args:
            scene: What the camera reports.
            robots: Where each robot is, and what it senses.
        """
        for number, (pose, senses) in enumerate(robots):
            self._carry(number, pose, senses)
        food = [r for r in scene.regions if not r.holes and any(within(a, r) for a in self._arenas)]
        labels = {region.label for region in food}
        self._shown = {label: k for label, k in self._shown.items() if label in labels}
        for region in food:
            if not region.found:
                continue
            place = place_of(region)
            if region.label not in self._shown:
                taken = set(self._shown.values())
                free = [k for k in range(len(self._foods)) if k not in taken]
                if not free:
                    continue
                self._shown[region.label] = min(free, key=lambda k: math.dist(place, self._foods[k][:2]))
            k = self._shown[region.label]
            if k not in self._held.values():
                self._foods[k] = FoodPlace(*place, False)

    def _carry(self, number: int, pose: Pose, senses: Senses) -> None:
        """Keep what is in a robot's gripper with it; what leaves it lies where it was last."""
        if not senses.object_presence or not self._foods:
            left = self._held.pop(number, None)
            if left is not None:
                self._foods[left] = self._foods[left]._replace(lifted=False)
            return
        x = pose.x + _BETWEEN_FINGERS * math.cos(pose.heading)
        y = pose.y + _BETWEEN_FINGERS * math.sin(pose.heading)
        if number not in self._held:
            others = set(self._held.values())
            free = [k for k in range(len(self._foods)) if k not in others]
            if not free:
                return
            self._held[number] = min(free, key=lambda k: math.dist((x, y), self._foods[k][:2]))
        self._foods[self._held[number]] = FoodPlace(x, y, senses.arm < ARM_ON_FLOOR)
