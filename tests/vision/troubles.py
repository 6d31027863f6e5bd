"""Frames of a laboratory with one trouble each: glare, shadows, covers, pale print, bright walls, crossing cables.

Each function takes a frame's picture before lens and sensor (`FrameRenderer.picture`) and one marker.
"""

import math
from collections.abc import Callable

import cv2
import numpy as np
from numpy.typing import NDArray

from khepera_forage.vision.rendering import draw_cable
from khepera_forage.vision.shapes import MARKER_HOLES
from tests.vision.scene_renderer import Marker

Picture = NDArray[np.uint8]
Trouble = Callable[[Picture, Marker, np.random.Generator], Picture]
ROW, COLUMN = np.mgrid[:480, :640] + 0.5


def brightened(picture: Picture, x: float, y: float, amplitude: float, size: float) -> Picture:
    """The picture with the reflection of a lamp: a Gaussian of some pixels around a place in mm."""
    squares = (COLUMN - x / 5) ** 2 + (480 - ROW - y / 5) ** 2
    bright: Picture = (picture + amplitude * np.exp(-squares / (2 * size**2))).clip(0, 255).astype(np.uint8)
    return bright


def glare(picture: Picture, marker: Marker, rng: np.random.Generator) -> Picture:
    """A reflection over the front hole, or the back one, of a marker."""
    x, y, heading, holes = marker
    ahead = float(rng.choice([hole[0] for hole in MARKER_HOLES[holes]])) + rng.uniform(-6, 6)
    size = rng.uniform(3, 6)
    x, y = x + ahead * math.cos(heading), y + ahead * math.sin(heading)
    return brightened(picture, x, y, rng.uniform(120, 250), size)


def _beyond(marker: Marker, angle: float, distance: float) -> NDArray[np.float64]:
    """For each pixel, by how many pixels it lies beyond a line at a distance (mm) from a marker's middle."""
    beyond: NDArray[np.float64] = (
        (COLUMN - marker[0] / 5) * math.cos(angle)
        + (480 - ROW - marker[1] / 5) * math.sin(angle)
        - distance / 5
    )
    return beyond


def _distance_for(share: float, turn: float) -> float:
    """Distance in mm from the middle of a line that cuts a share off a marker, at an angle to its axis."""
    x, y = np.mgrid[-60:61:2, -40:41:2]
    return float(np.quantile(x * math.cos(turn) + y * math.sin(turn), 1 - share))


def cover(picture: Picture, marker: Marker, rng: np.random.Generator) -> Picture:
    """A cover of the floor's colour over 20 to 30 % of a marker."""
    turn = rng.uniform(-math.pi, math.pi)
    beyond = _beyond(marker, marker[2] + turn, _distance_for(rng.uniform(0.2, 0.3), turn))
    near = np.hypot(COLUMN - marker[0] / 5, 480 - ROW - marker[1] / 5) < 25
    share = (beyond + 0.5).clip(0, 1) * near
    covered: Picture = (picture * (1 - share) + 105 * share).astype(np.uint8)
    return covered


def shadow(picture: Picture, marker: Marker, rng: np.random.Generator) -> Picture:
    """The hard edge of a shadow over a marker."""
    turn, factor = rng.uniform(-math.pi, math.pi), rng.uniform(0.3, 0.8)
    beyond = _beyond(marker, marker[2] + turn, _distance_for(rng.uniform(0.1, 0.9), turn))
    dim: Picture = (picture * (1 - (1 - factor) * (beyond + 0.5).clip(0, 1))).astype(np.uint8)
    return dim


def two_cables(picture: Picture, marker: Marker, rng: np.random.Generator) -> Picture:
    """Two cables of 4 to 12 mm over one marker."""
    picture = picture.copy()
    for _ in range(2):
        turn = rng.uniform(0, math.pi)
        along = np.array((math.cos(turn), math.sin(turn)))
        normal = np.array((-along[1], along[0]))
        middle = np.array(marker[:2]) / 5 + rng.uniform(-8, 8) * normal
        curve = middle + 40 * np.linspace(-1, 1, 13)[:, None] * along
        draw_cable(picture, curve, rng.uniform(4, 12) / 5, float(rng.choice([30, 60, 130])))
    return picture


def hand(picture: Picture, marker: Marker, rng: np.random.Generator) -> Picture:
    """A hand near or over the marker: an arm of skin and five fingers."""
    picture = picture.copy()
    turn = rng.uniform(-math.pi, math.pi)
    x, y = marker[0] / 5 + rng.uniform(-40, 40), 480 - marker[1] / 5 + rng.uniform(-40, 40)
    skin = int(rng.integers(95, 170))
    middle = (int(x + 18 * math.cos(turn)), int(y + 18 * math.sin(turn)))
    far = (int(x + 200 * math.cos(turn)), int(y + 200 * math.sin(turn)))
    cv2.line(picture, middle, far, skin, 14, cv2.LINE_AA)
    cv2.circle(picture, middle, 10, skin, cv2.FILLED, cv2.LINE_AA)
    for finger in range(5):
        angle = turn + math.pi + (finger - 2) * 0.35
        end = (int(middle[0] + 24 * math.cos(angle)), int(middle[1] + 24 * math.sin(angle)))
        cv2.line(picture, middle, end, skin, 4, cv2.LINE_AA)
    return picture


TROUBLES: dict[str, Trouble] = {
    "glare": glare,
    "cover": cover,
    "shadow": shadow,
    "two cables": two_cables,
    "hand": hand,
}
