"""Calibrations from a few clicked points, through lenses of known distortion: the error all over the picture."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product

import cv2
import numpy as np

from khepera_forage.estimates import Table, Value, pick, table_of
from khepera_forage.vision.calibration import Calibration, Lens, fit_calibration, root_mean_square
from khepera_forage.vision.scene import MM_PER_PIXEL
from khepera_forage.vision.shapes import PICTURE_HEIGHT, PICTURE_WIDTH

Shares = tuple[tuple[float, float], ...]


def _grid(columns: int, rows: int, extent: float = 0.9) -> Shares:
    """Points all over the middle of the picture, as shares of its width and height."""
    edge = (1 - extent) / 2
    across = np.linspace(edge, 1 - edge, columns).tolist()
    down = np.linspace(edge, 1 - edge, rows).tolist()
    return tuple(product(across, down))


LAYOUTS: dict[str, Shares] = {
    "4 corners": _grid(2, 2),
    "4 corners and the middle": (*_grid(2, 2), (0.5, 0.5)),
    "3 x 3": _grid(3, 3),
    "4 x 3": _grid(4, 3),
    "4 x 4": _grid(4, 4),
    "5 x 4": _grid(5, 4),
    "4 x 3 in the middle half": _grid(4, 3, 0.5),
    "5 x 4 in the middle half": _grid(5, 4, 0.5),
}
"""Points in the picture; corners are 5 % of the picture away from its border."""
DISTORTIONS = (0.0, -0.0125, -0.05)
"""k1. With a focal length of 800 pixels, -0.0125 is a k1 of -0.05 in OpenCV's unit."""
_CLICK = 0.5
"""Standard deviation in pixels of a click."""
_FOCAL_LENGTHS, _TILT = (450.0, 900.0), 0.05
"""Shortest and longest focal length in pixels; standard deviation in radians of the turn about each axis."""
_NOTE = (
    "Cameras tilted at random, clicks with an error of 0.5 pixels (2.5 mm), k1 in the unit of the calibration file. "
    "Residual: of the points themselves. Held-out error: each point by the calibration from all others. Error: "
    "everywhere in the picture, also at its border. Root mean squares in mm, medians of the trials."
)


_COLUMNS = {
    "residual": "residual (mm)",
    "held_out": "held-out error (mm)",
    "error": "error (mm)",
    "worst": "greatest error (mm)",
}


@dataclass(frozen=True, slots=True)
class LensTrial:
    """One calibration through a lens of some k1, and whether it has a lens.

    Errors are root mean squares in mm: of the points, of held-out points (nan for four points), and all over the
    picture; `worst` is the greatest error anywhere in it.
    """

    layout: str
    k1: float
    lens: bool
    residual: float
    held_out: float
    error: float
    worst: float


def calibrations(layout: str, seed: int, trials: int) -> list[LensTrial]:
    """Calibrations with one layout of points, through all lenses."""
    rng = np.random.default_rng(seed)
    return [_trial(layout, k1, rng) for _ in range(trials) for k1 in DISTORTIONS]


def _trial(layout: str, k1: float, rng: np.random.Generator) -> LensTrial:
    size = np.array((PICTURE_WIDTH, PICTURE_HEIGHT))
    corners = Calibration.identity().picture
    focal = rng.uniform(*_FOCAL_LENGTHS)
    turn, _ = cv2.Rodrigues(rng.normal(0, _TILT, 3))
    rays = np.column_stack((np.array(corners) - size / 2, np.full(4, focal))) @ turn
    floor = MM_PER_PIXEL * (focal * rays[:, :2] / rays[:, 2:] * (1, -1) + size / 2)
    true = Calibration(corners, tuple(map(tuple, floor.tolist())), lens=Lens(k1) if k1 else None)
    points = np.array(LAYOUTS[layout]) * size
    places = [_place(true, u, v) for u, v in points.tolist()]
    clicks = [(u, v) for u, v in (points + rng.normal(0, _CLICK, points.shape)).tolist()]
    fit = fit_calibration(clicks, places)
    everywhere = (np.array(_grid(13, 10, 1.0)) * size).tolist()
    errors = [math.dist(_place(fit.calibration, u, v), _place(true, u, v)) for u, v in everywhere]
    return LensTrial(
        *(layout, k1, fit.calibration.lens is not None, root_mean_square(fit.residuals)),
        root_mean_square(fit.held_out) if fit.held_out else math.nan,
        *(root_mean_square(errors), max(errors)),
    )


def _place(calibration: Calibration, u: float, v: float) -> tuple[float, float]:
    """The place on the floor that a point of the picture shows, in mm."""
    x, y = calibration.to_region(u, v)
    return x * MM_PER_PIXEL, y * MM_PER_PIXEL


def lenses_table(rows: Sequence[LensTrial]) -> Table:
    """The errors by layout and lens."""
    lines: list[dict[str, Value]] = []
    for layout, k1 in product(LAYOUTS, DISTORTIONS):
        own = pick(rows, layout=layout, k1=k1)
        lens = 100 * sum(row.lens for row in own) / len(own)
        lines.append({"points": layout, "k1": f"{k1:g}", "lens calibrated (%)": lens})
        for name, column in _COLUMNS.items():
            lines[-1][column] = float(np.median([getattr(row, name) for row in own]))
    return table_of("lenses", "Calibration and lens", _NOTE, lines, {"lens calibrated (%)": 0})
