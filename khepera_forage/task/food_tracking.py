"""What becomes of the food: drawn types, deliveries, and which regions are still candidates.

The camera knows regions, not objects; a region that was carried away is dropped, and what is set down elsewhere
is a new one. The register ties the labels of regions to the food objects of an arena, through the gripper.
"""

import math
from collections.abc import Sequence

import numpy as np

from khepera_forage.robots.khepera import BARRIER, Motors, Senses
from khepera_forage.task.identification import at_home, drawn_type, explored
from khepera_forage.task.perception import Site, within
from khepera_forage.task.states import FoodType
from khepera_forage.vision.scene import MM_PER_PIXEL, Region, Scene

_GRIPPER = (BARRIER + 5.0) / MM_PER_PIXEL
"""Pixels from a robot's centre to food in its gripper."""


class FoodTypes:
    """The types of the food objects: drawn when an object is first identified, and known from then on.

    Corresponding food of paired arenas shares one draw: what the teacher has identified, the learner knows too.

    Args:
        count: Number of food objects in each arena.
        odds: Odds of PICKABLE, PUSHABLE and POISONOUS.
        rng: Their own generator.

    Attributes:
        known: Type of each object as far as it is identified.
    """

    def __init__(self, count: int, odds: tuple[float, float, float], rng: np.random.Generator) -> None:
        # All uniform numbers are taken at once: which object is identified first changes no type.
        self._types = [drawn_type(float(u), odds[0], odds[1]) for u in rng.random(count)]
        self.known = [FoodType.UNKNOWN] * count

    def identify(self, index: int) -> None:
        """From now on the type of this object is known."""
        self.known[index] = self._types[index]


class FoodRegister:
    """The food of one arena, and the one robot that forages there.

    Args:
        site: The arena.
        places: Where each food object lies at first, in pixels.
        types: Shared by corresponding arenas.

    Attributes:
        delivered: Whether each object has been brought home.
        settled: Labels of regions that are no candidates for nearest food.
        delivered_food: Objects brought home that are not poisonous.
        poison_home: Poisonous objects brought home.
        deliverable: Objects that are not known to be poisonous.
    """

    def __init__(self, site: Site, places: Sequence[tuple[float, float]], types: FoodTypes) -> None:
        self._site = site
        self._types = types
        self._places = list(places)
        self._objects: dict[int, int] = {}
        self._held: int | None = None
        # Objects that were in the gripper since they were last seen: they may turn up under another label.
        self._carried: set[int] = set()
        self.delivered = [False] * len(places)
        self.settled: set[int] = set()
        self._told: object = None
        self.delivered_food = self.poison_home = 0
        self.deliverable = len(places)

    @property
    def known(self) -> list[FoodType]:
        """Type of each object as far as it is identified."""
        return self._types.known

    @property
    def type_in_gripper(self) -> FoodType:
        """Type of the object in the gripper; UNKNOWN without one or before it is identified."""
        return FoodType.UNKNOWN if self._held is None else self.known[self._held]

    @property
    def collected(self) -> list[bool]:
        """Whether each object has been brought home and is not poisonous."""
        return [d and k != FoodType.POISONOUS for d, k in zip(self.delivered, self.known, strict=True)]

    @property
    def finished(self) -> bool:
        """Whether every object is delivered or known to be poisonous."""
        return self.delivered_food == self.deliverable

    def _count(self) -> None:
        poisonous = [k == FoodType.POISONOUS for k in self.known]
        self.delivered_food = sum(self.collected)
        self.poison_home = sum(d and p for d, p in zip(self.delivered, poisonous, strict=True))
        self.deliverable = len(poisonous) - sum(poisonous)
        self.settled = {
            label
            for label, k in self._objects.items()
            if self.delivered[k] or (poisonous[k] and k != self._held)
        }

    def object_of(self, label: int) -> int | None:
        """Number of the food object that a region shows, if it is tied to one."""
        return self._objects.get(label)

    def update(self, scene: Scene, own: Region, before: Senses, after: Senses, applied: Motors) -> None:
        """Take in what one round has brought.

        Args:
            scene: What the camera reports now.
            own: The robot's own marker.
            before: What the robot sensed when the round began.
            after: What it senses now.
            applied: What its motors did in between.
        """
        if after.object_presence:
            heading = math.radians(own.orientation)
            gripper = own.x + _GRIPPER * math.cos(heading), own.y + _GRIPPER * math.sin(heading)
            if self._held is None:
                self._held = self._nearest(gripper, range(len(self._places)))
            self._places[self._held] = gripper
            self._carried.add(self._held)
            if self.known[self._held] == FoodType.UNKNOWN and explored(before, after, applied):
                self._types.identify(self._held)
        else:
            self._held = None
        self._tie(scene)
        if (self._held, self.known, self.delivered, self._objects) != self._told:
            self._told = self._held, self.known[:], self.delivered[:], self._objects.copy()
            self._count()

    def _tie(self, scene: Scene) -> None:
        """Tie new regions to objects, follow them, and see which lie at home."""
        site = self._site
        labels = self._objects
        live = set()
        for region in scene.regions:
            if region.holes or not within(region, site):
                continue
            live.add(region.label)
            if not region.found:
                continue
            if region.label not in labels:
                tied = {labels[r.label] for r in scene.regions if r.label in labels} - self._carried
                free = [k for k in range(len(self._places)) if k not in tied]
                if not free:
                    continue
                labels[region.label] = self._nearest((region.x, region.y), free)
            k = labels[region.label]
            if k == self._held:
                continue
            self._carried.discard(k)
            self._places[k] = region.x, region.y
            if not self.delivered[k] and at_home(
                region.x, region.y, site.home_x, site.home_y, site.home_radius
            ):
                self.delivered[k] = True
                self._types.identify(k)
        for label in labels.keys() - live:
            del labels[label]

    def _nearest(self, place: tuple[float, float], objects: Sequence[int]) -> int:
        return min(objects, key=lambda k: math.dist(place, self._places[k]))
