"""Whether the floor is visible where food was last seen: the condition for dropping lost food on real frames (3.5)."""

import math
from collections.abc import Sequence

import numpy as np

from khepera_forage.vision.association import GATE, Detection
from khepera_forage.vision.calibration import Calibration
from khepera_forage.vision.detection.segmentation import Segmentation
from khepera_forage.vision.scene import MM_PER_PIXEL, Region, Scene
from khepera_forage.vision.shapes import Plate, under_plate
from khepera_forage.vision.tracker_settings import TrackerSettings

_CLEARANCE = 13.0
"""Least distance in mm between the disc of food and a marker: the marker's black frame (8 mm), and a pixel of error."""
_FLOOR_TOLERANCE = 0.25
"""Share of the floor's brightness by which a pixel of floor may differ from it: noise, dirt, shade."""
_MIN_FLOOR_SHARE = 0.6
"""Least share of the disc's pixels that look like floor: a cable across the disc hides less, a robot's body more."""
_MAX_BRIGHT_SHARE = 0.1
"""Greatest share of bright pixels in the disc: more may be food, or a marker's rim over it."""


class FloorVisibility:
    """Counts, frame by frame, how long the floor has been visible at the last places of lost food.

    Args:
        settings: Sizes and patience.
        calibration: From the picture to the floor.
    """

    def __init__(self, settings: TrackerSettings, calibration: Calibration) -> None:
        self._settings, self._calibration = settings, calibration
        self._segmentation: Segmentation | None = None
        self._markers: list[Plate] = []
        # Number of consecutive frames in which the floor was visible, by place.
        self._counts: dict[tuple[float, float], int] = {}
        self._counts_before: dict[tuple[float, float], int] = {}

    def reset(self) -> None:
        """Forget every place."""
        self._counts, self._counts_before = {}, {}

    def update(self, segmentation: Segmentation, detections: Sequence[Detection], scene: Scene) -> None:
        """Use a new frame.

        Args:
            segmentation: Of the frame.
            detections: In the frame.
            scene: All regions before the frame; a lost marker among them hides its last place.
        """
        self._segmentation = segmentation
        self._counts_before, self._counts = self._counts, {}
        found = [d for d in detections if d.holes > 0]
        lost = [r for r in scene.regions if r.holes > 0 and not _is_found(r, scene, found)]
        self._markers = [_marker_pose(d) for d in found]
        # In featureless tracking a lost region may have been anything, or may have a new label.
        if not self._settings.featureless:
            self._markers += [_marker_pose(r) for r in lost]

    def visible(self, x: float, y: float) -> bool:
        """Whether the floor is visible at a place (region coordinates), now and in the last `patience` frames.

        Call this once per frame and place: the frames of a place are counted by these calls.
        """
        if not self._shows_floor(x, y):
            return False
        self._counts[x, y] = count = self._counts_before.get((x, y), 0) + 1
        return count >= self._settings.patience

    def _shows_floor(self, x: float, y: float) -> bool:
        """Whether the disc of food at this place shows the floor in the newest frame."""
        if self._segmentation is None:
            return False
        radius = self._settings.food_radius
        if under_plate(x * MM_PER_PIXEL, y * MM_PER_PIXEL, radius + _CLEARANCE, self._markers):
            return False
        u, v = self._calibration.to_picture(x, y, self._settings.food_height)
        unit = self._calibration.jacobian(u, v, self._settings.food_height).area
        reach = radius / MM_PER_PIXEL / math.sqrt(unit)
        rows, columns = self._segmentation.frame.shape
        if not (reach <= u <= columns - reach and reach <= v <= rows - reach):
            return False
        left, right = math.floor(u - reach), math.ceil(u + reach)
        top, bottom = math.floor(v - reach), math.ceil(v + reach)
        across = np.arange(left, right) + 0.5 - u
        down = np.arange(top, bottom)[:, None] + 0.5 - v
        disc = across**2 + down**2 <= reach * reach
        grey = self._segmentation.frame[top:bottom, left:right][disc].astype(np.float64)
        bright = self._segmentation.mask[top:bottom, left:right][disc] > 0
        floor = self._segmentation.floor_at(math.floor(u), math.floor(v))
        like_floor = np.abs(grey - floor) <= _FLOOR_TOLERANCE * floor
        return bool(like_floor.mean() >= _MIN_FLOOR_SHARE and bright.mean() <= _MAX_BRIGHT_SHARE)


def _marker_pose(marker: Detection | Region) -> Plate:
    heading = math.radians(marker.orientation)
    return Plate(marker.x * MM_PER_PIXEL, marker.y * MM_PER_PIXEL, math.cos(heading), math.sin(heading))


def _is_found(region: Region, scene: Scene, markers: Sequence[Detection]) -> bool:
    """Whether a detected marker can be this region of the last scene.

    Any marker with the same number of holes can be, if the frame shows all of them; otherwise only one within `GATE`.
    """
    same = [d for d in markers if d.holes == region.holes]
    return len(same) >= sum(r.holes == region.holes for r in scene.regions) or any(
        math.hypot(d.x - region.x, d.y - region.y) <= GATE for d in same
    )
