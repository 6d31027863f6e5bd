"""The holes of a marker that cables cross: the known arrangement of holes that fits what is still visible."""

import math

import numpy as np
from numpy.typing import NDArray

from khepera_forage.robots.khepera import MARKER_LENGTH
from khepera_forage.vision.detection.cable_bands import ClearedMarker
from khepera_forage.vision.detection.hole_detector import SAMPLE, Holes
from khepera_forage.vision.scene import MM_PER_PIXEL
from khepera_forage.vision.shapes import MARKER_HOLES
from khepera_forage.vision.tracker_settings import TrackerSettings

_BLURS = (0.8, 1.2, 1.7)
"""Standard deviations in region pixels of the blur of a hole's border, from a sharp lens to a soft one."""
_AROUND = 0.02
"""Darkness of any arrangement from which a sample counts: cables elsewhere do not matter."""
_BLACK = 0.85
"""Darkness of a hole."""
_MARGIN, _RATIO = 0.06, 0.55
"""Least difference between the misfits of the best two arrangements, in whole holes, and their greatest ratio: beyond,
the arrangement is uncertain."""
_DEPTH = 0.33
"""Least darkness of a hole: blur that makes it paler also merges two holes into one."""
_LEAST_SEEN = 0.7
"""Share to which the least darkness falls for a hole under a cable."""
_MISFIT = 0.6
"""Greatest misfit of the best arrangement, in whole holes: more is another marker."""


class HolePattern:
    """Distinguishes the arrangements of `MARKER_HOLES` in a marker of which cables hide a part.

    Args:
        settings: Sizes.
        rows: Of a rectified marker.
        columns: Of a rectified marker.
    """

    def __init__(self, settings: TrackerSettings, rows: int, columns: int) -> None:
        side, scale = settings.hole_side, settings.marker_length / MARKER_LENGTH
        shape = (rows, columns)
        self._arrangements: list[Holes] = []
        patterns = []
        for number, centres in MARKER_HOLES.items():
            for sign in (1.0, -1.0):
                offset = sign * scale * sum(x for x, _ in centres) / number
                self._arrangements.append(Holes(number, offset, number * (side / MM_PER_PIXEL) ** 2))
                turned = [(sign * scale * x, sign * scale * y) for x, y in centres]
                patterns.append([sum(_hole(shape, x, y, side, blur) for x, y in turned) for blur in _BLURS])
        darkness = _BLACK * np.array(patterns)
        self._around = darkness[:, 0].max(axis=0) > _AROUND
        # Arrangement, blur, sample.
        self._patterns = darkness[:, :, self._around]
        self._hole = float(((_BLACK * _hole(shape, 0.0, 0.0, side, _BLURS[0])) ** 2).sum())

    def detect(self, marker: ClearedMarker) -> Holes | None:
        """The holes, or None if two arrangements fit almost equally well, or none fits."""
        darkness, visibility = marker.darkness[self._around], marker.visibility[self._around]
        # A cable that is thinner than the blur hides less than it seems to: a hole under it is between the two limits.
        differences = darkness - darkness.clip(visibility * self._patterns, self._patterns)
        misfits = (differences * differences).sum(axis=2).min(axis=1) / self._hole
        best, second = np.argsort(misfits)[:2].tolist()
        least = misfits[best]
        if least > min(_MISFIT, misfits[second] - _MARGIN, _RATIO * misfits[second]):
            return None
        hole = self._patterns[best, 0] > _AROUND
        # Of a hole under a cable, only the paler rim may be visible.
        seen = float((visibility * self._patterns[best, 0])[hole].max()) / _BLACK
        depth = _DEPTH * max(seen, _LEAST_SEEN)
        return self._arrangements[best] if darkness[hole].max() >= depth else None


def _hole(shape: tuple[int, int], x: float, y: float, side: float, blur: float) -> NDArray[np.float64]:
    """Darkness of a hole in a rectified marker, from 0 to 1.

    Args:
        shape: Rows and columns.
        x: Centre in mm from the middle, along the marker.
        y: Centre in mm from the middle, across it.
        side: In mm.
        blur: In region pixels.
    """
    rows, columns = shape
    return np.outer(_profile(rows, y, side, blur), _profile(columns, x, side, blur))


def _profile(samples: int, centre: float, side: float, blur: float) -> NDArray[np.float64]:
    """Darkness of a hole along one axis."""
    places = (np.arange(samples) + 0.5 - samples / 2) * SAMPLE - centre
    width = math.sqrt(2) * blur * MM_PER_PIXEL
    return np.array(
        [(math.erf((p + side / 2) / width) - math.erf((p - side / 2) / width)) / 2 for p in places]
    )
