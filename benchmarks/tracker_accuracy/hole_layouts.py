"""Layouts of a marker's holes, compared by a plain threshold and contours, without our tracker."""

import math
from dataclasses import dataclass, replace
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from khepera_forage.estimates import Column, Table, Value, percent
from khepera_forage.vision.rendering.appearance import CameraAppearance
from khepera_forage.vision.rendering.drawing import ImagePose, draw_shapes
from khepera_forage.vision.rendering.frames import Light, marker_shapes
from khepera_forage.vision.scene import MM_PER_PIXEL
from khepera_forage.vision.shapes import MARKER_HOLES, PICTURE_HEIGHT, PICTURE_WIDTH

Holes = tuple[tuple[float, float], ...]
LAYOUTS: dict[str, Holes] = {
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
"""Levels between floor and white. No single level is right in the middle of the image and in its corners."""
_MARKER = 150.0
"""Smallest marker, in square pixels."""
_BORDER = 30
_TILES = 5
"""Markers in a row and in a column of one image."""
_NOTE = (
    "Share of markers, anywhere in the image and at any angle, for which a fixed threshold (at three levels) and a "
    "contour hierarchy, without our tracker's refinements, count the right number of holes. Holes further ahead give a "
    "more reliable heading. Holes nearer to each other and to the rim are closed by less blur."
)


@dataclass(frozen=True, slots=True)
class HoleCount:
    """Markers with one layout of holes at one blur.

    Attributes:
        layout: One of `LAYOUTS`.
        blur: In pixels.
        right: Markers, times thresholds, for which the number of holes was right.
        markers: Markers, times thresholds.
    """

    layout: str
    blur: float
    right: int
    markers: int


class Layout(NamedTuple):
    """One layout of holes at all blurs.

    Attributes:
        name: One of `LAYOUTS`.
        seed: The same for all.
        images: How many, of 25 markers each.
    """

    name: str
    seed: int
    images: int

    @property
    def key(self) -> str:
        """The layout."""
        return f"layout {self.name}"

    def run(self) -> list[HoleCount]:
        """Count the holes at each blur."""
        cv2.setNumThreads(1)
        rows = []
        for blur in BLURS:
            rng = np.random.default_rng(self.seed)
            appearance = replace(CameraAppearance.laboratory(), blur=blur)
            light = Light(appearance, rng)
            holes = LAYOUTS[self.name]
            right = sum(_right(light, appearance, holes, rng, float(i)) for i in range(self.images))
            rows.append(HoleCount(self.name, blur, right, self.images * _TILES**2 * len(_THRESHOLDS)))
        return rows


def table(rows: list[HoleCount]) -> Table:
    """All layouts."""
    lines: list[tuple[Value, ...]] = []
    for name, holes in LAYOUTS.items():
        ahead = sum(x for x, _ in holes) / len(holes) / MM_PER_PIXEL
        ours = "ours" if holes == MARKER_HOLES[len(holes)] else ""
        shares = (percent(row.right, row.markers) for row in rows if row.layout == name)
        lines.append((name, ours, ahead, *shares))
    columns = (
        Column("holes (mm)"),
        Column(""),
        Column("ahead of the middle (px)"),
        *(Column(f"counted right at blur {blur:g} px (%)", estimate=True) for blur in BLURS),
    )
    return Table("markers", "Layouts of the holes", _NOTE, columns, lines)


def _right(
    light: Light, appearance: CameraAppearance, holes: Holes, rng: np.random.Generator, seconds: float
) -> int:
    """Markers in one image, times thresholds, for which the number of holes is right."""
    image = np.full((int(PICTURE_HEIGHT), int(PICTURE_WIDTH)), round(appearance.floor), np.uint8)
    shapes = marker_shapes(appearance, holes)
    xs = np.linspace(_BORDER, PICTURE_WIDTH - _BORDER, _TILES)
    ys = np.linspace(_BORDER, PICTURE_HEIGHT - _BORDER, _TILES)
    for x in xs.tolist():
        for y in ys.tolist():
            dx, dy = rng.uniform(-0.5, 0.5, 2).tolist()
            turn = float(rng.uniform(-math.pi, math.pi))
            pose = ImagePose(x + dx, y + dy, math.cos(turn), math.sin(turn), 1 / MM_PER_PIXEL)
            draw_shapes(image, pose, shapes)
    frame = light.expose(image, seconds)
    return sum(_hole_counts(frame > level).count(len(holes)) for level in _THRESHOLDS)


def _hole_counts(bright: NDArray[np.bool_]) -> list[int]:
    """The number of holes of every large bright region."""
    contours, hierarchy = cv2.findContours(bright.astype(np.uint8), cv2.RETR_CCOMP, cv2.CHAIN_APPROX_NONE)
    parents = hierarchy[0, :, 3].tolist()
    return [
        parents.count(i) for i, c in enumerate(contours) if parents[i] < 0 and cv2.contourArea(c) > _MARKER
    ]
