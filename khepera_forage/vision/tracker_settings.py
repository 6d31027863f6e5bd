"""Settings of the tracker: thresholds, sizes of markers and food, and patience with lost food."""

import math
from dataclasses import dataclass, fields
from typing import NoReturn

from khepera_forage.robots.khepera import FOOD_HEIGHT, FOOD_RADIUS

MARKER_NUMBERS = {"holes": range(1, 3), "grid": range(1, 13), "tags": range(1, 50)}
"""The numbers of the markers of each kind."""


@dataclass(frozen=True, slots=True)
class TrackerSettings:
    """Thresholds without a unit, sizes in mm on the floor.

    Raises:
        ValueError: A value that is not finite or out of its range; the message says which.
    """

    contrast: float = 1.4
    """Least brightness of a region's pixels, as a multiple of the floor's brightness around them. White paper on a
    floor of medium intensity (3.1) is about twice as bright."""
    tolerance: float = 0.3
    """Greatest relative error of a marker's length and width, and of food's diameter."""
    food_radius: float = FOOD_RADIUS
    """Radius of a food object (3.1)."""
    marker_height: float = 70.0
    """Height of a marker above the floor; used only by a calibration with the camera's position. Assumption."""
    food_height: float = FOOD_HEIGHT
    """Height of the top of a food object above the floor (3.1)."""
    patience: int = 3
    """Number of consecutive frames in which the floor must be visible where food was last seen, before the food is
    dropped."""
    markers: str = "holes"
    """What robots carry: "holes" (markers 1 and 2, with one and two holes), "grid" (markers 1 to 12, with 16 mm holes),
    or "tags" (ArUco tags, 4 x 4 cells)."""
    numbers: tuple[int, ...] = (1, 2)
    """The markers, or ids of tags, in use; a region's `holes` is this number. Any other is ignored."""
    food_tags: tuple[int, ...] = ()
    """Ids of the tags on food. Food without a tag is found as a white disc."""
    tag_size: float = 80.0
    """Side in mm of a robot's tag, with its black border."""
    food_tag_size: float = 24.0
    """Side in mm of a food object's tag."""
    featureless: bool = False
    """Whether tracks are continued by place alone instead of by number of holes and place (3.5)."""

    @property
    def tag_ids(self) -> tuple[int, ...]:
        """Ids of all tags on robots and food."""
        return (self.numbers if self.markers == "tags" else ()) + self.food_tags

    def __post_init__(self) -> None:
        for field in fields(self):
            value = getattr(self, field.name)
            if type(field.default) in (float, int) and not 0 <= value < math.inf:
                self._refuse(field.name, "a finite number >= 0")
        if self.markers not in MARKER_NUMBERS:
            self._refuse("markers", ", ".join(MARKER_NUMBERS))
        for name, kind in (("numbers", self.markers), ("food_tags", "tags")):
            given, ids = tuple(getattr(self, name)), MARKER_NUMBERS[kind]
            object.__setattr__(self, name, given)
            if len(set(given)) < len(given) or not all(type(n) is int and n in ids for n in given):
                raise ValueError(
                    f"tracker {name} is {list(given)}; allowed with markers {self.markers!r}: "
                    f"different whole numbers, {ids[0]} to {ids[-1]}"
                )
        if not self.numbers:
            raise ValueError("tracker numbers is []; allowed: at least one number")
        both = set(self.numbers) & set(self.food_tags)
        if self.markers == "tags" and both:
            raise ValueError(f"tracker food_tags has {min(both)}, as numbers; allowed: each tag once")
        for name, wrong, allowed in (
            *((size, getattr(self, size) == 0, "above 0 mm") for size in ("food_radius", "tag_size", "food_tag_size")),
            ("tolerance", not 0 < self.tolerance < 1, "between 0 and 1"),
            ("contrast", self.contrast <= 1, "above 1"),
            ("patience", self.patience < 1 or self.patience != int(self.patience), "whole frames, at least 1"),
        ):
            if wrong:
                self._refuse(name, allowed)

    def _refuse(self, name: str, allowed: str) -> NoReturn:
        raise ValueError(f"tracker {name} is {getattr(self, name)!r}; allowed: {allowed}")
