"""The holes of a marker: the known arrangement that fits what is visible of it, or the reason why none does.

Cables are removed first: straight dark bands from border to border of the marker's rectified image.
"""

import math
from collections.abc import Mapping, Sequence
from itertools import combinations
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

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
_DEPTH, _LEAST_SEEN = 0.33, 0.7
"""Least darkness of a hole, as blur that makes it paler also merges two holes into one; and the share to which this
falls for a hole under a cable."""
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

_RING = 4
"""Samples from the border of the marker to the ring on which cables are searched: no hole reaches it, and the blur of
the border hardly does."""
_DARK = 0.12
"""Darkness above the ring's median from which a sample may belong to a cable."""
_ALONG_SIDE = 0.9
"""Share of a side of the ring from which a crossing is a cable that runs along it."""
_WEAK = 0.4
"""Darkness of a crossing, as a share of the darkest one's, below which it is no cable: blur, or the end of a shadow."""
_CONTINUOUS = 0.5
"""Darkness of a cable at nine of ten places, as a share of its darkness on the ring."""
_REACH = 9
"""Samples on either side of a cable's middle at which its profile is measured: 22 mm."""
_ACROSS = np.arange(-_REACH, _REACH + 1.0)
_INNER = np.abs(_ACROSS) <= _REACH / 2
_STIFFNESS = np.diag((1e4, 0.0, 0.0)) + 1e-3 * np.eye(3)
"""Weight of straightness against the measured middles of a cable: squares of coefficients, from the square of the
distance along the cable down."""
_SHARES = np.linspace(0, 1, 40)
"""Places between two crossings at which a cable must be dark."""

Darkness = NDArray[np.float32]
"""Rectified image of a marker: 0 is its white, 1 is black."""


class Reading(NamedTuple):
    """What the holes of a marker tell: its number, or 0 and the trouble that makes it uncertain.

    `forward` tells whether the front is at the last column of the rectified marker; `area` is that of the holes in
    square region pixels.
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
    """

    def __init__(
        self,
        arrangements: Mapping[int, Sequence[tuple[float, float]]],
        side: float,
        length: float,
        width: float,
    ) -> None:
        shape = (round(width / SAMPLE), round(length / SAMPLE))
        # Of a rectified marker, with its frame.
        self.rows, self.columns = (n + 2 * BORDER for n in shape)
        self._cables = _Cables(*shape)
        self._readings: list[Reading] = []
        patterns = []
        for number, centres in arrangements.items():
            for sign in (1.0, -1.0):
                area = len(centres) * (side / MM_PER_PIXEL) ** 2
                self._readings.append(Reading(number, sign > 0, area))
                patterns.append(
                    [sum(_hole(shape, sign * x, sign * y, side, blur) for x, y in centres) for blur in _BLURS]
                )
        darkness = _BLACK * np.array(patterns, np.float32)
        self._around = np.ascontiguousarray(darkness[:, _TYPICAL].max(axis=0) > _AROUND)
        self._inside = (slice(_RIM, -_RIM),) * 2
        # Samples of each arrangement that are white, and clear of the sides.
        inside = np.zeros(shape, bool)
        inside[self._inside] = True
        self._blank = (darkness[:, _TYPICAL] < _AROUND) & inside
        # Arrangement, blur, sample.
        self._patterns = darkness[:, :, self._around]
        self._energies = (self._patterns**2).sum(axis=2)
        self._hole = float(((_BLACK * _hole(shape, 0.0, 0.0, side, _BLURS[_TYPICAL])) ** 2).sum())

    def read(self, rectified: Frame, level: float) -> Reading:
        """The number and front of a marker.

        Args:
            rectified: Grey levels of the marker with its frame, its long axis along the rows.
            level: Grey level of its white.
        """
        inner = rectified[BORDER:-BORDER, BORDER:-BORDER][self._inside].ravel()
        rank = int(_WHITE * len(inner))
        whole = rectified / np.float32(max(float(np.partition(inner, rank)[rank]), 0.9 * level))
        white = whole[BORDER:-BORDER, BORDER:-BORDER]
        darkness = (1 - white).clip(0, 1)
        crossed = self._cables.crossed(darkness)
        rest, visibility = self._cables.removed(darkness) if crossed else (darkness, None)
        best, misfit, pale = self._best(rest, visibility)
        inside = white[self._inside]
        if np.count_nonzero(cv2.blur(inside, (5, 5)) > _GLARE) > _LEAST_GLARE * inside.size:
            return Reading(0, trouble="glare")
        beyond = (whole[_BEYOND], whole[-1 - _BEYOND], whole[:, _BEYOND], whole[:, -1 - _BEYOND])
        front, back, left, right = ((side > _OUTSIDE).mean() for side in beyond)
        dark = (rest > (_UNEXPLAINED_BESIDE_CABLES if crossed else _UNEXPLAINED)) & self._blank[best]
        if visibility is not None:
            dark &= visibility > _SEEN
        thick = cv2.erode(dark.astype(np.uint8), _THICK_BESIDE_CABLES if crossed else _THICK).any()
        if thick or max(abs(front - back), abs(left - right)) > _MOST_OUTSIDE:
            return Reading(0, trouble="cover")
        if pale:
            return Reading(0, trouble="pale holes")
        if misfit > (_MISFIT if crossed else _CLEAR_MISFIT):
            return Reading(0, trouble="cables" if crossed else "holes")
        return self._readings[best]

    def _best(self, rest: Darkness, visibility: Darkness | None) -> tuple[int, float, bool]:
        """The arrangement that fits best, its misfit (infinite if another fits as well), and whether it is too pale."""
        darkness = rest[self._around]
        if visibility is None:
            # Print may be paler than black.
            depths = (self._patterns @ darkness) / self._energies
            differences = darkness / depths.clip(_LEAST_DEPTH, _MOST_DEPTH)[..., None] - self._patterns
        else:
            # A cable that is thinner than the blur hides less than it seems to: a hole under it is between two limits.
            seen = visibility[self._around]
            differences = darkness - darkness.clip(seen * self._patterns, self._patterns)
        by_blur = (differences * differences).sum(axis=2) / self._hole
        misfits = by_blur[:, _TYPICAL:].min(axis=1)
        best, second = np.argsort(misfits)[:2].tolist()
        hole = self._patterns[best, _TYPICAL] > _AROUND
        # Of a hole under a cable, only the paler rim may be visible.
        share = 1.0
        if visibility is not None:
            share = float((seen * self._patterns[best, _TYPICAL])[hole].max()) / _BLACK
        pale = float(darkness[hole].max()) < _DEPTH * max(share, _LEAST_SEEN)
        if misfits[best] > min(misfits[second] - _MARGIN, _RATIO * misfits[second]):
            return best, math.inf, pale
        return best, float(by_blur[best].min()), pale


class _Cables:
    """Removes cables from rectified markers with some numbers of rows and columns."""

    def __init__(self, rows: int, columns: int) -> None:
        top, bottom, left, right = _RING, rows - 1 - _RING, _RING, columns - 1 - _RING
        ring = [(top, c) for c in range(left, right)] + [(r, right) for r in range(top, bottom)]
        ring += [(bottom, c) for c in range(right, left, -1)] + [(r, left) for r in range(bottom, top, -1)]
        self._ring = np.array(ring)
        sides = ((0, top), (0, bottom), (1, left), (1, right))
        self._on_sides = np.array([self._ring[:, axis] == place for axis, place in sides])
        self._rows, self._columns = np.mgrid[:rows, :columns].astype(np.float64)

    def crossed(self, darkness: Darkness) -> bool:
        """Whether a cable, or anything else that is dark, crosses the ring inside the marker's border."""
        return bool((self._on_ring(darkness) > _DARK).any())

    def removed(self, darkness: Darkness) -> tuple[Darkness, Darkness]:
        """The marker without the cables that cross it, and the share of each sample that no cable hides."""
        visibility = np.ones_like(darkness)
        crossings = self._crossings(darkness)
        while len(crossings) > 1:
            pairs = list(combinations(range(len(crossings)), 2))
            scores = [_continuity(darkness, crossings[i], crossings[j]) for i, j in pairs]
            best = int(np.argmax(scores))
            if scores[best] < _CONTINUOUS:
                break
            one, other = pairs[best]
            band = self._band(darkness, crossings[one][:2], crossings[other][:2])
            darkness = np.maximum(darkness - band, 0)
            visibility = visibility * np.clip(1 - band / max(float(band.max()), 1e-3), 0, 1)
            crossings = [c for i, c in enumerate(crossings) if i not in (one, other)]
        return darkness, visibility

    def _on_ring(self, darkness: Darkness) -> Darkness:
        """Darkness beyond the median along the ring."""
        values = darkness[self._ring[:, 0], self._ring[:, 1]]
        return values - np.median(values)  # type: ignore[no-any-return]

    def _crossings(self, darkness: Darkness) -> list[tuple[float, float, float]]:
        """Row, column and darkness of each place where something dark crosses the ring."""
        values = self._on_ring(darkness)
        # Start at a bright sample, so that no crossing is cut in two.
        start = int(np.argmin(values > _DARK))
        values = np.roll(values, -start)
        ring, on_sides = np.roll(self._ring, -start, axis=0), np.roll(self._on_sides, -start, axis=1)
        changes = np.flatnonzero(np.diff(np.append(values > _DARK, False).astype(np.int8))) + 1
        crossings = []
        for first, last in changes.reshape(-1, 2).tolist():
            middle = (first + last) // 2
            # A cable along a side of the ring: two places on it.
            along_side = on_sides[:, first:last].sum(axis=1) >= _ALONG_SIDE * self._on_sides.sum(axis=1)
            parts = [(first, middle), (middle, last)] if along_side.any() else [(first, last)]
            for begin, end in parts:
                part = values[begin:end]
                row, column = part @ ring[begin:end] / part.sum()
                crossings.append((float(row), float(column), float(part.max())))
        darkest = max((darkness for _, _, darkness in crossings), default=0.0)
        return [crossing for crossing in crossings if crossing[2] >= _WEAK * darkest]

    def _band(self, darkness: Darkness, one: tuple[float, float], other: tuple[float, float]) -> Darkness:
        """The darkness of a cable through two crossings: the median of its profiles, along a slightly curved line."""
        start, end = np.array(one), np.array(other)
        length = max(float(np.hypot(*(end - start))), 1.0)
        along = (end - start) / length
        normal = np.array((-along[1], along[0]))
        steps = np.arange(0.0, length + 0.5)
        curve = np.zeros(3)
        for repeat in range(2):
            across = np.polyval(curve, steps - length / 2)[:, None] + _ACROSS
            rows, columns = (
                ((start[i] + steps * along[i])[:, None] + across * normal[i]).astype(np.float32)
                for i in (0, 1)
            )
            profiles = cv2.remap(darkness, columns, rows, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
            if repeat == 0:
                curve = _middles(profiles.astype(np.float64), steps - length / 2)
        profile = np.median(profiles.astype(np.float64), axis=0)
        profile = np.maximum(profile - min(profile[0], profile[-1]), 0)
        # The same profile for every sample of the image, by its distance from the line.
        down, right = self._rows - start[0], self._columns - start[1]
        places_along = (down * along[0] + right * along[1] - length / 2).clip(-length / 2, length / 2)
        distances = down * normal[0] + right * normal[1] - np.polyval(curve, places_along)
        band: Darkness = np.interp(distances, _ACROSS, profile, left=0.0, right=0.0).astype(np.float32)
        return band


def _continuity(
    darkness: Darkness, one: tuple[float, float, float], other: tuple[float, float, float]
) -> float:
    """Darkness at nine of ten places between two crossings, as a share of the weaker crossing's."""
    rows, columns = (np.rint(one[i] + _SHARES * (other[i] - one[i])).astype(int) for i in (0, 1))
    return float(np.sort(darkness[rows, columns])[len(_SHARES) // 10]) / min(one[2], other[2])


def _middles(profiles: NDArray[np.float64], places: NDArray[np.float64]) -> NDArray[np.float64]:
    """The curve through the middles of a cable's profiles; profiles with a hole in them count little."""
    inner = profiles[:, _INNER]
    masses = inner.sum(axis=1)
    middles = inner @ _ACROSS[_INNER] / np.maximum(masses, 0.1)
    typical = float(np.median(masses))
    weights = np.exp(-(((masses - typical) / max(0.15 * typical, 0.1)) ** 2)) + 1e-3
    powers = np.vander(places, 3)
    weighted = powers.T * weights
    # Short cables, and cables of which little is seen, are straight.
    return np.linalg.solve(weighted @ powers + _STIFFNESS, weighted @ middles)


def _hole(shape: tuple[int, int], x: float, y: float, side: float, blur: float) -> NDArray[np.float64]:
    """Darkness from 0 to 1 of a blurred hole in a rectified marker; x and y are from its middle in mm."""
    rows, columns = shape
    return np.outer(_profile(rows, y, side, blur), _profile(columns, x, side, blur))


def _profile(samples: int, centre: float, side: float, blur: float) -> NDArray[np.float64]:
    """Darkness of a hole along one axis."""
    places = (np.arange(samples) + 0.5 - samples / 2) * SAMPLE - centre
    width = math.sqrt(2) * blur * MM_PER_PIXEL
    return np.array(
        [(math.erf((p + side / 2) / width) - math.erf((p - side / 2) / width)) / 2 for p in places]
    )
