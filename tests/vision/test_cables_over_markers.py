"""Markers under cables of other robots: found, with the right number of holes, exact, and without phantom food."""

import copy
import math
from functools import cache

import numpy as np
import pytest
from numpy.typing import NDArray

from khepera_forage.vision.rendering import draw_cable
from khepera_forage.vision.tracker import Tracker
from tests.vision.scene_renderer import Frame, Marker, SceneRenderer, heading_error, position_error

BLACK, GREY, LIGHT_GREY = 30.0, 60.0, 130.0
COLUMNS, TILES, TILE, MARGIN = 5, 20, (640.0, 600.0), 190.0
"""Columns and number of the tiles of a frame, their size, and the least distance of a marker from their border, mm: no
cable leaves its tile."""
STAGE = cache(SceneRenderer)
"""Floor and light take longer to draw than a frame."""
Errors = tuple[list[float], list[float]]


def cable_across(
    marker: Marker, rng: np.random.Generator, angle: float | None, place: float | None
) -> NDArray[np.float64]:
    """A slightly curved line across a marker: points in pixels.

    `angle` is between the line and the marker's axis, in degrees, and `place` is where it crosses, pixels from the
    middle; None for any.
    """
    turn = float(rng.uniform(0, math.pi)) if angle is None else math.radians(angle)
    reach = 12 * abs(math.sin(turn)) + 8 * abs(math.cos(turn))
    along = np.array((math.cos(marker[2] + turn), math.sin(marker[2] + turn)))
    normal = np.array((-along[1], along[0]))
    shares = np.linspace(-1, 1, 13)[:, None]
    offset, bend = rng.uniform(-reach, reach) if place is None else place, rng.uniform(-1.5, 1.5)
    middle = np.array(marker[:2]) / 5
    points: NDArray[np.float64] = middle + 34 * shares * along + (offset + bend * (1 - shares**2)) * normal
    return points


def random_marker(tile: int, rng: np.random.Generator) -> Marker:
    left, below = tile % COLUMNS * TILE[0], tile // COLUMNS * TILE[1]
    x, y = (float(rng.uniform(MARGIN, size - MARGIN)) for size in TILE)
    return left + x, below + y, float(rng.uniform(-math.pi, math.pi)), 1 + tile % 2


@cache  # all tests compare with the same frames without a cable
def errors(width: float, grey: float, count: int, angle: float | None = None, place: float | None = None) -> Errors:
    """Errors of position (pixels) and heading (degrees) of the found markers; nothing else may be found.

    Each of `count` markers is under a cable; food lies beside every third, where the gripper holds it.
    """
    scene, tracker = copy.deepcopy(STAGE()), Tracker()
    distances, angles = [], []
    for first in range(0, count, TILES):
        markers = tuple(random_marker(tile, scene.rng) for tile in range(min(count - first, TILES)))
        foods = tuple((x + 88 * math.cos(turn), y + 88 * math.sin(turn)) for x, y, turn, _ in markers[::3])

        def crossed(picture: Frame, markers: tuple[Marker, ...] = markers) -> Frame:
            for marker in markers:
                curve = cable_across(marker, scene.rng, angle, place)
                if width > 0:
                    draw_cable(picture, curve, width / 5, grey)
            return picture

        for d in tracker.detect(scene.frame(markers, foods, crossed)):
            x, y, heading, holes = min(markers, key=lambda m: position_error(d, *m[:2]))
            if d.holes:
                assert d.holes == holes
                distances.append(position_error(d, x, y))
                angles.append(heading_error(d, heading))
            else:
                assert min(position_error(d, *food) for food in foods) < 2
    assert len(distances) <= count
    return distances, angles


CABLES = [(4.0, GREY), (5.0, LIGHT_GREY), (6.0, BLACK), (6.0, GREY), (8.0, GREY), (10.0, BLACK), (12.0, LIGHT_GREY)]


@pytest.mark.parametrize(("width", "grey"), CABLES)
def test_marker_under_a_cable_is_found_as_exactly_as_without(width: float, grey: float) -> None:
    clear, (distances, angles) = errors(0.0, GREY, 100), errors(width, grey, 100)
    assert len(distances) >= 0.98 * 100
    for quantile in (0.5, 0.9):
        assert np.quantile(distances, quantile) <= 2 * np.quantile(clear[0], quantile)
        assert np.quantile(angles, quantile) <= 2 * np.quantile(clear[1], quantile)
    assert max(angles) < 15, "no heading is reversed"


@pytest.mark.parametrize("grey", [BLACK, GREY])
@pytest.mark.parametrize("width", [4.0, 12.0])
@pytest.mark.parametrize("angle", [0.0, 5.0, 90.0])
def test_cable_along_a_side_does_not_move_the_marker(angle: float, width: float, grey: float) -> None:
    """It may cover a fraction of a pixel of the white, beside the black frame."""
    (clear, _), (distances, _) = errors(0.0, GREY, 100), errors(width, grey, 60, angle)
    assert len(distances) >= 0.98 * 60
    assert np.quantile(distances, 0.95) <= 2 * np.quantile(clear, 0.95)


@pytest.mark.parametrize(
    ("nearest", "furthest", "angle"),
    [(8.6, 11.0, 90.0), (-11.0, -8.6, 90.0), (-8.4, -5.0, 88.0), (-8.4, -5.0, 90.0), (-8.4, -5.0, 92.0)],
)
def test_cable_near_a_short_side_does_not_move_the_marker(nearest: float, furthest: float, angle: float) -> None:
    """Its inner edge looks like the marker's border; a marker further ahead would have its holes elsewhere."""
    places = np.arange(nearest, furthest, 0.4)
    distances = [distance for place in places for distance in errors(12.0, GREY, 10, angle, place)[0]]
    assert len(distances) >= 0.98 * 10 * len(places)
    assert np.count_nonzero(np.array(distances) < 0.5) >= 0.97 * 10 * len(places)


def test_cable_that_cuts_off_a_corner_does_not_turn_the_marker() -> None:
    """The larger piece alone would fit, loosely, a marker that is turned by 26 degrees."""
    for place in np.arange(3.6, 5.6, 0.2):
        distances, angles = errors(8.0, GREY, 20, 45.0, place)
        assert max(distances) < 0.5
        assert max(angles) < 3
