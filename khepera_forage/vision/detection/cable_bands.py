"""Cables across a marker: straight dark bands from border to border of its rectified image, and their removal."""

from itertools import combinations
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

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
_CURVE_REPEATS = 1
_STIFFNESS = np.diag((1e4, 0.0, 0.0)) + 1e-3 * np.eye(3)
"""Weight of straightness against the measured middles of a cable: squares of coefficients, from the square of the
distance along the cable down."""
_SOLID = 1e-3
_SHARES = np.linspace(0, 1, 40)
"""Places between two crossings at which a cable must be dark."""

Darkness = NDArray[np.float32]
"""Rectified image of a marker: 0 is its white, 1 is black."""


class ClearedMarker(NamedTuple):
    """A rectified marker without its cables.

    Attributes:
        darkness: With the cables' own darkness removed.
        visibility: Share of the marker, at each sample, that no cable hides.
    """

    darkness: Darkness
    visibility: Darkness


class CableBands:
    """Removes cables from rectified markers of one size.

    Args:
        rows: Of a rectified marker.
        columns: Of a rectified marker.
    """

    def __init__(self, rows: int, columns: int) -> None:
        top, bottom, left, right = _RING, rows - 1 - _RING, _RING, columns - 1 - _RING
        ring = [(top, c) for c in range(left, right)] + [(r, right) for r in range(top, bottom)]
        ring += [(bottom, c) for c in range(right, left, -1)] + [(r, left) for r in range(bottom, top, -1)]
        self._ring = np.array(ring)
        on_rows = [self._ring[:, 0] == row for row in (top, bottom)]
        on_columns = [self._ring[:, 1] == column for column in (left, right)]
        self._on_sides = np.array(on_rows + on_columns)
        self._side_lengths = self._on_sides.sum(axis=1)
        self._ring_samples = np.ascontiguousarray(self._ring[:, 0] * columns + self._ring[:, 1])
        self._inner = np.abs(np.arange(-_REACH, _REACH + 1.0)) <= _REACH / 2
        self._rows, self._columns = np.mgrid[:rows, :columns].astype(np.float64)
        self._across = np.arange(-_REACH, _REACH + 1.0)

    def crossed(self, darkness: Darkness) -> bool:
        """Whether a cable, or anything else that is dark, crosses the ring inside the marker's border."""
        values = darkness.take(self._ring_samples)
        return bool(values.max() > _median(values) + _DARK)

    def remove(self, darkness: Darkness) -> ClearedMarker:
        """The marker without the cables that cross it."""
        visibility = np.ones_like(darkness)
        crossings = self._crossings(darkness)
        while len(crossings) > 1:
            pairs = list(combinations(range(len(crossings)), 2))
            scores = [self._continuity(darkness, crossings[i], crossings[j]) for i, j in pairs]
            best = int(np.argmax(scores))
            if scores[best] < _CONTINUOUS:
                break
            one, other = pairs[best]
            band = self._band(darkness, crossings[one][:2], crossings[other][:2])
            darkness = np.maximum(darkness - band, 0)
            visibility = visibility * np.clip(1 - band / max(float(band.max()), _SOLID), 0, 1)
            crossings = [c for i, c in enumerate(crossings) if i not in (one, other)]
        return ClearedMarker(darkness, visibility)

    def _crossings(self, darkness: Darkness) -> list[tuple[float, float, float]]:
        """Row, column and darkness of each place where something dark crosses the ring."""
        values = darkness.take(self._ring_samples)
        values = values - _median(values)
        dark = values > _DARK
        if not dark.any() or dark.all():
            return []
        # Start at a bright sample, so that no crossing is cut in two.
        start = int(np.argmin(dark))
        values = np.concatenate((values[start:], values[:start]))
        dark = np.concatenate((dark[start:], dark[:start]))
        ring = np.concatenate((self._ring[start:], self._ring[:start]))
        changes = np.flatnonzero(np.diff(dark.astype(np.int8))) + 1
        ends = [*changes.tolist(), len(dark)] if len(changes) % 2 else changes.tolist()
        crossings = []
        for first, last in zip(ends[::2], ends[1::2], strict=True):
            middle = (first + last) // 2
            on_sides = self._on_sides[:, (np.arange(first, last) + start) % len(dark)].sum(axis=1)
            # A cable along a side of the ring: two places on it.
            along_side = (on_sides >= _ALONG_SIDE * self._side_lengths).any()
            parts = [(first, middle), (middle, last)] if along_side else [(first, last)]
            for begin, end in parts:
                part = values[begin:end]
                row, column = part @ ring[begin:end] / part.sum()
                crossings.append((float(row), float(column), float(part.max())))
        darkest = max(darkness for _, _, darkness in crossings)
        return [crossing for crossing in crossings if crossing[2] >= _WEAK * darkest]

    @staticmethod
    def _continuity(
        darkness: Darkness, one: tuple[float, float, float], other: tuple[float, float, float]
    ) -> float:
        """Darkness at nine of ten places between two crossings, as a share of the weaker crossing's."""
        rows = np.rint(one[0] + _SHARES * (other[0] - one[0])).astype(int)
        columns = np.rint(one[1] + _SHARES * (other[1] - one[1])).astype(int)
        return float(np.sort(darkness[rows, columns])[len(rows) // 10]) / min(one[2], other[2])

    def _band(self, darkness: Darkness, one: tuple[float, float], other: tuple[float, float]) -> Darkness:
        """The darkness of a cable through two crossings: the median of its profiles, along a slightly curved line."""
        import cv2

        start, end = np.array(one), np.array(other)
        length = float(np.hypot(*(end - start)))
        along = (end - start) / max(length, 1.0)
        normal = np.array((-along[1], along[0]))
        steps = np.arange(0.0, max(length, 1.0) + 0.5)
        curve = np.zeros(3)
        profiles = np.zeros((len(steps), len(self._across)))
        for repeat in range(_CURVE_REPEATS + 1):
            across = _curve(curve, steps - length / 2)[:, None] + self._across
            rows = (start[0] + steps * along[0])[:, None] + across * normal[0]
            columns = (start[1] + steps * along[1])[:, None] + across * normal[1]
            profiles = cv2.remap(
                darkness,
                columns.astype(np.float32),
                rows.astype(np.float32),
                cv2.INTER_LINEAR,
                borderMode=cv2.BORDER_REPLICATE,
            ).astype(np.float64)
            if repeat < _CURVE_REPEATS:
                curve = curve + self._correction(profiles, steps - length / 2)
        profile = _median(profiles)
        profile = np.maximum(profile - min(profile[0], profile[-1]), 0)
        # The same profile for every sample of the image, by its distance from the line.
        down, right = self._rows - start[0], self._columns - start[1]
        places_along = down * along[0] + right * along[1] - length / 2
        bend = _curve(curve, np.minimum(np.maximum(places_along, -length / 2), length / 2))
        distances = down * normal[0] + right * normal[1] - bend
        band: Darkness = np.interp(distances, self._across, profile, left=0.0, right=0.0).astype(np.float32)
        return band

    def _correction(self, profiles: NDArray[np.float64], steps: NDArray[np.float64]) -> NDArray[np.float64]:
        """The curve through the middles of the profiles; profiles with a hole in them count little."""
        inner = profiles[:, self._inner]
        masses = inner.sum(axis=1)
        middles = inner @ self._across[self._inner] / np.maximum(masses, 0.1)
        typical = float(_median(masses))
        weights = np.exp(-(((masses - typical) / max(0.15 * typical, 0.1)) ** 2)) + 1e-3
        powers = np.column_stack((steps * steps, steps, np.ones_like(steps)))
        weighted = powers.T * weights
        # Short cables, and cables of which little is seen, are straight.
        return np.linalg.solve(weighted @ powers + _STIFFNESS, weighted @ middles)


def _median(values: NDArray[np.floating]) -> NDArray[np.floating]:
    """The median along the first axis; for small arrays several times faster than numpy's."""
    ordered = np.sort(values, axis=0)
    return (ordered[(len(values) - 1) // 2] + ordered[len(values) // 2]) / 2  # type: ignore[no-any-return]


def _curve(curve: NDArray[np.float64], places: NDArray[np.float64]) -> NDArray[np.float64]:
    """Distance of a cable's middle from the straight line at some places along it."""
    a, b, c = curve.tolist()
    return (a * places + b) * places + c  # type: ignore[no-any-return]
