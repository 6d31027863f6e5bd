"""Pose of a marker from its four sides: points on the sides, and the rectangle that most of them lie on.

A cable hides a part of a marker, or cuts its border. The centre of mass of the rest is then shifted and turned, but
the visible parts of the sides are where they were. Points that fit no rectangle are left out, so that cables, food and
fingers at the border do not move the result.
"""

import cv2
import numpy as np
from numpy.typing import NDArray

from khepera_forage.vision.detection.segmentation import Frame

_POINTS = 13
"""Points on each side: as many on a short one as on a long one, so that three sides always outvote one."""
_SHARE = 0.84
"""Share of a side, around its middle, on which points are taken: blur rounds the corners."""
_REACH, _STEP = 5.0, 0.5
"""Region pixels within which a side is searched on either side of its expected place, and between two samples."""
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
_DARK, _DARK_BONUS = 0.85, 2.0
"""Share of the floor's brightness below which a sample counts as dark; and the number of points that a region pixel of
darkness beyond a side is worth when it is decided which side is hidden."""
_BEHIND, _FLOOR_DEVIATION = (2.6, 5.4), 0.15
"""Region pixels from the end of white where a visible side has floor: beyond the black frame and its blur. And the
share of the floor's brightness by which it differs at most."""
_USUAL_DIFFERENCE = 0.4
"""Region pixels by which sides differ in this without a cable."""
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
_OFFSETS = np.arange(-_REACH, _REACH + _STEP / 2, _STEP)


class RectangleFit:
    """Fits rectangles of one size.

    Args:
        length: Long side in region pixels.
        width: Short side in region pixels.
    """

    def __init__(self, length: float, width: float) -> None:
        half = np.array((length, width)) / 2
        normals = np.repeat(_SIDES, _POINTS, axis=0)
        shares = np.tile(np.linspace(-_SHARE, _SHARE, _POINTS), 4)[:, None]
        places = (normals + shares * (1 - np.abs(normals))) * half
        samples = places[:, None, :] + normals[:, None, :] * _OFFSETS[:, None]
        # Beyond both ends of each side, where a cable along it would be.
        end, aside, beyond = np.meshgrid((1, -1), _ASIDE, _BEYOND_ENDS, indexing="ij")
        normal = _SIDES[:, None, None, None, :]
        ends = normal * (half + aside[..., None]) + (1 - np.abs(normal)) * end[..., None] * (
            half + beyond[..., None]
        )
        self._places = np.concatenate((samples.reshape(-1, 2), ends.reshape(-1, 2)))
        # Outward shift of each point with the centre, the turn, and the size: blur, exposure and paper move all sides
        # about equally.
        levers = normals[:, 1] * places[:, 0] - normals[:, 0] * places[:, 1]
        terms = np.column_stack((normals, levers, np.ones(len(places))))
        # Two candidates for each point.
        self._terms = np.concatenate((terms, terms))
        self._products = (self._terms[:, :, None] * self._terms[:, None, :]).reshape(-1, 16)
        sides = np.repeat(np.arange(4), _POINTS)
        self._sides = np.concatenate((sides, sides))
        # First all sides where their white ends first; then each side where its white ends last.
        self._trusted = np.stack(
            [np.concatenate((sides != hidden, sides == hidden)) for hidden in (-1, 0, 1, 2, 3)]
        )
        # Keeps the solution finite when too few points are visible.
        self._prior = 1e-3 * np.diag((1.0, 1.0, half[0] ** 2, 1.0))

    def fit(
        self, grey: Frame, affine: NDArray[np.float64], white: float, floor: float, loose: bool
    ) -> tuple[float, float, float, bool] | None:
        """The rectangle near an expected pose.

        Args:
            grey: Grey levels of the frame.
            affine: 2 x 3: from places in the expected rectangle's own frame (region pixels) to columns and rows.
            white: Grey level of the marker.
            floor: Grey level of the floor around it.
            loose: Whether points far from the rectangle count, too, if no rectangle fits exactly.

        Returns:
            Shift of the centre along and across the expected long axis (region pixels), turn of the axis (radians), and
            whether little of the border is hidden; None if too little of it is visible.
        """
        columns, rows = (self._places @ affine[:, :2].T + affine[:, 2]).astype(np.float32).T
        levels = cv2.remap(grey, columns, rows, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
        samples, beyond_ends = np.split(levels.astype(np.float64).ravel(), [4 * _POINTS * len(_OFFSETS)])
        samples = samples.reshape(4 * _POINTS, -1)
        edges = _edges(samples, (white + floor) / 2)
        visible = np.isfinite(edges)
        seen = visible[: 4 * _POINTS]
        if seen.sum() < _LEAST_SHARE * 4 * _POINTS:
            return None
        edges = np.where(visible, edges, 0.0)
        # A border of which little is hidden needs only its first candidates.
        shown = ~np.repeat(_sides_along_cables(beyond_ends, floor), _POINTS)
        first = edges[: 4 * _POINTS]
        solutions, weights = self._solutions(first, (seen & shown)[None], _CLEAR_CUTOFFS, 0.0)
        if np.count_nonzero(weights) >= _CLEAR_SHARE * np.count_nonzero(shown):
            return (*solutions[0, :3].tolist(), True)
        # Of two sides of which one must be hidden, it is the one with more darkness outside: the cable's.
        # Behind a cable that leaves a strip of the marker there is something else than floor, too.
        beyond = _OFFSETS - first[:, None]
        behind = (beyond >= _BEHIND[0]) & (beyond <= _BEHIND[1]) & seen[:, None]
        other = behind & (np.abs(samples - floor) > _FLOOR_DEVIATION * floor)
        dark = (samples < _DARK * floor).sum(axis=1) + other.sum(axis=1)
        strange = dark.reshape(4, -1).mean(axis=1) * _STEP
        bonus = np.maximum(strange - strange.min() - _USUAL_DIFFERENCE, 0.0) * _DARK_BONUS
        for spread_cutoff in (0.0, _SPREAD_CUTOFF) if loose else (0.0,):
            solutions, weights = self._solutions(edges, self._trusted & visible, _CUTOFFS, spread_cutoff)
            unusual = np.maximum(np.abs(solutions[:, 3] - _USUAL_GROWTH) - _GROWTH_DEVIATION, 0.0)
            scores = weights.sum(axis=1) + np.append(0.0, bonus) - _GROWTH_PENALTY * unusual
            best = int(scores.argmax())
            fitting = weights[best] > 0
            counts = np.bincount(self._sides[fitting], minlength=4)
            if fitting.sum() >= _LEAST_SHARE * 4 * _POINTS and (counts >= _LEAST_ON_SIDE).sum() >= 3:
                return (*solutions[best, :3].tolist(), False)
        return None

    def _solutions(
        self,
        edges: NDArray[np.float64],
        trusted: NDArray[np.bool_],
        cutoffs: tuple[float, ...],
        spread_cutoff: float,
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Shift, turn and growth of the rectangle for each choice of trusted points, and the weight of each point.

        In the beginning only the trusted points count; near the end, all visible ones that fit.
        """
        terms, products = self._terms[: len(edges)], self._products[: len(edges)]
        visible = trusted.any(axis=0)
        weights = trusted.astype(np.float64)
        for cutoff in cutoffs:
            matrices = (weights @ products).reshape(-1, 4, 4) + self._prior
            solutions = np.linalg.solve(matrices, ((weights * edges) @ terms)[..., None])[..., 0]
            squares = (edges - solutions @ terms.T) ** 2
            limits: float | NDArray[np.float64] = cutoff * cutoff
            if spread_cutoff > 0:
                spreads = np.median(squares[:, visible], axis=1)
                limits = np.maximum(limits, spread_cutoff**2 * spreads[:, None])
            weights = np.maximum(1 - squares / limits, 0.0) ** 2 * (trusted if cutoff > _COARSE else visible)
        return solutions, weights


def _edges(samples: NDArray[np.float64], middle: float) -> NDArray[np.float64]:
    """Outward distances of the border from its expected place, region pixels: two candidates for each point.

    First the places where white ends first. Then those where it ends last, for a cable may lie within the border.
    They are nan if white does not end, and if it ends only once.
    """
    ends = (samples[:, :-1] >= middle) & (samples[:, 1:] < middle)
    first, last = ends.argmax(axis=1), ends.shape[1] - 1 - ends[:, ::-1].argmax(axis=1)
    some = ends.any(axis=1)
    points = np.arange(len(samples))
    candidates = []
    # The first and the last of no ends lie apart, too.
    for i, found in ((first, some), (last, some & (last > first))):
        inner, outer = samples[points, i], samples[points, i + 1]
        shares = (inner - middle) / np.maximum(inner - outer, 1e-9)
        candidates.append(np.where(found, _OFFSETS[i] + _STEP * shares, np.nan))
    return np.concatenate(candidates)


def _sides_along_cables(levels: NDArray[np.float64], floor: float) -> NDArray[np.bool_]:
    """For each side, whether a cable lies along it, given grey levels beyond its ends.

    Such a cable covers only a fraction of a pixel of the white, and looks like the black frame. Of two opposite sides
    one is needed to measure the marker: if something lies along both, neither is given.
    """
    means = levels.reshape(4, 2, len(_ASIDE), len(_BEYOND_ENDS)).mean(axis=3)
    seen: NDArray[np.bool_] = (np.abs(means - floor) > _CABLE_DEVIATION * floor).any(axis=2).all(axis=1)
    return seen & ~seen[_OPPOSITE]
