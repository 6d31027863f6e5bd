"""Frames full of markers and food, one of each in every tile, each marker under a cable: for curves up to failure."""

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from khepera_forage.robots.khepera import MARKER_LENGTH, MARKER_WIDTH
from khepera_forage.vision.rendering.appearance import CameraAppearance
from khepera_forage.vision.rendering.drawing import draw_cable, to_pixels
from khepera_forage.vision.rendering.frames import FrameRenderer, Light
from khepera_forage.vision.scene import MM_PER_PIXEL, Truth
from khepera_forage.vision.shapes import PICTURE_HEIGHT, PICTURE_WIDTH

COLUMNS, ROWS = 5, 4
"""Tiles of a frame, 128 x 120 pixels each."""
_TILE = (PICTURE_WIDTH * MM_PER_PIXEL / COLUMNS, PICTURE_HEIGHT * MM_PER_PIXEL / ROWS)
_MARKER_MARGIN, _FOOD_MARGIN, _DISTANCE = 190.0, 60.0, 150.0
"""mm from the border of its tile to the centre of a marker and of food, and between the two."""
_CABLE = 170.0
"""mm from the middle of a cable to each of its ends: it stays within its tile."""
_CURVE = 8.0
"""Greatest distance in mm of the middle of a cable from the straight line between its ends."""


@dataclass(frozen=True, slots=True)
class Conditions:
    """Everything that disturbs a frame.

    Attributes:
        appearance: Grey levels, blur, noise and light.
        exposure: Factor of all grey levels, which saturate at 255.
        cable_width: In mm; 0 for no cables.
        cable: Grey level of the cables.
        angle: Between each cable and its marker's long side in degrees; None for any.
    """

    appearance: CameraAppearance
    exposure: float = 1.0
    cable_width: float = 0.0
    cable: float = 60.0
    angle: float | None = None


def frames(
    conditions: Conditions, count: int, rng: np.random.Generator, tiles: int = COLUMNS * ROWS
) -> Iterator[tuple[Truth, NDArray[np.uint8]]]:
    """Frames, and what is in them.

    Args:
        conditions: The same for all frames.
        count: Number of frames.
        rng: Draws poses, cables, floor, light and noise.
        tiles: Number of tiles with a marker and food; the others are empty.
    """
    places, light_rng, floor_rng, noise = rng.spawn(4)
    # An exposure below 1 weakens the light, but not the sensor's noise.
    grain = conditions.appearance.grain * math.sqrt(max(0.0, 1 - conditions.exposure**2))
    light = Light(conditions.appearance, light_rng)
    truth = Truth((), ())
    renderer = FrameRenderer(lambda: truth, conditions.appearance)
    renderer.reset(floor_rng)
    for number in range(count):
        truth = _truth(places, tiles)
        picture = renderer.picture()
        for marker in truth.markers:
            # Drawn even without cables, so that the poses are the same for every width.
            curve = _cable(marker, conditions, places)
            if conditions.cable_width > 0:
                draw_cable(picture, curve, conditions.cable_width / MM_PER_PIXEL, conditions.cable)
        frame = light.expose(picture, float(number))
        exposed = frame * conditions.exposure + noise.normal(0, grain, frame.shape)
        yield truth, exposed.round().clip(0, 255).astype(np.uint8)


def _truth(rng: np.random.Generator, tiles: int) -> Truth:
    """A marker and a food object at random places of every tile."""
    markers, foods = [], []
    for number in range(tiles):
        left, below = number % COLUMNS * _TILE[0], number // COLUMNS * _TILE[1]
        x, y = (float(rng.uniform(_MARKER_MARGIN, size - _MARKER_MARGIN)) for size in _TILE)
        while True:
            food_x, food_y = (float(rng.uniform(_FOOD_MARGIN, size - _FOOD_MARGIN)) for size in _TILE)
            if math.hypot(food_x - x, food_y - y) > _DISTANCE:
                break
        markers.append((left + x, below + y, float(rng.uniform(-math.pi, math.pi)), 1 + number % 2))
        foods.append((left + food_x, below + food_y))
    return Truth(tuple(markers), tuple(foods))


def _cable(
    marker: tuple[float, float, float, int], conditions: Conditions, rng: np.random.Generator
) -> NDArray[np.float64]:
    """A slightly curved cable anywhere across a marker: points in pixels."""
    x, y, heading, _ = marker
    turn = float(rng.uniform(0, math.pi)) if conditions.angle is None else math.radians(conditions.angle)
    along = np.array((math.cos(heading + turn), math.sin(heading + turn)))
    normal = np.array((-along[1], along[0]))
    reach = (MARKER_LENGTH * abs(math.sin(turn)) + MARKER_WIDTH * abs(math.cos(turn))) / 2
    offset, bend = rng.uniform(-reach, reach), rng.uniform(-_CURVE, _CURVE)
    shares = np.linspace(-1, 1, 13)[:, None]
    points = (x, y) + shares * _CABLE * along + (offset + bend * (1 - shares**2)) * normal
    return np.array([to_pixels(*point) for point in points.tolist()])
