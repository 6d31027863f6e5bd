"""Robots' markers: from a bright shape to pose and number of holes (figures 3.8, 3.9)."""

import math
from typing import NamedTuple

import numpy as np

from khepera_forage.vision.calibration import Calibration
from khepera_forage.vision.detection.hole_detector import SAMPLE, HoleReader
from khepera_forage.vision.detection.image_patch import Form, Patch, form, weighed
from khepera_forage.vision.detection.segmentation import Frame
from khepera_forage.vision.scene import MM_PER_PIXEL
from khepera_forage.vision.shapes import PICTURE_HEIGHT, PICTURE_WIDTH
from khepera_forage.vision.tracker_settings import TrackerSettings

_AHEAD = 5.0
"""mm by which the holes must lie ahead of the middle to tell front from back."""
_SQUARE = np.ones((3, 3), np.uint8)
_DOUBT = 6.0
"""mm on either side of its expected border within which a marker's true border is looked for."""
_TURNS = 4
"""How often at most a marker's border is looked for anew around where it was found the last time."""
_SETTLED = 0.02
"""Radians, or shares of a marker's size, below which the next turn would bring nothing."""
_WHOLE = 0.8
"""Share of a marker's area that must be seen in one piece: with one side cut off, its centre is not known."""
_CUT = 1.0
"""Pixels by which a corner may lie outside the picture."""
_FULL = 0.7
"""Share of the rectangle with the same moments that a marker fills at least."""
_NECK = 1.3
"""Times food's diameter: what sticks out from a marker and is narrower than this is not part of it."""


class MarkerSeen(NamedTuple):
    """A marker in a frame.

    Attributes:
        form: Its centre and axes.
        heading: Radians.
        sure: Whether the holes tell front from back; if not, `heading` may be the wrong way round.
        holes: Their number.
        holes_area: In square region pixels.
        shape: 255 within the marker, of the patch's size.
    """

    form: Form
    heading: float
    sure: bool
    holes: int
    holes_area: float
    shape: Frame


class MarkerFinder:
    """Tells a marker from everything else, and reads its pose and holes.

    Args:
        settings: Sizes and tolerances.
        calibration: From the picture to the floor.
        scale: Pixels of the picture in a mm, about.
    """

    def __init__(self, settings: TrackerSettings, calibration: Calibration, scale: float) -> None:
        import cv2

        self._settings, self._calibration = settings, calibration
        neck = max(3, round(_NECK * 2 * settings.food_radius * scale))
        self._disc = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (neck, neck))
        # Standard deviations of a rectangle are its sides over the root of 12.
        self._major = settings.marker_length / MM_PER_PIXEL / math.sqrt(12)
        self._minor = settings.marker_width / MM_PER_PIXEL / math.sqrt(12)
        self._area = settings.marker_length * settings.marker_width / MM_PER_PIXEL**2
        self._holes = HoleReader(settings)

    def find(self, patch: Patch) -> MarkerSeen | None:
        """The marker that a patch shows.

        Returns:
            None if it shows something else, or a marker so disturbed that its pose or number of holes is in doubt.
        """
        import cv2

        # Holes are filled, notches closed; what is narrower than the disc (food under the rim, a cable) falls away.
        whole = cv2.morphologyEx(patch.filled, cv2.MORPH_CLOSE, _SQUARE)
        shape: Frame = cv2.morphologyEx(whole, cv2.MORPH_OPEN, self._disc)  # type: ignore[assignment]
        seen = form(patch, shape, self._calibration, self._settings.marker_height)
        if seen is None or not self._sized(seen):
            return None
        seen = self._refined(patch, seen)
        if seen is None or (patch.edge and self._cut(seen)):
            return None
        found = self._holes.read(self._upright(patch, seen), seen.level)
        if found is None:
            return None
        holes, ahead, area = found
        heading = seen.axis if ahead >= 0 else seen.axis + math.pi
        return MarkerSeen(seen, heading, abs(ahead) >= _AHEAD, holes, area, shape)

    def _sized(self, seen: Form) -> bool:
        tolerance = self._settings.tolerance
        return (
            seen.area >= _WHOLE * self._area
            and seen.area >= _FULL * 12 * seen.major * seen.minor
            and abs(seen.major / self._major - 1) <= tolerance
            and abs(seen.minor / self._minor - 1) <= tolerance
        )

    def _refined(self, patch: Patch, seen: Form) -> Form | None:
        """The same once more, now that it is known where the marker's own border must run, corners and all.

        The first look may be off by ten degrees when food has run into the shape: then it takes a few turns.
        """
        for _ in range(_TURNS):
            inside, around = (self._sheet(patch, seen, grown) for grown in (-_DOUBT, _DOUBT))
            better = weighed(patch, inside, around, self._calibration, self._settings.marker_height)
            if better is None:
                return None
            turned = abs(math.remainder(better.axis - seen.axis, math.pi))
            settled = (
                turned < _SETTLED
                and math.hypot(better.x - seen.x, better.y - seen.y) < _SETTLED * self._major
            )
            seen = better
            if settled:
                break
        return seen

    def _corners(self, seen: Form, grown: float) -> list[tuple[float, float]]:
        """Corners in the picture of a marker of that pose that is larger all round by so many mm."""
        along, across = self._steps(seen, 1.0)
        length, width = self._settings.marker_length / 2 + grown, self._settings.marker_width / 2 + grown
        return [
            (
                seen.u + a * length * along[0] + b * width * across[0],
                seen.v + a * length * along[1] + b * width * across[1],
            )
            for a, b in ((1, 1), (-1, 1), (-1, -1), (1, -1))
        ]

    def _cut(self, seen: Form) -> bool:
        """Whether the picture's edge cuts off so much of a marker that it would be seen shifted and turned."""
        return not all(
            -_CUT <= u <= PICTURE_WIDTH + _CUT and -_CUT <= v <= PICTURE_HEIGHT + _CUT
            for u, v in self._corners(seen, 0.0)
        )

    def _sheet(self, patch: Patch, seen: Form, grown: float) -> Frame:
        """255 within a marker of that pose that is larger all round by so many mm."""
        import cv2

        corners = [(u - 0.5 - patch.column, v - 0.5 - patch.row) for u, v in self._corners(seen, grown)]
        sheet = np.zeros_like(patch.filled)
        cv2.fillConvexPoly(sheet, np.rint(np.multiply(corners, 16)).astype(np.int32), 255, cv2.LINE_8, 4)
        return sheet

    def _steps(self, seen: Form, step: float) -> tuple[tuple[float, float], tuple[float, float]]:
        """One step of so many mm along the marker and one to its left, in pixels of the picture."""
        xu, xv, yu, yv = self._calibration.stretch(seen.u, seen.v, self._settings.marker_height)
        step /= MM_PER_PIXEL * (xu * yv - xv * yu)  # through the inverse of the stretch
        cos, sin = math.cos(seen.axis) * step, math.sin(seen.axis) * step
        return (yv * cos - xv * sin, xu * sin - yu * cos), (-yv * sin - xv * cos, xu * cos + yu * sin)

    def _upright(self, patch: Patch, seen: Form) -> Frame:
        """The marker turned upright, one sample for 2.5 mm: column 0 at one end of it, row 0 at its right side."""
        import cv2

        along, across = self._steps(seen, SAMPLE)
        middle = ((self._holes.columns - 1) / 2, (self._holes.rows - 1) / 2)
        start_u = seen.u - 0.5 - patch.column - along[0] * middle[0] - across[0] * middle[1]
        start_v = seen.v - 0.5 - patch.row - along[1] * middle[0] - across[1] * middle[1]
        turn = np.array([[along[0], across[0], start_u], [along[1], across[1], start_v]])
        flags = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
        return cv2.warpAffine(patch.grey, turn, (self._holes.columns, self._holes.rows), flags=flags)  # type: ignore[return-value]
