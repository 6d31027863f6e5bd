"""The centre of a disc that is partly hidden, from the rim that is still visible."""

import math

import numpy as np
from numpy.typing import NDArray

from khepera_forage.vision.calibration import Calibration
from khepera_forage.vision.detection.image_patch import ImagePatch, ShapeMoments

_ROUND = 0.98
"""Ratio of the axes from which a shape is taken for a whole disc: at most 1 % of it is then hidden."""
_RAYS = 36
_STEP = 0.25
"""Region pixels from one sample of a ray to the next."""
_INSIDE, _OUTSIDE = 2.0, 2.0
"""Region pixels by which rays begin within the radius, and end beyond it."""
_HIDDEN = 0.12
"""Region pixels by which the shape ends before the disc's rim where something hides it."""
_LEAST_RAYS = 15
"""Rays to the visible rim from which the centre is known."""
_REPEATS = 8

_ANGLES = 2 * math.pi * np.arange(_RAYS) / _RAYS
_DIRECTIONS = np.stack((np.cos(_ANGLES), np.sin(_ANGLES)), axis=1)
_TERMS = np.column_stack((_DIRECTIONS, np.ones(_RAYS)))
"""How the edge along each ray changes with a shift of the centre, to first order, and with the radius, which blur and
brightness change a little."""


def with_true_centre(
    patch: ImagePatch,
    moments: ShapeMoments,
    calibration: Calibration,
    radius: float,
    height: float,
    always: bool = False,
) -> ShapeMoments:
    """The moments of a disc with the centre of the whole disc, if a part of it is hidden.

    What hides a part, such as the black frame of a marker, shifts the centre of the rest. Rays from there find the
    edge of the shape in all directions; a circle through the edge is the rim, without the points that lie inside it.

    Args:
        patch: Contains the disc.
        moments: Of its visible part.
        calibration: From the picture to the floor.
        radius: Of the disc, region pixels.
        height: Of the disc above the floor in mm.
        always: Whether a round shape may be a part, too.

    Returns:
        The moments themselves for a round shape, or if too little of the rim is visible.
    """
    if moments.minor >= _ROUND * moments.major and not always:
        return moments
    jacobian = calibration.jacobian(moments.u, moments.v, height)
    inverse = np.linalg.inv(np.array(jacobian).reshape(2, 2))
    edges = _edges(patch, moments, inverse, radius)
    visible = np.isfinite(edges)
    shift = np.zeros(3)
    for _ in range(_REPEATS):
        if visible.sum() < _LEAST_RAYS:
            return moments
        shift = np.linalg.lstsq(_TERMS[visible], edges[visible] - radius, rcond=None)[0]
        residuals = edges - radius - _TERMS @ shift
        # A quarter of the rays at a time, because the hidden part of the rim has shifted the circle, too.
        worst = np.quantile(residuals[visible], 0.25)
        hidden = visible & (residuals < -_HIDDEN) & (residuals <= worst)
        if not hidden.any():
            break
        visible &= ~hidden
    du, dv = inverse @ shift[:2]
    u, v = moments.u + float(du), moments.v + float(dv)
    x, y = calibration.to_region(u, v, height)
    return moments._replace(u=u, v=v, x=x, y=y)


def _edges(
    patch: ImagePatch, moments: ShapeMoments, to_picture: NDArray[np.float64], radius: float
) -> NDArray[np.float64]:
    """Distance from the centre to the edge of the shape along each ray, region pixels; not a number without edge."""
    import cv2

    along = np.arange(max(0.0, radius - _INSIDE), radius + _OUTSIDE, _STEP)
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
    dark = grey < middle
    first = dark.argmax(axis=1)
    rays = np.arange(_RAYS)
    inner, outer = grey[rays, np.maximum(first - 1, 0)], grey[rays, first]
    with np.errstate(divide="ignore", invalid="ignore"):
        edges = along[first] - _STEP * (middle - outer) / (inner - outer)
    return np.where(first > 0, edges, np.nan).astype(np.float64)
