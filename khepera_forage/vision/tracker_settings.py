"""Settings of the tracker: thresholds, sizes of markers and food, and patience with lost food."""

import math
from dataclasses import dataclass, fields

from khepera_forage.robots.khepera import FOOD_HEIGHT, FOOD_RADIUS, MARKER_LENGTH, MARKER_WIDTH
from khepera_forage.vision.shapes import HOLE_SIDE


@dataclass(frozen=True, slots=True)
class TrackerSettings:
    """Thresholds without a unit, sizes in mm on the floor.

    Raises:
        ValueError: A value that is not finite or out of its range; the message says which.
    """

    contrast: float = 1.4
    """Least brightness of a region's pixels, as a multiple of the floor's brightness around them. White paper on a
    floor of medium intensity (3.1) is about twice as bright."""
    hole_contrast: float = 0.7
    """Pixels of a marker darker than this share of its white belong to a hole. The threshold is above halfway to black,
    because blur brightens squares of four pixels."""
    tolerance: float = 0.3
    """Greatest relative error of a marker's length and width, and of food's diameter."""
    marker_length: float = MARKER_LENGTH
    """Long side of a marker, along the robot's heading (figure 3.9)."""
    marker_width: float = MARKER_WIDTH
    """Short side of a marker."""
    hole_side: float = HOLE_SIDE
    """Side of the black squares in a marker."""
    food_radius: float = FOOD_RADIUS
    """Radius of a food object (3.1)."""
    marker_height: float = 70.0
    """Height of a marker above the floor; used only by a calibration with the camera's position. Assumption."""
    food_height: float = FOOD_HEIGHT
    """Height of the top of a food object above the floor (3.1)."""
    patience: int = 3
    """Number of consecutive frames in which the floor must be visible where food was last seen, before the food is
    dropped."""
    featureless: bool = False
    """Whether tracks are continued by place alone instead of by number of holes and place (3.5)."""

    def __post_init__(self) -> None:
        for field in fields(self):
            value = getattr(self, field.name)
            if field.name != "featureless" and not 0 <= value < math.inf:
                raise ValueError(f"tracker {field.name} is {value!r}; allowed: a finite number >= 0")
        for name in ("marker_length", "marker_width", "hole_side", "food_radius"):
            if getattr(self, name) == 0:
                raise ValueError(f"tracker {name} is {getattr(self, name)!r}; allowed: above 0 mm")
        for name in ("hole_contrast", "tolerance"):
            if not 0 < getattr(self, name) < 1:
                raise ValueError(f"tracker {name} is {getattr(self, name)!r}; allowed: between 0 and 1")
        if self.contrast <= 1:
            raise ValueError(f"tracker contrast is {self.contrast!r}; allowed: above 1")
        if self.marker_length < 1.2 * self.marker_width:
            raise ValueError(
                f"tracker marker_length is {self.marker_length!r}; allowed: at least 1.2 times the marker_width of "
                f"{self.marker_width!r}, or the axis is uncertain"
            )
        if self.hole_side > 0.5 * self.marker_width:
            raise ValueError(
                f"tracker hole_side is {self.hole_side!r}; allowed: up to half the marker_width, "
                f"which is {self.marker_width!r}"
            )
        if self.patience < 1 or self.patience != int(self.patience):
            raise ValueError(f"tracker patience is {self.patience!r}; allowed: whole frames, at least 1")
