"""Frames of tags and markers at any resolution, drawn by OpenCV alone: no code of the package draws them."""

import math

import cv2
import numpy as np
from numpy.typing import NDArray

from khepera_forage.vision.shapes import GRID_HOLES, GRID_SIDE, HOLE_SIDE, MARKER_HOLES

Pose = tuple[float, float, float]
"""x and y in mm, heading in radians."""
Picture = NDArray[np.uint8]
_PER_MM = 4
"""Pixels per mm of the sheets that are drawn into the picture."""


def tag_sheet(tag: int, side: float) -> Picture:
    """A tag with a white margin of one cell, its top upwards."""
    cell = round(side * _PER_MM / 6)
    dictionary = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_4X4_50)
    sheet = cv2.aruco.generateImageMarker(dictionary, tag, 6 * cell)
    return np.pad(np.where(sheet > 0, 225, 25).astype(np.uint8), cell, constant_values=225)


def grid_sheet(number: int, thesis: bool = False) -> Picture:
    """A marker of the table of twelve, or one of the thesis's two, its front upwards."""
    holes, side = (MARKER_HOLES[number], HOLE_SIDE) if thesis else (GRID_HOLES[number], GRID_SIDE)
    sheet = np.full((136 * _PER_MM, 96 * _PER_MM), 25, np.uint8)
    sheet[8 * _PER_MM : -8 * _PER_MM, 8 * _PER_MM : -8 * _PER_MM] = 225
    for x, y in holes:
        row, column = round((68 - x) * _PER_MM), round((48 - y) * _PER_MM)
        half = round(side / 2 * _PER_MM)
        sheet[row - half : row + half, column - half : column + half] = 25
    return sheet


class SheetScene:
    """A picture of the floor under a pinhole camera, with sheets and cables on it.

    Args:
        width: Of the picture in pixels.
        height: Of the picture in pixels.
        wide: mm of the floor across the picture.
        rng: Of the noise, or its seed.
        shift: Moves the camera by some mm.
        turn: Turns the camera by some radians.
    """

    def __init__(
        self,
        width: int,
        height: int,
        wide: float = 3200.0,
        rng: int | np.random.Generator = 0,
        shift: tuple[float, float] = (0.0, 0.0),
        turn: float = 0.0,
    ) -> None:
        self.width, self.height, self.scale = width, height, width / wide
        self.rng = np.random.default_rng(rng)
        self.picture = np.full((height, width), 105.0, np.float32)
        cos, sin = math.cos(turn) * self.scale, math.sin(turn) * self.scale
        # From mm to pixels: the floor's y is up.
        self.matrix = np.array(
            [[cos, -sin, -shift[0] * self.scale], [-sin, -cos, height + shift[1] * self.scale], [0, 0, 1.0]]
        )

    def pixel(self, x: float, y: float) -> tuple[float, float]:
        """Where the picture shows a place in mm."""
        u, v, _ = self.matrix @ (x, y, 1.0)
        return float(u), float(v)

    def put(self, sheet: Picture, pose: Pose) -> None:
        """Lay a sheet with its top in the direction of the heading."""
        x, y, heading = pose
        turn = math.atan2(self.matrix[0, 1], -self.matrix[1, 1])  # of the camera
        ratio = 1 / _PER_MM
        (u, v), reach = self.pixel(x, y), math.ceil(math.hypot(*sheet.shape) / 2 * ratio * self.scale) + 2
        left, top, size, fine = int(u) - reach, int(v) - reach, 2 * reach, 8
        # Drawn eightfold, then averaged.
        middle = (np.array(sheet.shape[::-1]) - 1) / 2
        degrees = math.degrees(heading - turn) - 90
        warp = cv2.getRotationMatrix2D(middle.tolist(), degrees, fine * ratio * self.scale)
        warp = np.column_stack((warp[:, :2], warp[:, 2] + np.array((u - left, v - top)) * fine - 0.5 - middle))
        mask = cv2.warpAffine(np.full_like(sheet, 255), warp, (fine * size,) * 2, flags=cv2.INTER_NEAREST)
        drawn = np.where(mask > 0, cv2.warpAffine(sheet, warp, (fine * size,) * 2), 0).astype(np.float32)
        share = cv2.resize(mask, (size, size), interpolation=cv2.INTER_AREA) / np.float32(255)
        grey = cv2.resize(drawn, (size, size), interpolation=cv2.INTER_AREA)
        # Without what lies outside of the picture.
        rows = slice(max(0, -top), min(size, self.height - top))
        columns = slice(max(0, -left), min(size, self.width - left))
        part = self.picture[max(0, top) : top + size, max(0, left) : left + size]
        part[:] = part * (1 - share[rows, columns]) + grey[rows, columns]

    def cable(self, x: float, y: float, angle: float, width: float) -> None:
        """A dark cable through a place, 160 mm long to either side."""
        along = 160 * np.array((math.cos(angle), math.sin(angle)))
        start, end = (np.array(self.pixel(x + sign * along[0], y + sign * along[1])) for sign in (-1, 1))
        self.line(start, end, width * self.scale, 55.0)

    def line(self, start: NDArray[np.float64], end: NDArray[np.float64], width: float, grey: float) -> None:
        """Draw a line in the picture, between two points in pixels."""
        mask = np.zeros((self.height, self.width), np.uint8)
        (x1, y1), (x2, y2) = (np.rint(16 * (point - 0.5)).astype(int).tolist() for point in (start, end))
        cv2.line(mask, (x1, y1), (x2, y2), 255, max(1, round(width)), cv2.LINE_AA, 4)
        self.picture += (grey - self.picture) * (mask / np.float32(255))

    def frame(self, blur: float = 0.7, noise: float = 2.5) -> Picture:
        """What the camera delivers."""
        soft = cv2.GaussianBlur(self.picture, (0, 0), blur)
        grain = self.rng.standard_normal(soft.shape, np.float32) * np.float32(noise)
        frame: Picture = (soft + grain).clip(0, 255).astype(np.uint8)
        return frame
