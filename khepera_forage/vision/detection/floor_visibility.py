"""Whether the floor shows where food was last seen: the rule by which lost food is dropped on real frames (3.5)."""

import math
from collections.abc import Sequence

import numpy as np

from khepera_forage.vision.association import GATE, Detection
from khepera_forage.vision.calibration import Calibration
from khepera_forage.vision.detection.segmentation import SHAPE, Bright
from khepera_forage.vision.scene import MM_PER_PIXEL, Region, Scene
from khepera_forage.vision.shapes import Plate, under_plate
from khepera_forage.vision.tracker_settings import TrackerSettings

_CLEAR = 13.0
"""mm that must lie between the disc of food and a marker: its black frame (8 mm), and a pixel of error."""
_LIKE = 0.25
"""Share of the floor's brightness by which a pixel of floor may differ from it: noise, dirt, shade."""
_ENOUGH = 0.6
"""Share of the disc's pixels that must look like floor: a cable across it hides less, a robot's body more."""
_WHITE = 0.1
"""Share of the disc's pixels that may be bright at most: more may be food, or a marker's rim over it."""


class FloorWatch:
    """Looks at the last places of lost food, frame by frame, and says when one is visible and empty.

    Args:
        settings: Sizes and patience.
        calibration: From the picture to the floor.
    """

    def __init__(self, settings: TrackerSettings, calibration: Calibration) -> None:
        self._settings, self._calibration = settings, calibration
        self._bright: Bright | None = None
        self._plates: list[Plate] = []
        self._empty: dict[tuple[float, float], int] = {}  # frames in which the floor has shown, by place
        self._before: dict[tuple[float, float], int] = {}

    def reset(self) -> None:
        """Forget every place."""
        self._empty, self._before = {}, {}

    def expose(self, bright: Bright, detections: Sequence[Detection], scene: Scene) -> None:
        """Take a frame.

        Args:
            bright: The frame.
            detections: What it shows.
            scene: All regions before it, of which a lost marker hides what is at its last place.
        """
        self._bright = bright
        self._before, self._empty = self._empty, {}
        shown = [d for d in detections if d.holes > 0]
        lost = [r for r in scene.regions if r.holes > 0 and not _shown(r, scene, shown)]
        self._plates = [_plate(d) for d in shown]
        if (
            not self._settings.featureless
        ):  # by place alone a lost region may have been anything, or has a new label
            self._plates += [_plate(r) for r in lost]

    def visible(self, x: float, y: float) -> bool:
        """Whether food at a place (region coordinates) would have shown, now and in the frames before.

        The same place asked for in `patience` frames one after the other must each time have shown the floor.
        """
        if not self._shows_floor(x, y):
            return False
        self._empty[x, y] = frames = self._before.get((x, y), 0) + 1
        return frames >= self._settings.patience

    def _shows_floor(self, x: float, y: float) -> bool:
        if self._bright is None:
            return False
        radius = self._settings.food_radius
        if under_plate(x * MM_PER_PIXEL, y * MM_PER_PIXEL, radius + _CLEAR, self._plates):
            return False
        u, v = self._calibration.to_picture(x, y, self._settings.food_height)
        unit = self._calibration.stretch(u, v, self._settings.food_height).area
        reach = radius / MM_PER_PIXEL / math.sqrt(unit)
        rows, columns = SHAPE
        if not (reach <= u <= columns - reach and reach <= v <= rows - reach):
            return False
        left, right = math.floor(u - reach), math.ceil(u + reach)
        top, bottom = math.floor(v - reach), math.ceil(v + reach)
        across = np.arange(left, right) + 0.5 - u
        down = np.arange(top, bottom)[:, None] + 0.5 - v
        disc = across**2 + down**2 <= reach * reach
        grey = self._bright.frame[top:bottom, left:right][disc].astype(np.float64)
        white = self._bright.mask[top:bottom, left:right][disc] > 0
        floor = self._bright.floor_at(math.floor(u), math.floor(v))
        like = np.abs(grey - floor) <= _LIKE * floor
        return bool(like.mean() >= _ENOUGH and white.mean() <= _WHITE)


def _plate(marker: Detection | Region) -> Plate:
    heading = math.radians(marker.orientation)
    return Plate(marker.x * MM_PER_PIXEL, marker.y * MM_PER_PIXEL, math.cos(heading), math.sin(heading))


def _shown(region: Region, scene: Scene, shown: Sequence[Detection]) -> bool:
    """Whether one of the markers of a frame is that of the last scene: any of its kind if there are enough of them."""
    same = [d for d in shown if d.holes == region.holes]
    return len(same) >= sum(r.holes == region.holes for r in scene.regions) or any(
        math.hypot(d.x - region.x, d.y - region.y) <= GATE for d in same
    )
