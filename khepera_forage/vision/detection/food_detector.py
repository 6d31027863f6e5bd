"""Food: from a bright shape to the discs that it consists of."""

import math
from collections.abc import Iterator

import cv2
import numpy as np
from numpy.typing import NDArray

from khepera_forage.vision.calibration import Calibration
from khepera_forage.vision.detection.segmentation import Frame, ImagePatch, ShapeMoments, shape_moments
from khepera_forage.vision.image_quality import white_and_blur
from khepera_forage.vision.scene import MM_PER_PIXEL
from khepera_forage.vision.tracker_settings import TrackerSettings

_MIN_FILL = 0.7
"""Least share of the ellipse with the same moments that food fills; the end of a kinked cable fills less."""
_AREA = (0.8, 1.7)
"""Least and greatest area of a whole disc, as shares of food's true area: a half hidden disc has no known centre, and
overexposed white grows."""
_MAX_EROSIONS = 3
"""Greatest number of erosions by one pixel to separate touching discs."""
_SOFTNESS, _SPREAD = 1.25, 0.2
"""Greatest blur of food's border in pixels: this times that of markers' borders, and a spread."""
_NOT_SATURATED, _SATURATED = 240.0, 0.1
"""Grey level of white below which it is not saturated; and the share of a disc that is saturated in a reflection."""
_CROSS = np.array([[0, 1, 0], [1, 1, 1], [0, 1, 0]], np.uint8)
_ROUND = 0.98
"""Ratio of the axes from which a shape is taken for a whole disc: at most 1 % of it is then hidden."""
_STEP, _REACH = 0.25, 2.0
"""Region pixels from one sample of a ray to the next, and between the radius and either end of a ray."""
_HIDDEN = 0.12
"""Region pixels by which the shape ends before the disc's rim where something hides it."""
_RAYS, _LEAST_RAYS, _REPEATS = 36, 15, 8
"""Rays, and rays to the visible rim from which the centre is known."""
_ANGLES = 2 * math.pi * np.arange(_RAYS) / _RAYS
_DIRECTIONS = np.stack((np.cos(_ANGLES), np.sin(_ANGLES)), axis=1)
_TERMS = np.column_stack((_DIRECTIONS, np.ones(_RAYS)))
"""How the edge along each ray changes with a shift of the centre, to first order, and with the radius, which blur and
brightness change a little."""


class FoodDetector:
    """Distinguishes food from other bright shapes."""

    def __init__(self, settings: TrackerSettings, calibration: Calibration) -> None:
        self._calibration, self._tolerance = calibration, settings.tolerance
        self._height, self._radius = settings.food_height, settings.food_radius / MM_PER_PIXEL
        self._area = math.pi * self._radius**2

    def trouble(self, patch: ImagePatch, food: ShapeMoments, white: float, blur: float) -> str:
        """Why a disc may be a reflection on the floor: a key of `detector.TROUBLES`; empty if it is none.

        A reflection that is as large as food has a softer border than the lens's blur (pixels) makes, or it is brighter
        than white, which is a multiple of the floor's brightness; 0 if it is unknown.
        """
        if 0 < white * patch.floor < _NOT_SATURATED:
            unit = self._calibration.jacobian(food.u, food.v, self._height).area
            saturated = np.count_nonzero((patch.grey == 255) & (patch.filled > 0)) * unit
            if saturated > _SATURATED * self._area:
                return "bright food"
        _, softness = white_and_blur(patch.grey, patch.filled > 0, max(patch.floor, 1))
        return "reflection" if softness > _SOFTNESS * blur + _SPREAD else ""

    def detect(self, patch: ImagePatch, rim: bool = False) -> ShapeMoments | None:
        """The one food object in a patch; None for anything else, or for part of a food object.

        If the shape has lost or won a part, the centre of the disc follows from the `rim` alone.
        """
        moments = self._disc(patch, patch.filled)
        if moments is None or (moments.minor >= _ROUND * moments.major and not rim):
            return moments
        return self._with_true_centre(patch, moments)

    def split(self, patch: ImagePatch) -> Iterator[tuple[ShapeMoments, Frame]]:
        """The touching food objects in a patch, each with its own mask."""
        # The darker border pixels lower this mean, which helps to separate the discs.
        cores = patch.filled & (patch.grey > cv2.mean(patch.grey, patch.filled)[0])
        for _ in range(_MAX_EROSIONS):
            count, labels = cv2.connectedComponents(cores)
            if count > 2:
                break
            cores = cv2.erode(cores, _CROSS)  # type: ignore[assignment]
        else:
            return
        # Each pixel belongs to the nearest core: the border between two touching discs is then straight.
        distances = [
            cv2.distanceTransform((labels != i).astype(np.uint8), cv2.DIST_L2, 5) for i in range(1, count)
        ]
        nearest = np.argmin(distances, axis=0)
        for i in range(count - 1):
            mask = np.where(nearest == i, patch.filled, np.uint8(0))
            moments = self._disc(patch, mask)
            if moments is not None:
                yield moments, mask

    def _disc(self, patch: ImagePatch, mask: Frame) -> ShapeMoments | None:
        """Moments of a shape of food's size."""
        moments = shape_moments(patch, mask, self._calibration, self._height)
        if moments is None or not _AREA[0] * self._area <= moments.area <= _AREA[1] * self._area:
            return None
        if moments.area < _MIN_FILL * 4 * math.pi * moments.major * moments.minor:
            return None
        # The standard deviation of a disc along any axis is half its radius.
        ratios = (deviation * 2 / self._radius for deviation in (moments.major, moments.minor))
        return moments if all(abs(ratio - 1) <= self._tolerance for ratio in ratios) else None

    def _with_true_centre(self, patch: ImagePatch, moments: ShapeMoments) -> ShapeMoments:
        """The moments of a partly hidden disc with the centre of the whole disc, if enough of the rim is visible.

        What hides a part, such as the black frame of a marker, shifts the centre of the rest. Rays from there find the
        edge of the shape in all directions; the rim is a circle through the edge, without the points that lie inside.
        """
        jacobian = self._calibration.jacobian(moments.u, moments.v, self._height)
        inverse = np.linalg.inv(np.array(jacobian).reshape(2, 2))
        edges = self._edges(patch, moments, inverse)
        visible = np.isfinite(edges)
        shift = np.zeros(3)
        for _ in range(_REPEATS):
            if visible.sum() < _LEAST_RAYS:
                return moments
            shift = np.linalg.lstsq(_TERMS[visible], edges[visible] - self._radius, rcond=None)[0]
            residuals = edges - self._radius - _TERMS @ shift
            # A quarter of the rays at a time, because the hidden part of the rim has shifted the circle, too.
            worst = np.quantile(residuals[visible], 0.25)
            hidden = visible & (residuals < -_HIDDEN) & (residuals <= worst)
            if not hidden.any():
                break
            visible &= ~hidden
        u, v = (np.array(moments[:2]) + inverse @ shift[:2]).tolist()
        x, y = self._calibration.to_region(u, v, self._height)
        return moments._replace(u=u, v=v, x=x, y=y)

    def _edges(
        self, patch: ImagePatch, moments: ShapeMoments, to_picture: NDArray[np.float64]
    ) -> NDArray[np.float64]:
        """Distance from the centre to the edge of the shape along each ray, region pixels; nan without edge."""
        along = np.arange(max(0.0, self._radius - _REACH), self._radius + _REACH, _STEP)
        steps = _DIRECTIONS @ to_picture.T
        columns = moments.u - patch.column - 0.5 + steps[:, :1] * along
        rows = moments.v - patch.row - 0.5 + steps[:, 1:] * along
        grey = cv2.remap(
            patch.grey.astype(np.float32),
            columns.astype(np.float32),
            rows.astype(np.float32),
            cv2.INTER_LINEAR,
            borderMode=cv2.BORDER_REPLICATE,
        )
        middle = (moments.level + patch.floor) / 2
        first = (grey < middle).argmax(axis=1)
        rays = np.arange(_RAYS)
        inner, outer = grey[rays, np.maximum(first - 1, 0)], grey[rays, first]
        with np.errstate(divide="ignore", invalid="ignore"):
            edges = along[first] - _STEP * (middle - outer) / (inner - outer)
        return np.where(first > 0, edges, np.nan).astype(np.float64)
