"""Pose of a marker from its four sides: points on the sides, and the rectangle that most of them lie on.

A cable hides a part of a marker, or cuts its border. The centre of mass of the rest is then shifted and turned, but
the visible parts of the sides are where they were. Points that fit no rectangle are left out, so that cables, food and
fingers at the border do not move the result.
"""

from typing import NamedTuple

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
_USUAL_GROWTH, _GROWTH_DEVIATION = -0.45, 0.6
"""Region pixels by which blur and exposure move all sides outwards, and by which they differ from it at most: measured
over all disturbances of `benchmarks/tracker.py`."""
_GROWTH_PENALTY = 10.0
"""Number of points that every further region pixel costs when it is decided which side is hidden: a marker that seems
too small has its border where a cable begins."""
_LEAST_SHARE = 0.35
"""Share of all points that must lie on the rectangle."""
_LEAST_ON_SIDE = 3
"""Points from which a side counts as seen; three sides must be."""

_BEYOND_ENDS = (5.0, 6.0, 7.0)
"""Region pixels beyond the end of a side where the floor is looked at: beyond the black frame and its blur, even of a
marker that appears 15 % too large."""
_ASIDE = (-3.0, -2.0, -1.0, 0.0, 1.0, 2.0, 3.0)
"""Region pixels from the line of the side, outwards, where a cable is looked for: with it, cables that make an angle of
up to 10 degrees with the side are found."""
_CABLE_DEVIATION = 0.1
"""Share of the floor's brightness by which a cable differs from it: a grey one, 4 mm wide and blurred, differs by 0.15
to 0.2, and floor with its texture, noise and light by up to 0.09."""
_OPPOSITE = [1, 0, 3, 2]
"""Number of the side that is opposite to each: front, back, left, right."""


class Rectangle(NamedTuple):
    """A rectangle in the picture.

    Attributes:
        shift: Of the centre along and across the expected long axis, region pixels.
        turn: Of the long axis, radians.
        clear: Whether little of its border is hidden.
    """

    shift: tuple[float, float]
    turn: float
    clear: bool


class RectangleFit:
    """Fits rectangles of one size.

    Args:
        length: Long side in region pixels.
        width: Short side in region pixels.
    """

    def __init__(self, length: float, width: float) -> None:
        a, b = length / 2, width / 2
        shares = np.linspace(-_SHARE, _SHARE, _POINTS)
        ones, none = np.ones(_POINTS), np.zeros(_POINTS)
        # Front, back, left and right side.
        places = np.concatenate(
            [np.column_stack((sign * a * ones, b * shares)) for sign in (1, -1)]
            + [np.column_stack((a * shares, sign * b * ones)) for sign in (1, -1)]
        )
        normals = np.concatenate(
            [np.column_stack((sign * ones, none)) for sign in (1, -1)]
            + [np.column_stack((none, sign * ones)) for sign in (1, -1)]
        )
        sides = np.repeat(np.arange(4), _POINTS)
        self._offsets = np.arange(-_REACH, _REACH + _STEP / 2, _STEP)
        samples = places[:, None, :] + normals[:, None, :] * self._offsets[:, None]
        self._places = np.concatenate((samples.reshape(-1, 2), _places_beyond_ends(length, width)))
        # Outward shift of each point with the centre, the turn, and the size: blur, exposure and paper move all sides
        # about equally.
        levers = normals[:, 1] * places[:, 0] - normals[:, 0] * places[:, 1]
        terms = np.column_stack((normals, levers, np.ones(len(places))))
        # Two candidates for each point.
        self._terms = np.concatenate((terms, terms))
        self._products = (self._terms[:, :, None] * self._terms[:, None, :]).reshape(-1, 16)
        self._sides = np.concatenate((sides, sides))
        self._points = len(places)
        # First all sides where their white ends first; then each side where its white ends last.
        self._trusted = np.stack(
            [np.concatenate((sides != hidden, sides == hidden)) for hidden in (-1, 0, 1, 2, 3)]
        )
        # Keeps the solution finite when too few points are visible.
        self._prior = 1e-3 * np.diag((1.0, 1.0, a * a, 1.0))

    def fit(
        self, grey: Frame, affine: NDArray[np.float64], white: float, floor: float, loose: bool
    ) -> Rectangle | None:
        """The rectangle near an expected pose.

        Args:
            grey: Grey levels.
            affine: 2 x 3: from places in the expected rectangle's own frame (region pixels) to columns and rows.
            white: Grey level of the marker.
            floor: Grey level of the floor around it.
            loose: Whether points far from the rectangle count, too, if no rectangle fits exactly.

        Returns:
            None if too little of the border is visible.
        """
        levels = self._sampled(grey, affine)
        border = self._points * len(self._offsets)
        samples = levels[:border].reshape(self._points, -1)
        edges = self._edges(samples, (white + floor) / 2)
        visible = np.isfinite(edges)
        if visible[: self._points].sum() < _LEAST_SHARE * self._points:
            return None
        edges = np.where(visible, edges, 0.0)
        first = edges[: self._points]
        # A border of which little is hidden needs only its first candidates, and only one choice of trusted points.
        points = self._points
        shown = ~np.repeat(_sides_along_cables(levels[border:], floor), _POINTS)
        solution = self._clear_solution(edges[:points], visible[:points], shown)
        if solution is not None:
            return _rectangle(solution, clear=True)
        # Of two sides of which one must be hidden, it is the one with more darkness outside: the cable's.
        # Behind a cable that leaves a strip of the marker there is something else than floor, too.
        beyond = self._offsets - first[:, None]
        behind = (beyond >= _BEHIND[0]) & (beyond <= _BEHIND[1]) & visible[:points, None]
        other = behind & (np.abs(samples - floor) > _FLOOR_DEVIATION * floor)
        strange = ((samples < _DARK * floor).sum(axis=1) + other.sum(axis=1)).reshape(4, -1).mean(
            axis=1
        ) * _STEP
        bonus = _DARK_BONUS * np.concatenate(
            ([0.0], np.maximum(strange - strange.min() - _USUAL_DIFFERENCE, 0.0))
        )
        trusted = self._trusted & visible
        for spread_cutoff in (0.0, _SPREAD_CUTOFF) if loose else (0.0,):
            solutions, weights = self._solutions(edges, trusted, _CUTOFFS, spread_cutoff)
            unusual = np.maximum(np.abs(solutions[:, 3] - _USUAL_GROWTH) - _GROWTH_DEVIATION, 0.0)
            best = int((weights.sum(axis=1) + bonus - _GROWTH_PENALTY * unusual).argmax())
            fitting = weights[best] > 0
            counts = np.bincount(self._sides[fitting], minlength=4)
            if fitting.sum() >= _LEAST_SHARE * points and (counts >= _LEAST_ON_SIDE).sum() >= 3:
                return _rectangle(solutions[best], clear=False)
        return None

    def _clear_solution(
        self, edges: NDArray[np.float64], visible: NDArray[np.bool_], shown: NDArray[np.bool_]
    ) -> NDArray[np.float64] | None:
        """Shift, turn and growth of a rectangle of which little is hidden; None if more is.

        Args:
            edges: Outward distances of the border at each point.
            visible: Whether the border was found there.
            shown: Whether the point is on a side that no cable lies along.
        """
        import cv2

        terms, products = self._terms[: self._points], self._products[: self._points]
        solution = np.zeros(4)
        weights = usable = (visible & shown).astype(np.float64)
        least = _CLEAR_SHARE * np.count_nonzero(shown)
        for cutoff in _CLEAR_CUTOFFS:
            # For one small system, several times faster than numpy.
            matrix = (weights @ products).reshape(4, 4) + self._prior
            vector = ((weights * edges) @ terms)[:, None]
            solution = cv2.solve(matrix, vector, flags=cv2.DECOMP_CHOLESKY)[1].ravel()  # type: ignore[assignment] # float64
            residuals = edges - terms @ solution
            weights = np.maximum(1 - residuals * residuals / (cutoff * cutoff), 0.0) ** 2 * usable
            # The cutoffs fall, so points that do not fit now hardly do in the end.
            if np.count_nonzero(weights) < least:
                return None
        return solution

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
        terms, products = self._terms, self._products
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
        return np.asarray(solutions, np.float64), np.asarray(weights, np.float64)

    def _sampled(self, grey: Frame, affine: NDArray[np.float64]) -> NDArray[np.float64]:
        """Grey levels across the border at each point, from inside to outside, and beyond the ends of the sides."""
        import cv2

        places = (self._places @ affine[:, :2].T + affine[:, 2]).astype(np.float32)
        columns, rows = places.T
        levels = cv2.remap(grey, columns, rows, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
        return levels.astype(np.float64).ravel()

    def _edges(self, samples: NDArray[np.float64], middle: float) -> NDArray[np.float64]:
        """Outward distances of the border from its expected place, region pixels: two candidates for each point.

        First the places where white ends first. Then those where it ends last, for a cable may lie within the border.
        They are nan if white does not end, and if it ends only once.
        """
        ends = (samples[:, :-1] >= middle) & (samples[:, 1:] < middle)
        points = np.arange(self._points)
        first, last = ends.argmax(axis=1), ends.shape[1] - 1 - ends[:, ::-1].argmax(axis=1)
        candidates = []
        # The first and the last of no ends lie apart, too.
        some = ends.any(axis=1)
        for i, found in ((first, some), (last, some & (last > first))):
            inner, outer = samples[points, i], samples[points, i + 1]
            shares = (inner - middle) / np.maximum(inner - outer, 1e-9)
            candidates.append(np.where(found, self._offsets[i] + _STEP * shares, np.nan))
        return np.concatenate(candidates)


def _rectangle(solution: NDArray[np.float64], clear: bool) -> Rectangle:
    a, b, turn = solution[:3].tolist()
    return Rectangle((a, b), turn, clear)


def _places_beyond_ends(length: float, width: float) -> NDArray[np.float64]:
    """Where to look for cables.

    Args:
        length: Of the rectangle: its extent along x, region pixels.
        width: Its extent along y.

    Returns:
        x and y from its centre, for front, back, left and right side; shape (places, 2).
    """
    a, b = length / 2, width / 2
    ends = [(end, aside, beyond) for end in (1, -1) for aside in _ASIDE for beyond in _BEYOND_ENDS]
    across = [(sign * (a + aside), end * (b + beyond)) for sign in (1, -1) for end, aside, beyond in ends]
    along = [(end * (a + beyond), sign * (b + aside)) for sign in (1, -1) for end, aside, beyond in ends]
    return np.array(across + along)


def _sides_along_cables(levels: NDArray[np.float64], floor: float) -> NDArray[np.bool_]:
    """For each side, whether a cable lies along it, which goes on beyond both of its ends.

    Such a cable covers only a fraction of a pixel of the white, and looks like the black frame.

    Of two opposite sides one is needed to measure the marker: if something lies along both, neither is given.

    Args:
        levels: Grey levels at `_places_beyond_ends`.
        floor: Grey level of the floor.
    """
    means = levels.reshape(4, 2, len(_ASIDE), len(_BEYOND_ENDS)).mean(axis=3)
    seen: NDArray[np.bool_] = (np.abs(means - floor) > _CABLE_DEVIATION * floor).any(axis=2).all(axis=1)
    return seen & ~seen[_OPPOSITE]
