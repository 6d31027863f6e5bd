"""Robots' markers: from a bright shape to pose and number of holes (figures 3.8, 3.9).

A cable hides a part of a marker, or cuts its border. The centre of mass of the rest is then shifted and turned, but the
visible parts of the four sides are where they were. The pose is that of the rectangle on which most border points lie.
The number and the front are those of the arrangement of holes that fits the upright image of the marker, after cables
were removed: dark bands from border to border.
"""

import math
from itertools import combinations
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.special import erf

from khepera_forage.robots.khepera import MARKER_LENGTH, MARKER_WIDTH
from khepera_forage.vision.calibration import Calibration
from khepera_forage.vision.scene import MM_PER_PIXEL
from khepera_forage.vision.segmentation import ImagePatch, ShapeMoments, shape_moments
from khepera_forage.vision.shapes import ARRANGEMENTS
from khepera_forage.vision.tracker_settings import TrackerSettings
from khepera_forage.vision.video import Frame

Floats = NDArray[np.float64]
Darkness = NDArray[np.float32]
"""Upright image of a marker: 0 is its white, 1 is black."""
Crossing = tuple[float, float, float]
"""Row and column of a sample, and darkness."""

# ------------------------------------------------------------------ sizes

_SIZE = np.array((MARKER_LENGTH, MARKER_WIDTH)) / MM_PER_PIXEL
"""Length and width in region pixels."""
_DEVIATIONS = _SIZE / math.sqrt(12)
"""Standard deviations of a rectangle along its length and width."""
_SQUARE = np.ones((3, 3), np.uint8)
_MAX_REPEATS, _CONVERGED = 3, 0.5
"""Greatest number of times the border is searched around the last estimate, and region pixels, at the corners, below
which another search changes nothing."""
_SEEN_SIZE = 0.97
"""Size of a marker's white as a share of its true size: its frame and blur take a few percent."""
_SAME_SHAPE, _OTHER_SIZE = 0.05, 0.06
"""Difference between the shares of length and width up to which all of a marker is seen; and the relative difference
in size from which a marker is searched for at its own size."""
_MIN_AREA = 0.6
"""Share of a marker's area that must be seen."""
_OPENING = 1.3
"""In diameters of food: shapes that stick out from a marker and are narrower than this are not part of it."""
_CORNERS = np.array([(1, 1), (-1, 1), (-1, -1), (1, -1)])

# ------------------------------------------------------------------ border

_POINTS = 13
"""Points on each side: as many on a short one as on a long one, so that three sides always outvote one."""
_SHARE = 0.84
"""Share of a side, around its middle, on which points are taken: blur rounds the corners."""
_STEP = 0.5
_OFFSETS = np.arange(-5.0, 5.0 + _STEP / 2, _STEP)
"""Region pixels from the expected place of a side, outwards, at which it is searched."""
_CUTOFFS = (3.0, 1.5, 0.6, 0.3, 0.2)
"""Region pixels beyond which a point has no weight, from one repeat to the next."""
_COARSE = 2.0
"""Cutoff above which only the trusted points count."""
_CLEAR_CUTOFFS = (1.5, 0.6, 0.3, 0.2, 0.2)
"""The same for a border of which little is hidden."""
_CLEAR_SHARE = 0.78
"""Share of the points without sides that a cable lies along, which must lie on the rectangle for that: more than three
of four sides."""
_SPREAD_CUTOFF = 4.0
"""Least cutoff in median distances of the points from the rectangle: markers of another size have no exact fit."""
_USUAL_GROWTH, _GROWTH_DEVIATION, _GROWTH_PENALTY = -0.45, 0.6, 10.0
"""Region pixels by which blur and exposure move all sides outwards, and by which they differ from it at most: measured
over all disturbances of `benchmarks/tracker.py`. And the number of points that every further region pixel costs when
it is decided which side is hidden: a marker that seems too small has its border where a cable begins."""
_LEAST_SHARE, _LEAST_ON_SIDE = 0.35, 3
"""Share of all points that must lie on the rectangle; points from which a side counts as seen: three sides must be."""
_BEYOND_ENDS = (5.0, 6.0, 7.0)
"""Region pixels beyond the end of a side where the floor is looked at: beyond the black frame and its blur, even of a
marker that appears 15 % too large."""
_ASIDE = (-3.0, -2.0, -1.0, 0.0, 1.0, 2.0, 3.0)
"""Region pixels from the line of the side, outwards, where a cable is looked for: with it, cables that make an angle of
up to 10 degrees with the side are found."""
_CABLE_DEVIATION = 0.1
"""Share of the floor's brightness by which a cable differs from it: a grey one, 4 mm wide and blurred, differs by 0.15
to 0.2, and floor with its texture, noise and light by up to 0.09."""
_SIDES = np.array([(1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0)])
"""Outward normals of the front, back, left and right side."""
_OPPOSITE = [1, 0, 3, 2]

# ------------------------------------------------------------------ holes

_SAMPLE = 2.5
"""mm on the floor between the samples of an upright marker."""
_SHAPE = (round(MARKER_WIDTH / _SAMPLE), round(MARKER_LENGTH / _SAMPLE))
"""Rows and columns of an upright marker."""
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
_UNCERTAIN, _RATIO = 0.06, 0.55
"""Least difference between the misfits of the best two arrangements, in whole holes, and their greatest ratio: beyond,
the arrangement is uncertain."""
_DEPTH, _LEAST_SEEN = 0.33, 0.7
"""Least darkness of a hole, as blur that makes it paler also merges two holes into one; and the share to which this
falls for a hole under a cable."""
_MISFIT, _CLEAR_MISFIT = 0.3, 0.1
"""Greatest misfit of the best arrangement, in whole holes, with a cable and without: more is another marker."""
_INSIDE = (slice(3, -3),) * 2
"""Samples that the blur of the sides does not darken."""
_UNEXPLAINED, _UNEXPLAINED_BESIDE_CABLES = 0.15, 0.25
"""Darkness of a sample beyond what holes and cables explain."""
_THICK, _THICK_BESIDE_CABLES = np.ones((5, 5), np.uint8), np.ones((7, 7), np.uint8)
"""Samples of which all must be so dark: what cables leave beside them is thinner."""
_WHITE = 0.85
"""Share of the samples inside a marker that are no brighter than its white."""

# ------------------------------------------------------------------ cables

_NEAR = 4
"""Samples from the border of the marker to the ring on which cables are searched: no hole reaches it, and the blur of
the border hardly does."""
_FAR_ROW, _FAR_COLUMN = _SHAPE[0] - 1 - _NEAR, _SHAPE[1] - 1 - _NEAR
_RING = np.array(
    [(_NEAR, column) for column in range(_NEAR, _FAR_COLUMN)]
    + [(row, _FAR_COLUMN) for row in range(_NEAR, _FAR_ROW)]
    + [(_FAR_ROW, column) for column in range(_FAR_COLUMN, _NEAR, -1)]
    + [(row, _NEAR) for row in range(_FAR_ROW, _NEAR, -1)]
)
_ON_SIDES = np.stack([_RING[:, 0] == _NEAR, _RING[:, 0] == _FAR_ROW, _RING[:, 1] == _NEAR, _RING[:, 1] == _FAR_COLUMN])
"""Row and column of its samples in order; and which of them lie on each side."""
_CROSSING = 0.12
"""Darkness above the ring's median from which a sample may belong to a cable."""
_ALONG_SIDE = 0.9
"""Share of a side of the ring from which a crossing is a cable that runs along it."""
_WEAK = 0.4
"""Darkness of a crossing, as a share of the darkest one's, below which it is no cable: blur, or the end of a shadow."""
_ACROSS = np.arange(-9.0, 10.0)
"""Samples from a cable's middle at which its profile is measured: 22 mm to either side."""
_SHARES = np.linspace(0, 1, 40)
"""Places between two crossings at which a cable must be dark."""


class Reading(NamedTuple):
    """What the holes of a marker tell: its number, or 0 and the trouble that makes it uncertain.

    `forward` tells whether the front is at the last column of the upright image; `area` is that of the holes in
    square region pixels.
    """

    number: int
    forward: bool = True
    area: float = 0.0
    trouble: str = ""


class DetectedMarker(NamedTuple):
    """A marker in a frame: the axis of its moments is the heading; its corners are 4 x 2 pixels of the picture."""

    moments: ShapeMoments
    reading: Reading
    corners: Floats


class MarkerDetector:
    """Distinguishes markers from other bright shapes, and measures their pose and holes."""

    def __init__(self, settings: TrackerSettings, calibration: Calibration) -> None:
        self._calibration, self._tolerance = calibration, settings.tolerance
        self._height = settings.marker_height
        diameter = max(3, round(_OPENING * 2 * settings.food_radius / calibration.mm_per_pixel()))
        self._opening_kernel = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (diameter, diameter))
        self._border = _BorderFit()
        self._pattern = _HolePattern(settings)

    def detect(self, frame: Frame, patch: ImagePatch, joined: bool) -> DetectedMarker | None:
        """The marker in a patch of a frame; None for anything else, or for a marker whose pose is uncertain.

        The border of a piece that was not `joined` must fit exactly: a part of a marker would fit loosely elsewhere.
        """
        # Closing fills notches; opening removes whatever is narrower than the kernel (food at the rim, a cable).
        closed = cv2.morphologyEx(patch.filled, cv2.MORPH_CLOSE, _SQUARE)
        mask: Frame = cv2.morphologyEx(closed, cv2.MORPH_OPEN, self._opening_kernel)  # type: ignore[assignment]
        estimate = shape_moments(patch, mask, self._calibration, self._height)
        if estimate is None:
            return None
        along, across = ratios = np.array((estimate.major, estimate.minor)) / _DEVIATIONS
        area = _MIN_AREA * _SIZE.prod()
        if estimate.area < area or np.abs(ratios - 1).max() > self._tolerance:
            return None
        moments, clear = self._fitted(frame, patch, estimate, 1.0, joined)
        # Unless all of it is seen, a marker has its true size.
        own_size = ratios.mean() / _SEEN_SIZE if abs(along - across) < _SAME_SHAPE else 1.0
        if not clear and abs(own_size - 1) > _OTHER_SIZE:
            other, clear = self._fitted(frame, patch, estimate, own_size, joined)
            moments = other if clear else moments
        if moments is None:
            return None
        steps, middle = self._steps(moments)
        corners = middle + _CORNERS * _SIZE / 2 @ steps.T
        upright = self._upright(frame, middle, steps * (own_size if clear else 1.0))
        reading = self._pattern.read(upright, moments.level)
        if not reading.forward:
            moments = moments._replace(axis=moments.axis + math.pi)
        return DetectedMarker(moments, reading, corners)

    def _fitted(
        self, frame: Frame, patch: ImagePatch, moments: ShapeMoments, size: float, loose: bool
    ) -> tuple[ShapeMoments | None, bool]:
        """The moments of the marker with a border near; `size` is a share of the true one. Is little of it hidden?"""
        clear = False
        for _ in range(_MAX_REPEATS):
            steps, middle = self._steps(moments)
            affine = np.column_stack((size * steps, middle - 0.5))
            rectangle = self._border.fit(frame, affine, moments.level, patch.floor, loose)
            if rectangle is None:
                return None, False
            a, b, turn, clear = rectangle
            u, v = (middle + size * steps @ (a, b)).tolist()
            moments = moments._replace(u=u, v=v, axis=moments.axis + turn)
            if math.hypot(a, b) + abs(turn) * 2 * _DEVIATIONS[0] < _CONVERGED:
                break
        return moments, clear

    def _steps(self, moments: ShapeMoments) -> tuple[Floats, Floats]:
        """In the picture: steps of a region pixel along and across the marker (columns), and its middle."""
        jacobian = self._calibration.jacobian(moments.u, moments.v, self._height)
        cos, sin = math.cos(moments.axis), math.sin(moments.axis)
        steps = np.linalg.inv(jacobian) @ [[cos, -sin], [sin, cos]]
        return steps, np.array(moments[:2])

    def _upright(self, frame: Frame, middle: Floats, steps: Floats) -> Frame:
        """The marker upright: column 0 at one end, row 0 at its right side."""
        steps = steps * _SAMPLE / MM_PER_PIXEL
        rows, columns = _SHAPE
        start = middle - 0.5 - steps @ ((columns - 1) / 2, (rows - 1) / 2)
        flags = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
        return cv2.warpAffine(frame, np.column_stack((steps, start)), (columns, rows), flags=flags)  # type: ignore[return-value]


class _BorderFit:
    """Fits rectangles of a marker's size."""

    def __init__(self) -> None:
        half = _SIZE / 2
        normals = np.repeat(_SIDES, _POINTS, axis=0)
        shares = np.tile(np.linspace(-_SHARE, _SHARE, _POINTS), 4)[:, None]
        places = (normals + shares * (1 - np.abs(normals))) * half
        samples = places[:, None, :] + normals[:, None, :] * _OFFSETS[:, None]
        # Beyond both ends of each side, where a cable along it would be.
        end, aside, beyond = np.meshgrid((1, -1), _ASIDE, _BEYOND_ENDS, indexing="ij")
        normal = _SIDES[:, None, None, None, :]
        ends = normal * (half + aside[..., None])
        ends = ends + (1 - np.abs(normal)) * end[..., None] * (half + beyond[..., None])
        self._places = np.concatenate((samples.reshape(-1, 2), ends.reshape(-1, 2)))
        # Outward shift of each point with the centre, the turn, and the size: blur, exposure and paper move all sides
        # about equally. There are two candidates for each point.
        levers = normals[:, 1] * places[:, 0] - normals[:, 0] * places[:, 1]
        self._terms = np.tile(np.column_stack((normals, levers, np.ones(len(places)))), (2, 1))
        self._sides = np.tile(np.repeat(np.arange(4), _POINTS), 2)
        # First all sides where their white ends first; then each side where its white ends last.
        sides = self._sides[: 4 * _POINTS]
        self._trusted = np.stack([np.concatenate((sides != i, sides == i)) for i in (-1, 0, 1, 2, 3)])
        # Keeps the solution finite when too few points are visible.
        self._prior = 1e-3 * np.diag((1.0, 1.0, half[0] ** 2, 1.0))

    def fit(
        self, grey: Frame, affine: Floats, white: float, floor: float, loose: bool
    ) -> tuple[float, float, float, bool] | None:
        """The rectangle near an expected pose; with `loose`, far points count, too, if no rectangle fits exactly.

        `affine` is 2 x 3, from places in the expected rectangle's frame (region pixels) to columns and rows. Returns
        the shift of the centre along and across the long axis (region pixels), the turn of the axis (radians), and
        whether little of the border is hidden; None if too little of it is visible.
        """
        columns, rows = (self._places @ affine[:, :2].T + affine[:, 2]).astype(np.float32).T
        levels = cv2.remap(grey, columns, rows, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
        samples, beyond_ends = np.split(levels.astype(np.float64).ravel(), [4 * _POINTS * len(_OFFSETS)])
        samples = samples.reshape(4 * _POINTS, -1)
        candidates = white_ends(samples, _OFFSETS, (white + floor) / 2)
        visible = np.isfinite(candidates)
        seen = visible[: 4 * _POINTS]
        if seen.sum() < _LEAST_SHARE * 4 * _POINTS:
            return None
        edges = np.where(visible, candidates, 0.0)
        # A border of which little is hidden needs only its first candidates.
        shown = ~np.repeat(_sides_along_cables(beyond_ends, floor), _POINTS)
        first = edges[: 4 * _POINTS]
        solutions, weights = self._solutions(first, (seen & shown)[None], _CLEAR_CUTOFFS, 0.0)
        if np.count_nonzero(weights) >= _CLEAR_SHARE * np.count_nonzero(shown):
            return (*solutions[0, :3].tolist(), True)
        for spread_cutoff in (0.0, _SPREAD_CUTOFF) if loose else (0.0,):
            solutions, weights = self._solutions(edges, self._trusted & visible, _CUTOFFS, spread_cutoff)
            unusual = np.maximum(np.abs(solutions[:, 3] - _USUAL_GROWTH) - _GROWTH_DEVIATION, 0.0)
            scores = weights.sum(axis=1) - _GROWTH_PENALTY * unusual
            best = int(scores.argmax())
            counts = np.bincount(self._sides[weights[best] > 0], minlength=4)
            if counts.sum() >= _LEAST_SHARE * 4 * _POINTS and (counts >= _LEAST_ON_SIDE).sum() >= 3:
                return (*solutions[best, :3].tolist(), False)
        return None

    def _solutions(
        self, edges: Floats, trusted: NDArray[np.bool_], cutoffs: tuple[float, ...], spread_cutoff: float
    ) -> tuple[Floats, Floats]:
        """Shift, turn and growth of the rectangle for each choice of points to trust first, and all weights."""
        terms, visible = self._terms[: len(edges)], trusted.any(axis=0)
        weights = trusted.astype(np.float64)
        for cutoff in cutoffs:
            weighted = weights[:, None] * terms.T
            solutions = np.linalg.solve(weighted @ terms + self._prior, (weighted @ edges)[..., None])[..., 0]
            squares = (edges - solutions @ terms.T) ** 2
            limits: float | Floats = cutoff * cutoff
            if spread_cutoff > 0:
                spreads = np.median(squares[:, visible], axis=1)
                limits = np.maximum(limits, spread_cutoff**2 * spreads[:, None])
            weights = np.maximum(1 - squares / limits, 0.0) ** 2 * (trusted if cutoff > _COARSE else visible)
        return solutions, weights


def white_ends(samples: Floats, offsets: Floats, middle: float) -> Floats:
    """Where white ends along lines of samples at some offsets: the first place on each line, then the last places.

    A cable may lie within the border. Places are nan on lines where white does not end, and the last ones also where it
    ends only once. `middle` is the grey level between white and not.
    """
    ends = (samples[:, :-1] >= middle) & (samples[:, 1:] < middle)
    first, last = ends.argmax(axis=1), ends.shape[1] - 1 - ends[:, ::-1].argmax(axis=1)
    some = ends.any(axis=1)
    lines = np.arange(len(samples))
    candidates = []
    # The first and the last of no ends lie apart, too.
    for i, found in ((first, some), (last, some & (last > first))):
        inner, outer = samples[lines, i], samples[lines, i + 1]
        shares = (inner - middle) / np.maximum(inner - outer, 1e-9)
        candidates.append(np.where(found, offsets[i] + (offsets[1] - offsets[0]) * shares, np.nan))
    return np.concatenate(candidates)


def _sides_along_cables(levels: Floats, floor: float) -> NDArray[np.bool_]:
    """For each side, whether a cable lies along it, given grey levels beyond its ends.

    Such a cable looks like the black frame. One of two opposite sides is needed: none is given if both have a cable.
    """
    means = levels.reshape(4, 2, len(_ASIDE), len(_BEYOND_ENDS)).mean(axis=3)
    seen: NDArray[np.bool_] = (np.abs(means - floor) > _CABLE_DEVIATION * floor).any(axis=2).all(axis=1)
    return seen & ~seen[_OPPOSITE]


class _HolePattern:
    """Compares upright images of markers with the arrangements of holes in use."""

    def __init__(self, settings: TrackerSettings) -> None:
        arrangements, side = ARRANGEMENTS.get(settings.markers, ARRANGEMENTS["holes"])
        self._readings: list[Reading] = []
        patterns = []
        used = arrangements.keys() if settings.markers == "tags" else settings.numbers
        for number in sorted(used):
            centres = arrangements[number]
            for sign in (1, -1):
                area = len(centres) * (side / MM_PER_PIXEL) ** 2
                self._readings.append(Reading(number, sign > 0, area))
                patterns.append([sum(_hole(sign * x, sign * y, side, blur) for x, y in centres) for blur in _BLURS])
        darkness = _BLACK * np.array(patterns, np.float32)
        self._around = darkness[:, _TYPICAL].max(axis=0) > _AROUND
        # Samples of each arrangement that are white, and clear of the sides.
        inside = np.zeros(_SHAPE, bool)
        inside[_INSIDE] = True
        self._blank = (darkness[:, _TYPICAL] < _AROUND) & inside
        # Arrangement, blur, sample.
        self._patterns = darkness[:, :, self._around]
        self._energies = (self._patterns**2).sum(axis=2)
        self._hole = float(((_BLACK * _hole(0.0, 0.0, side, _BLURS[_TYPICAL])) ** 2).sum())

    def read(self, upright: Frame, level: float) -> Reading:
        """The number and front of a marker; `level` is the grey level of its white."""
        inner = upright[_INSIDE].ravel()
        rank = int(_WHITE * len(inner))
        white = upright / np.float32(max(float(np.partition(inner, rank)[rank]), 0.9 * level))
        rest, visibility = (1 - white).clip(0, 1), None
        crossed = _crossings(rest)
        if crossed:
            rest, visibility = _without_cables(rest, crossed)
        best, misfit, pale = self._best(rest, visibility)
        dark = (rest > (_UNEXPLAINED_BESIDE_CABLES if crossed else _UNEXPLAINED)) & self._blank[best]
        if cv2.erode(dark.astype(np.uint8), _THICK_BESIDE_CABLES if crossed else _THICK).any():
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
        if misfits[best] > min(misfits[second] - _UNCERTAIN, _RATIO * misfits[second]):
            return best, math.inf, pale
        return best, float(by_blur[best].min()), pale


def _hole(x: float, y: float, side: float, blur: float) -> Floats:
    """Darkness from 0 to 1 of a blurred hole in an upright marker; x and y are from its middle in mm."""
    width = math.sqrt(2) * blur * MM_PER_PIXEL
    profiles = []
    for samples, centre in zip(_SHAPE, (y, x), strict=True):
        places = (np.arange(samples) + 0.5 - samples / 2) * _SAMPLE - centre
        profiles.append((erf((places + side / 2) / width) - erf((places - side / 2) / width)) / 2)
    return np.outer(*profiles)


def _without_cables(darkness: Darkness, crossings: list[Crossing]) -> tuple[Darkness, Darkness]:
    """A marker without the cables that cross it, and the share of each sample that no cable hides."""
    visibility = np.ones_like(darkness)
    while len(crossings) > 1:
        one, other = max(combinations(crossings, 2), key=lambda pair: _continuity(darkness, *pair))
        band = _band(darkness, one[:2], other[:2])
        darkness = np.maximum(darkness - band, 0)
        visibility = visibility * np.clip(1 - band / max(float(band.max()), 1e-3), 0, 1)
        crossings = [c for c in crossings if c not in (one, other)]
    return darkness, visibility


def _crossings(darkness: Darkness) -> list[Crossing]:
    """Each place where something dark crosses the ring."""
    values = darkness[_RING[:, 0], _RING[:, 1]]
    values = values - np.median(values)
    if not (values > _CROSSING).any():
        return []
    # Start at a bright sample, so that no crossing is cut in two.
    start = int(np.argmin(values > _CROSSING))
    ring, on_sides, values = np.roll(_RING, -start, 0), np.roll(_ON_SIDES, -start, 1), np.roll(values, -start)
    changes = np.flatnonzero(np.diff(np.append(values > _CROSSING, False).astype(np.int8))) + 1
    crossings = []
    for first, last in changes.reshape(-1, 2).tolist():
        middle = (first + last) // 2
        # A cable along a side of the ring: two places on it.
        along_side = on_sides[:, first:last].sum(axis=1) >= _ALONG_SIDE * on_sides.sum(axis=1)
        parts = [(first, middle), (middle, last)] if along_side.any() else [(first, last)]
        for begin, end in parts:
            part = values[begin:end]
            row, column = part @ ring[begin:end] / part.sum()
            crossings.append((float(row), float(column), float(part.max())))
    darkest = max(darkness for _, _, darkness in crossings)
    return [crossing for crossing in crossings if crossing[2] >= _WEAK * darkest]


def _continuity(darkness: Darkness, one: Crossing, other: Crossing) -> float:
    """Darkness at nine of ten places between two crossings, as a share of the weaker crossing's."""
    rows, columns = (np.rint(one[i] + _SHARES * (other[i] - one[i])).astype(int) for i in (0, 1))
    return float(np.sort(darkness[rows, columns])[len(_SHARES) // 10]) / min(one[2], other[2])


def _band(darkness: Darkness, one: tuple[float, float], other: tuple[float, float]) -> Darkness:
    """The darkness of a straight cable through two crossings: the median of its profiles."""
    start, end = np.array(one), np.array(other)
    length = max(float(np.hypot(*(end - start))), 1.0)
    along = (end - start) / length
    normal = np.array((-along[1], along[0]))
    steps = np.arange(0.0, length + 0.5)
    rows, columns = (((start[i] + steps * along[i])[:, None] + _ACROSS * normal[i]).astype(np.float32) for i in (0, 1))
    profiles = cv2.remap(darkness, columns, rows, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    profile = np.median(profiles.astype(np.float64), axis=0)
    profile = np.maximum(profile - min(profile[0], profile[-1]), 0)
    # The same profile for every sample of the image, by its distance from the line.
    down, right = np.ogrid[: darkness.shape[0], : darkness.shape[1]]
    distances = (down - start[0]) * normal[0] + (right - start[1]) * normal[1]
    band: Darkness = np.interp(distances, _ACROSS, profile, left=0.0, right=0.0).astype(np.float32)
    return band
