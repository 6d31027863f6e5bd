"""Where a marker's holes are best: several places, judged by a bare threshold and contours, without our tracker."""

import math
from dataclasses import dataclass, replace

import cv2
import numpy as np
from numpy.typing import NDArray

from khepera_forage.thesis.statistics import Estimate, wilson
from khepera_forage.thesis.tables import Column, Table, Value
from khepera_forage.vision.rendering.appearance import CameraAppearance
from khepera_forage.vision.rendering.canvas import ImagePose, draw_shapes
from khepera_forage.vision.rendering.frames import marker_shapes
from khepera_forage.vision.rendering.light import Light
from khepera_forage.vision.scene import MM_PER_PIXEL
from khepera_forage.vision.shapes import MARKER_HOLES, PICTURE_HEIGHT, PICTURE_WIDTH

LAYOUTS: dict[str, tuple[tuple[float, float], ...]] = {
    "one, 35 mm ahead": ((35, 0),),
    "one, 30 mm ahead": ((30, 0),),
    "one, 25 mm ahead": ((25, 0),),
    "one, in the middle": ((0, 0),),
    "two along, 40 and 0": ((40, 0), (0, 0)),
    "two along, 35 and -5": ((35, 0), (-5, 0)),
    "two along, 30 and -5": ((30, 0), (-5, 0)),
    "two along, 30 and -10": ((30, 0), (-10, 0)),
    "two along, 30 and -30": ((30, 0), (-30, 0)),
    "two across, 30 ahead": ((30, 17.5), (30, -17.5)),
}
"""Centres of holes in mm, x forward and y left."""
BLURS = (0.7, 1.0, 1.3, 1.6)
_THRESHOLDS = (140, 155, 170)
"""Levels between floor and white: one that is right in the middle of the picture is not in its corners."""
_LARGE = 150.0
"""Square pixels that a marker has at least."""
_BORDER = 30
_TILES = 5
"""Markers in a row and in a column of one picture."""


@dataclass(frozen=True, slots=True)
class Places:
    """One layout, many times.

    Attributes:
        name: In `LAYOUTS`.
        seed: The same for all.
        pictures: How many, of 25 markers each.
    """

    name: str
    seed: int
    pictures: int

    def run(self) -> tuple[str, list[Estimate]]:
        """Name, and the share of markers whose holes a threshold counts right, for each blur."""
        cv2.setNumThreads(1)
        holes = LAYOUTS[self.name]
        shares = []
        for blur in BLURS:
            rng = np.random.default_rng(self.seed)
            look = replace(CameraAppearance.laboratory(), blur=blur)
            light = Light(look, rng)
            right = sum(_right(light, look, holes, rng, float(i)) for i in range(self.pictures))
            shares.append(
                Estimate(*(100 * v for v in wilson(right, self.pictures * _TILES**2 * len(_THRESHOLDS))))
            )
        return self.name, shares


def table(results: list[tuple[str, list[Estimate]]]) -> Table:
    """All layouts."""
    rows: list[tuple[Value, ...]] = []
    for name, shares in results:
        holes = LAYOUTS[name]
        ahead = sum(x for x, _ in holes) / len(holes) / MM_PER_PIXEL
        ours = "ours" if holes == MARKER_HOLES[len(holes)] else ""
        rows.append((name, ours, ahead, *shares))
    columns = (
        Column("holes (mm)"),
        Column(""),
        Column("ahead of the middle (px)"),
        *(Column(f"counted right at blur {blur:g} px (%)", estimate=True) for blur in BLURS),
    )
    note = (
        "Share of markers, anywhere in the picture and any way round, of which a fixed threshold (at three levels) and "
        "a contour hierarchy, without our tracker's refinements, count the right number of holes. The further ahead "
        "the holes are, the surer is the heading; the nearer to each other and to the rim, the sooner blur closes the "
        "gap."
    )
    return Table("tracker_markers", "Where the holes are", note, columns, rows)


def _right(
    light: Light,
    look: CameraAppearance,
    holes: tuple[tuple[float, float], ...],
    rng: np.random.Generator,
    seconds: float,
) -> int:
    """Of the markers in one picture, times the thresholds, those whose holes are counted right."""
    picture = np.full((int(PICTURE_HEIGHT), int(PICTURE_WIDTH)), round(look.floor), np.uint8)
    parts = marker_shapes(look, holes)
    xs = np.linspace(_BORDER, PICTURE_WIDTH - _BORDER, _TILES)
    ys = np.linspace(_BORDER, PICTURE_HEIGHT - _BORDER, _TILES)
    for x in xs.tolist():
        for y in ys.tolist():
            dx, dy = rng.uniform(-0.5, 0.5, 2).tolist()
            turn = float(rng.uniform(-math.pi, math.pi))
            draw_shapes(
                picture, ImagePose(x + dx, y + dy, math.cos(turn), math.sin(turn), 1 / MM_PER_PIXEL), parts
            )
    frame = light.expose(picture, seconds)
    return sum(_counts(frame > level).count(len(holes)) for level in _THRESHOLDS)


def _counts(bright: NDArray[np.bool_]) -> list[int]:
    """The number of holes of every large bright region."""
    contours, hierarchy = cv2.findContours(bright.astype(np.uint8), cv2.RETR_CCOMP, cv2.CHAIN_APPROX_NONE)
    parents = hierarchy[0, :, 3].tolist()
    return [
        parents.count(i) for i, c in enumerate(contours) if parents[i] < 0 and cv2.contourArea(c) > _LARGE
    ]
