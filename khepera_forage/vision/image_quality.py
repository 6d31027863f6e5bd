"""Quality of the camera's picture: contrast, exposure, sharpness and noise; and frames that show no scene at all.

The tracker fails without a warning when one of them is beyond its limit: nothing is then bright enough, or of the right
size, to be a region. These figures are therefore measured without the tracker, from all bright shapes.
"""

import math
from statistics import NormalDist
from typing import TYPE_CHECKING, Any, NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from khepera_forage.robots.khepera import FOOD_RADIUS, MARKER_LENGTH, MARKER_WIDTH
from khepera_forage.vision.scene import MM_PER_PIXEL
from khepera_forage.vision.segmentation import ImagePatch, cut_patch, filled_area, outer_contours, segment
from khepera_forage.vision.tracker_settings import TrackerSettings
from khepera_forage.vision.video import Frame, as_grey

if TYPE_CHECKING:
    from khepera_forage.vision.tracker import Tracker

BLUR_LIMIT = 1.3
"""Pixels, standard deviation. docs/tracker/tracker.md shows the losses above it."""
NOISE_LIMIT = 12.0
"""Grey levels, standard deviation. The same page shows the losses above it."""
PRINT_LIMIT = 0.6
"""Brightness of holes as a share of white. Holes above 0.7 are not read."""
FLOOR_LIMITS = (20.0, 160.0)
"""Grey levels of the floor. Below, noise and black cannot be told from it; above, white saturates and grows."""
_CONTRAST_RESERVE = 1.2
"""Least ratio of the measured contrast to the tracker's: light varies from place to place and minute to minute."""
_FAINT = 1.15
"""Contrast from which a shape is measured, less than the tracker's."""
_SIZES = (0.4 * math.pi * FOOD_RADIUS**2 / MM_PER_PIXEL**2, 3 * MARKER_LENGTH * MARKER_WIDTH / MM_PER_PIXEL**2)
"""Least and greatest number of pixels of a shape that is measured: food to two markers that touch."""
_WHITE_QUANTILE, _EDGE_QUANTILE = 90, 95
_MARKER_SIZE = 0.5 * MARKER_LENGTH * MARKER_WIDTH / MM_PER_PIXEL**2
_HOLE_QUANTILE, _LEAST_HOLE = 1, 0.9
"""Percentile of the pixels inside a marker that is the grey level of its holes; and its share of white, above
which it has none."""
_SIMILAR = 0.85
"""Share of the highest contrast from which a shape counts as white."""
_REDUCTION, _LEAST_RANGE = 4, 20
"""Pixels are averaged in squares of this side: less noise, and markers and food remain. And the grey levels between the
darkest and the brightest square of a scene with a marker or food, which is white."""


class ImageQuality(NamedTuple):
    """Measured figures of one frame.

    Attributes:
        floor: Median grey level of the floor.
        noise: Standard deviation of the noise of single pixels, grey levels.
        contrast: Brightness of white shapes as a multiple of the floor's around them; None without white shapes.
        blur: Standard deviation in pixels of the blur of their borders; None without white shapes.
        print: Brightness of the holes in markers as a share of their white; None without holes.
    """

    floor: float
    noise: float
    contrast: float | None
    blur: float | None
    print: float | None = None

    def described(self, settings: TrackerSettings) -> str:
        """All figures with their limits, in one line."""

        def known(value: float | None, form: str, unit: str = "") -> str:
            return "unknown" if value is None else f"{value:{form}}{unit}"

        low, high = FLOOR_LIMITS
        return (
            f"contrast {known(self.contrast, '.2f')} (at least {settings.contrast * _CONTRAST_RESERVE:.2f}), "
            f"blur {known(self.blur, '.1f', ' px')} (at most {BLUR_LIMIT:g}), "
            f"floor {self.floor:.0f} ({low:g} to {high:g}), "
            f"noise {self.noise:.1f} (at most {NOISE_LIMIT:g}), "
            f"print {known(self.print, '.2f')} (at most {PRINT_LIMIT:g})"
        )

    def warnings(self, settings: TrackerSettings) -> dict[str, str]:
        """What is beyond its limit, and what to change, by the name of the figure."""
        found = {}
        low, high = FLOOR_LIMITS
        level = f"the floor's grey level is {self.floor:.0f} of 255, allowed: "
        if self.floor > high:
            found["exposure"] = f"overexposed: {level}up to {high:g}; reduce the camera's exposure or gain"
        elif self.floor < low:
            found["exposure"] = f"underexposed: {level}from {low:g}; increase the camera's exposure or gain"
        elif self.contrast is not None and self.contrast < settings.contrast * _CONTRAST_RESERVE:
            found["contrast"] = (
                f"low contrast: white is {self.contrast:.2f} times as bright as the floor, and the tracker's contrast "
                f"is {settings.contrast:g}; set it to {(1 + self.contrast) / 2:.2f}, or use a darker floor"
            )
        if self.blur is not None and self.blur > BLUR_LIMIT:
            found["blur"] = (
                f"out of focus: the blur is {self.blur:.1f} pixels, allowed: up to {BLUR_LIMIT:g}; focus the lens"
            )
        elif self.print is not None and self.print > PRINT_LIMIT:
            found["print"] = (
                f"pale print: holes are {self.print:.2f} times as bright as white, allowed: up to {PRINT_LIMIT:g}; "
                "print the markers black"
            )
        if self.noise > NOISE_LIMIT:
            found["noise"] = (
                f"noisy: the noise is {self.noise:.0f} grey levels, allowed: up to {NOISE_LIMIT:g}; use more light, "
                "and less gain"
            )
        return found


def measure_quality(frame: Frame) -> ImageQuality:
    """The quality of one frame; takes about as long as tracking it.

    Args:
        frame: Grey levels, or colours, with about 5 mm a pixel, as `Tracker.reduced` makes them.

    Raises:
        ValueError: A frame of another type.
    """
    frame = as_grey(frame)
    segmentation = segment(frame, _FAINT)
    shapes: list[tuple[float, float]] = []
    prints: list[float] = []
    for contour in outer_contours(segmentation.mask):
        if filled_area(contour) < _SIZES[0]:
            continue
        patch = cut_patch(segmentation, contour)
        inside = (patch.filled & patch.white) > 0
        area = np.count_nonzero(inside)
        if _SIZES[0] <= area <= _SIZES[1]:
            shapes.append(white_and_blur(patch.grey, inside, max(patch.floor, 1)))
            if area >= _MARKER_SIZE:
                prints += _prints(patch)
    highest = max((contrast for contrast, _ in shapes), default=0.0)
    white = [shape for shape in shapes if shape[0] >= _SIMILAR * highest]
    return ImageQuality(
        float(np.median(segmentation.floor)),
        _noise(frame),
        float(np.median([contrast for contrast, _ in white])) if white else None,
        float(np.median([blur for _, blur in white])) if white else None,
        float(np.median(prints)) if prints else None,
    )


def _prints(patch: ImagePatch) -> list[float]:
    """Brightness of the holes in a white shape as a share of its white: one number, or none without holes."""
    white = _percentile(patch.grey[(patch.filled & patch.white) > 0], _WHITE_QUANTILE)
    inner = patch.grey[cv2.erode(patch.filled, np.ones((5, 5), np.uint8)) > 0]
    if not inner.size:
        return []
    darkest = _percentile(inner, _HOLE_QUANTILE)
    return [darkest / white] if darkest < _LEAST_HOLE * white else []


def white_and_blur(grey: Frame, inside: NDArray[np.bool_], floor: float) -> tuple[float, float]:
    """Brightness of a bright shape as a multiple of the floor's, and the blur of its border in pixels."""
    white = _percentile(grey[inside], _WHITE_QUANTILE)
    levels = grey.astype(np.float32)
    steepness = np.hypot(cv2.Sobel(levels, cv2.CV_32F, 1, 0, ksize=1), cv2.Sobel(levels, cv2.CV_32F, 0, 1, ksize=1)) / 2
    window = np.ones((9, 9), np.uint8)
    heights = cv2.dilate(levels, window) - cv2.erode(levels, window)
    border = heights > 0.6 * heights.max()
    # The difference between the neighbours of a pixel in the middle of a blurred step is 2 F(1 / blur) - 1 of the step.
    share = _percentile(steepness[border] / heights[border], _EDGE_QUANTILE)
    return white / floor, 1 / NormalDist().inv_cdf(min(0.5 + share, 0.9999))


def _percentile(values: NDArray[Any], percent: int) -> float:
    # Several times faster than numpy's, which interpolates.
    rank = percent * (values.size - 1) // 100
    return float(np.partition(values, rank)[rank])


def _noise(frame: Frame) -> float:
    """Standard deviation of the noise of single pixels, from second differences: light and texture have small ones."""
    levels = frame[::4].astype(np.float32)
    differences = levels[:, 2:] - 2 * levels[:, 1:-1] + levels[:, :-2]
    return float(np.median(np.abs(differences)) / (0.6745 * math.sqrt(6)))


def is_well_exposed(frame: Frame) -> bool:
    """Whether the grey level of the floor is within its limits."""
    low, high = FLOOR_LIMITS
    return bool(low <= np.median(frame[::_REDUCTION, ::_REDUCTION]) <= high)


def why_unusable(frame: Frame, tracker: "Tracker", strict: bool) -> str:
    """Why a frame (grey levels) shows no scene, and what to change; empty for a usable frame.

    When `strict`, a frame beyond the limits of exposure is unusable, as it is after a sudden change: food may be
    invisible. Otherwise it is usable if the tracker finds a marker in it.
    """
    rows, columns = frame.shape
    squares = cv2.resize(frame, (columns // _REDUCTION, rows // _REDUCTION), interpolation=cv2.INTER_AREA)
    darkest, brightest = int(squares.min()), int(squares.max())
    if brightest - darkest < _LEAST_RANGE:
        return f"shows nothing: all grey levels are {darkest} to {brightest}"
    if is_well_exposed(frame) or (not strict and any(found.holes for found in tracker.detect(frame))):
        return ""
    warning = measure_quality(tracker.reduced(frame)).warnings(tracker.settings).get("exposure", "")
    return warning and f"is {warning}"
