"""The holes of a marker: the known arrangement that fits what is visible of it, or the reason why none does."""

import math
from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from khepera_forage.vision.detection.cable_bands import CableBands, Darkness
from khepera_forage.vision.detection.segmentation import Frame
from khepera_forage.vision.scene import MM_PER_PIXEL

SAMPLE = 2.5
"""mm on the floor between the samples of a rectified marker."""
BORDER = 4
"""Samples of a rectified marker beyond each of its sides: the black frame."""
_BLURS = (0.5, 0.8, 1.2, 1.7)
"""Standard deviations in region pixels of the blur of a hole's border, from a sharp lens to a soft one."""
_TYPICAL = 1
"""Number of the blur from which arrangements are compared."""
_AROUND = 0.02
"""Darkness of any arrangement from which a sample counts: cables elsewhere do not matter."""
_BLACK = 0.85
"""Darkness of a hole."""
_LEAST_DEPTH, _MOST_DEPTH = 0.42, 1.15
"""Least and greatest darkness of a hole as multiples of `_BLACK`."""
_MARGIN, _RATIO = 0.06, 0.55
"""Least difference between the misfits of the best two arrangements, in whole holes, and their greatest ratio: beyond,
the arrangement is uncertain."""
_DEPTH = 0.33
"""Least darkness of a hole: blur that makes it paler also merges two holes into one."""
_LEAST_SEEN = 0.7
"""Share to which the least darkness falls for a hole under a cable."""
_MISFIT, _CLEAR_MISFIT = 0.3, 0.1
"""Greatest misfit of the best arrangement, in whole holes, with a cable and without: more is another marker."""
_RIM = 3
"""Samples inside the sides that blur darkens."""
_UNEXPLAINED, _UNEXPLAINED_BESIDE_CABLES = 0.15, 0.25
"""Darkness of a sample beyond what holes and cables explain."""
_THICK, _THICK_BESIDE_CABLES = np.ones((5, 5), np.uint8), np.ones((7, 7), np.uint8)
"""Samples of which all must be so dark: what cables leave beside them is thinner."""
_SEEN = 0.7
"""Visibility from which a sample is clear of cables."""
_BEYOND = BORDER - 2
"""Row or column in the black frame, 4 mm beyond a side."""
_OUTSIDE, _MOST_OUTSIDE = 0.75, 0.5
"""Brightness of a sample there, as a share of white; and the greatest difference of the shares of such samples between
opposite sides: with a greater one, a side is elsewhere."""
_WHITE = 0.85
"""Share of the samples inside a marker that are no brighter than its white."""
_GLARE, _LEAST_GLARE = 1.06, 0.012
"""Brightness of a reflection, as a share of white, and the least share of the marker that it covers."""


class Reading(NamedTuple):
    """What the holes of a marker tell.

    Attributes:
        number: Of the marker; 0 if it is uncertain.
        forward: Whether the front is at the last column of the rectified marker.
        area: Of the holes in square region pixels.
        trouble: Why the marker is uncertain; empty if it is not.
    """

    number: int
    forward: bool = True
    area: float = 0.0
    trouble: str = ""


class HolePattern:
    """Distinguishes arrangements of holes.

    Args:
        arrangements: Centres of the holes in mm, by the number of the marker.
        side: Of a hole in mm.
        length: Of a marker in mm.
        width: Of a marker in mm.
        stretch: Ratio of the marker's length to that of the arrangements.

    Attributes:
        rows: Of a rectified marker, with its frame.
        columns: Of a rectified marker, with its frame.
    """

    def __init__(
        self,
        arrangements: Mapping[int, Sequence[tuple[float, float]]],
        side: float,
        length: float,
        width: float,
        stretch: float = 1.0,
    ) -> None:
        shape = (round(width / SAMPLE), round(length / SAMPLE))
        self.rows, self.columns = (n + 2 * BORDER for n in shape)
        self._cables = CableBands(*shape)
        self._readings: list[Reading] = []
        patterns = []
        for number, centres in arrangements.items():
            for sign in (1.0, -1.0):
                area = len(centres) * (side / MM_PER_PIXEL) ** 2
                self._readings.append(Reading(number, sign > 0, area))
                turned = [(sign * stretch * x, sign * stretch * y) for x, y in centres]
                patterns.append([sum(_hole(shape, x, y, side, blur) for x, y in turned) for blur in _BLURS])
        darkness = _BLACK * np.array(patterns, np.float32)
        self._around = np.ascontiguousarray(darkness[:, _TYPICAL].max(axis=0) > _AROUND)
        # Samples of each arrangement that are white, and clear of the sides.
        self._blank = darkness[:, _TYPICAL] < _AROUND
        for axis in (1, 2):
            self._blank.swapaxes(axis, 0)[:_RIM] = self._blank.swapaxes(axis, 0)[-_RIM:] = False
        # Arrangement, blur, sample.
        self._patterns = darkness[:, :, self._around]
        self._energies = (self._patterns**2).sum(axis=2)
        self._hole = float(((_BLACK * _hole(shape, 0.0, 0.0, side, _BLURS[_TYPICAL])) ** 2).sum())
        self._inside = (slice(_RIM, -_RIM),) * 2

    def read(self, rectified: Frame, level: float) -> Reading:
        """The number and front of a marker.

        Args:
            rectified: Grey levels of the marker with its frame, its long axis along the rows.
            level: Grey level of its white.
        """
        import cv2

        inner = rectified[BORDER:-BORDER, BORDER:-BORDER][self._inside].ravel()
        rank = int(_WHITE * len(inner))
        white_level = max(float(np.partition(inner, rank)[rank]), 0.9 * level)
        whole = rectified.astype(np.float32) / np.float32(white_level)
        white = whole[BORDER:-BORDER, BORDER:-BORDER]
        darkness = (1 - white).clip(0, 1)
        crossed = self._cables.crossed(darkness)
        cleared = self._cables.remove(darkness) if crossed else None
        rest, visibility = (darkness, None) if cleared is None else cleared
        number, misfit, pale = self._best(rest, visibility)
        inside = white[self._inside]
        if np.count_nonzero(cv2.blur(inside, (5, 5)) > _GLARE) > _LEAST_GLARE * inside.size:
            return Reading(0, trouble="glare")
        beyond = (whole[_BEYOND], whole[-1 - _BEYOND], whole[:, _BEYOND], whole[:, -1 - _BEYOND])
        front, back, left, right = ((side > _OUTSIDE).mean() for side in beyond)
        if max(abs(front - back), abs(left - right)) > _MOST_OUTSIDE:
            return Reading(0, trouble="cover")
        dark = (rest > (_UNEXPLAINED_BESIDE_CABLES if crossed else _UNEXPLAINED)) & self._blank[number]
        if visibility is not None:
            dark &= visibility > _SEEN
        thick = _THICK_BESIDE_CABLES if crossed else _THICK
        if cv2.erode(dark.astype(np.uint8), thick).any():
            return Reading(0, trouble="cover")
        if pale:
            return Reading(0, trouble="pale holes")
        if misfit > (_MISFIT if crossed else _CLEAR_MISFIT):
            return Reading(0, trouble="cables" if crossed else "holes")
        return self._readings[number]

    def _best(self, rest: Darkness, visibility: Darkness | None) -> tuple[int, float, bool]:
        """The arrangement that fits best, its misfit (infinite if another fits as well), and whether it is too pale."""
        darkness = rest[self._around]
        if visibility is None:
            # Print may be paler than black.
            depths = (self._patterns @ darkness) / self._energies
            depths = depths.clip(_LEAST_DEPTH, _MOST_DEPTH)[..., None]
            differences = darkness / depths - self._patterns
        else:
            # A cable that is thinner than the blur hides less than it seems to: a hole under it is between two limits.
            seen = visibility[self._around]
            differences = darkness - darkness.clip(seen * self._patterns, self._patterns)
        by_blur = (differences * differences).sum(axis=2) / self._hole
        misfits = by_blur[:, _TYPICAL:].min(axis=1)
        best, second = np.argsort(misfits)[:2].tolist()
        least = float(by_blur[best].min())
        hole = self._patterns[best, _TYPICAL] > _AROUND
        # Of a hole under a cable, only the paler rim may be visible.
        share = (
            1.0 if visibility is None else float((seen * self._patterns[best, _TYPICAL])[hole].max()) / _BLACK
        )
        pale = float(darkness[hole].max()) < _DEPTH * max(share, _LEAST_SEEN)
        if misfits[best] > min(misfits[second] - _MARGIN, _RATIO * misfits[second]):
            least = math.inf
        return best, least, pale


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
