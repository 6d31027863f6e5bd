"""Troubles of real pictures: what the tracker reports is right, or a warning names the cause."""

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from khepera_forage.vision.rendering import CameraAppearance, draw_cable
from khepera_forage.vision.shapes import MARKER_HOLES
from khepera_forage.vision.tracker import Tracker
from tests.vision.scene_renderer import (
    COLUMN,
    LABORATORY,
    ROW,
    Frame,
    Marker,
    SceneRenderer,
    heading_error,
    only_region,
    position_error,
    random_marker,
)

Trouble = Callable[..., Frame]


def brightened(picture: Frame, x: float, y: float, amplitude: float, size: float) -> Frame:
    """The picture with the reflection of a lamp: a Gaussian of some pixels around a place in mm."""
    across, down = COLUMN[0] - x / 5, ROW[:, 0] - 480 + y / 5
    spot = np.outer(np.exp(-((down / size) ** 2) / 2), np.exp(-((across / size) ** 2) / 2))
    return (picture + amplitude * spot).clip(0, 255).astype(np.uint8)


def glare(picture: Frame, marker: Marker, rng: np.random.Generator) -> Frame:
    """A reflection over the front hole, or the back one, of a marker."""
    x, y, heading, holes = marker
    ahead = float(rng.choice([hole[0] for hole in MARKER_HOLES[holes]])) + rng.uniform(-6, 6)
    size = rng.uniform(3, 6)
    x, y = x + ahead * math.cos(heading), y + ahead * math.sin(heading)
    return brightened(picture, x, y, rng.uniform(120, 250), size)


def part(marker: Marker, rng: np.random.Generator, least: float, most: float) -> NDArray[np.float64]:
    """For each pixel, its share beyond a line that cuts a share between `least` and `most` off a marker."""
    turn = rng.uniform(-math.pi, math.pi)
    x, y = np.mgrid[-60:61:2, -40:41:2]
    distance = np.quantile(x * math.cos(turn) + y * math.sin(turn), 1 - rng.uniform(least, most))
    across, up = COLUMN - marker[0] / 5, 480 - ROW - marker[1] / 5
    angle = marker[2] + turn
    beyond: NDArray[np.float64] = across * math.cos(angle) + up * math.sin(angle) - distance / 5
    return (beyond + 0.5).clip(0, 1)


def cover(picture: Frame, marker: Marker, rng: np.random.Generator) -> Frame:
    """A cover of the floor's colour over 20 to 30 % of a marker."""
    share = part(marker, rng, 0.2, 0.3)
    return (picture * (1 - share) + 105 * share).astype(np.uint8)


def shadow(picture: Frame, marker: Marker, rng: np.random.Generator) -> Frame:
    """The hard edge of a shadow over a marker."""
    return (picture * (1 - rng.uniform(0.2, 0.8) * part(marker, rng, 0.1, 0.9))).astype(np.uint8)


def across(place: Sequence[float], reach: float, rng: np.random.Generator) -> NDArray[np.float64]:
    """A straight cable at any angle, at most `reach` pixels beside a place in mm: points in pixels."""
    turn = rng.uniform(0, math.pi)
    along = np.array((math.cos(turn), math.sin(turn)))
    middle = np.array(place[:2]) / 5 + rng.uniform(-reach, reach) * np.array((-along[1], along[0]))
    curve: NDArray[np.float64] = middle + 40 * np.linspace(-1, 1, 13)[:, None] * along
    return curve


def two_cables(picture: Frame, marker: Marker, rng: np.random.Generator) -> Frame:
    """Two cables of 4 to 12 mm over one marker."""
    for _ in range(2):
        draw_cable(picture, across(marker, 8, rng), rng.uniform(4, 12) / 5, float(rng.choice([30, 60, 130])))
    return picture


def hand(picture: Frame, marker: Marker, rng: np.random.Generator) -> Frame:
    """A hand near or over the marker: an arm of skin and five fingers."""
    x, y = marker[0] / 5 + rng.uniform(-40, 40), 480 - marker[1] / 5 + rng.uniform(-40, 40)
    turn, skin = rng.uniform(-math.pi, math.pi), int(rng.integers(95, 170))
    fingers = [(turn + math.pi + 0.35 * finger, 24, 4) for finger in range(-2, 3)]
    for angle, length, width in ((turn, 200, 18), *fingers):
        end = int(x + length * math.cos(angle)), int(y + length * math.sin(angle))
        cv2.line(picture, (int(x), int(y)), end, skin, width, cv2.LINE_AA)
    return picture


@pytest.mark.parametrize(
    ("trouble", "appearance", "least"),
    [
        (None, LABORATORY, 24),
        (glare, LABORATORY, 0),
        (glare, replace(LABORATORY, white=255.0, floor=150.0), 0),
        (cover, LABORATORY, 4),
        (shadow, LABORATORY, 4),
        (two_cables, LABORATORY, 19),
        (hand, LABORATORY, 14),
        (None, replace(LABORATORY, black=130.0, white=215.0), 24),
    ],
)
def test_marker_in_trouble_is_right_or_a_warning_names_the_cause(
    trouble: Trouble | None, appearance: CameraAppearance, least: int
) -> None:
    """For ten frames, a found marker is within a pixel and 5 degrees; a lost one has a warning; no other appears."""
    renderer, tracker = SceneRenderer(appearance, seed=5), Tracker()
    right = wrong = 0
    for i in range(24):
        marker = random_marker(renderer.rng, 1 + i % 2, 300, 2900, 300)
        tracker.reset()
        tracker.update(renderer.frame((marker,)))
        change = partial(trouble, marker=marker, rng=renderer.rng) if trouble else None
        frame = renderer.frame((marker,), (), change)
        for _ in range(10):
            scene = tracker.update(frame)
            (own,) = [r for r in scene.regions if r.holes == marker[3]]
            assert [r for r in scene.regions if r.holes and r is not own] == [], "no phantom robot"
            if own.found:
                wrong += position_error(own, *marker[:2]) > 1.0 or heading_error(own, marker[2]) > 5
            else:
                assert tracker.warnings.keys() & {"glare", "cover", "pale holes", "cables", "holes", "lost"}
        right += own.found
    assert wrong == 0
    assert right >= least


SPOTS = [
    ((1692.1, 1784.1, -1.697, 2), (1687.6, 1748.8, 234.0, 5.27)),
    ((1176.3, 1754.8, -0.351, 2), (1206.1, 1743.9, 236.0, 5.11)),
]
"""Markers, and reflections on them that make the other marker in some frames."""


@pytest.mark.parametrize(("marker", "spot"), SPOTS)
@pytest.mark.parametrize("clean", [3, 30])
def test_reflection_that_stays_makes_no_other_marker(clean: int, marker: Marker, spot: tuple[float, ...]) -> None:
    renderer, tracker = SceneRenderer(seed=5), Tracker()
    for _ in range(clean):
        tracker.update(renderer.frame((marker,)))
    read = 0
    for _ in range(40):
        scene = tracker.update(renderer.frame((marker,), (), lambda picture: brightened(picture, *spot)))
        assert [(r.holes, r.found) for r in scene.regions] == [(2, False)]
        read += "uncertain" in tracker.warnings
    assert read > 3, "without a track it would be the other marker"
    assert only_region(tracker.update(renderer.frame((marker,))), 2).found


def test_robot_that_takes_the_place_of_another_counts_after_the_place_was_empty() -> None:
    renderer, tracker = SceneRenderer(seed=5), Tracker()
    place = 1000.0, 1000.0, 0.5
    for _ in range(12):
        tracker.update(renderer.frame(((*place, 2),)))
    for _ in range(5):
        assert [(r.holes, r.found) for r in tracker.update(renderer.frame(((*place, 1),))).regions] == [(2, False)]
        assert "take it away for a moment" in tracker.warnings["uncertain"]
    tracker.update(renderer.frame(()))
    for _ in range(3):
        scene = tracker.update(renderer.frame(((*place, 1),)))
    assert [(r.holes, r.found) for r in scene.regions] == [(1, True)]
    assert tracker.warnings == {}


def test_phantom_of_the_first_frame_is_dropped_within_ten_frames() -> None:
    """A sheet like a marker passes through the first frame only."""
    renderer, tracker = SceneRenderer(seed=5), Tracker()
    real, phantom = (1000.0, 1000.0, 0.5, 1), (2000.0, 1500.0, 0.0, 2)
    assert len(tracker.update(renderer.frame((real, phantom))).regions) == 2
    for _ in range(10):
        scene = tracker.update(renderer.frame((real,)))
    assert [r.holes for r in scene.regions] == [1]


@pytest.mark.parametrize("size", [2.0, 3.0, 6.0])
def test_reflection_on_the_floor_is_not_food(size: float) -> None:
    renderer, tracker = SceneRenderer(seed=5), Tracker()
    marker, food = (800.0, 800.0, 1.0, 2), (1200.0, 500.0)
    phantoms = 0
    for _ in range(20):
        x, y, amplitude = renderer.rng.uniform((1600, 400, 60), (2800, 2000, 400)).tolist()
        spot = partial(brightened, x=x, y=y, amplitude=amplitude, size=size)
        tracker.reset()
        for _ in range(3):
            scene = tracker.update(renderer.frame((marker,), (food,), spot))
        found = [r for r in scene.regions if not r.holes and r.found]
        assert any(position_error(r, *food) < 1 for r in found)
        phantoms += len(found) - 1
    assert phantoms <= 1


@pytest.mark.parametrize(
    ("markers", "size", "least", "most"),
    [
        *(((), size, 340.0, 380.0) for size in (4.8, 5.0, 5.2)),
        *((((600.0, 800.0, 1.0, 2),), size, 200.0, 500.0) for size in (4.5, 6.0)),
    ],
)
def test_reflection_on_the_floor_is_no_robot(
    markers: tuple[Marker, ...], size: float, least: float, most: float
) -> None:
    """Also where no marker has shown yet how bright white is."""
    renderer, tracker = SceneRenderer(seed=5), Tracker()
    for _ in range(40):
        x, y, amplitude = renderer.rng.uniform((1000, 400, least), (2800, 2000, most)).tolist()
        found = tracker.detect(brightened(renderer.frame(markers), x, y, amplitude, size))
        assert [d.holes for d in found if d.holes] == [holes for *_, holes in markers], (x, y, amplitude)


@pytest.mark.parametrize("size", [2.0, 3.0, 4.0, 8.0, 14.0])
def test_food_under_a_reflection_is_found_or_a_warning_names_the_cause(size: float) -> None:
    renderer, tracker = SceneRenderer(seed=5), Tracker()
    for _ in range(8):
        x, y, amplitude = renderer.rng.uniform((1000, 400, 60), (2800, 2000, 400)).tolist()
        spot = partial(brightened, x=x, y=y, amplitude=amplitude, size=size)
        found = tracker.detect(renderer.frame(((600.0, 800.0, 1.0, 2),), ((x, y),), spot))
        if not any(position_error(food, x, y) < 1 for food in found):
            causes = {"bright shape", "bright food", "bright area", "reflection", "cover"}
            assert tracker.warnings.keys() & causes, (size, amplitude)


WALLS = ((500.0, 500.0, 2700.0, 500.0), (500.0, 500.0, 500.0, 1900.0), (500.0, 1900.0, 2700.0, 1900.0))
Walls = tuple[tuple[float, float, float, float], ...]


def wall(turn: float) -> Walls:
    cos, sin = math.cos(turn), math.sin(turn)
    return ((1600 - 900 * cos, 1200 - 900 * sin, 1600 + 900 * cos, 1200 + 900 * sin),)


@pytest.mark.parametrize("grey", [190.0, 225.0])
@pytest.mark.parametrize(
    ("walls", "width", "least"),
    [
        *((WALLS, width, 8) for width in (10.0, 20.0, 60.0)),
        *((wall(turn), width, 7) for width, turn in ((10.0, 0.0), (20.0, 0.4), (50.0, 2.5), (120.0, 0.0))),
    ],
)
def test_food_that_touches_a_bright_wall_is_found(walls: Walls, width: float, least: int, grey: float) -> None:
    renderer = SceneRenderer(replace(LABORATORY, wall=grey, wall_width=width), walls=walls, seed=5)
    tracker, found = Tracker(), 0
    start, end = np.array(walls[0][:2]), np.array(walls[0][2:])
    along = (end - start) / np.hypot(*(end - start))
    for _ in range(8):
        where, gap = renderer.rng.uniform((-800, 0), (800, 8)).tolist()
        aside = width / 2 + 17.5 + gap
        x, y = (start + end) / 2 + where * along + aside * np.array((-along[1], along[0]))
        detected = tracker.detect(renderer.frame((), ((x, y),)))
        assert all(position_error(food, x, y) < 0.5 for food in detected)
        found += len(detected)
    assert found >= least
    assert tracker.detect(renderer.frame((), ())) == []
    assert bool(tracker.warnings) is (width > 80)


@pytest.mark.parametrize("grey", [190.0, 225.0])
@pytest.mark.parametrize("width", [80.0, 140.0])
def test_food_in_the_corner_of_wide_bright_walls_is_found_or_a_warning_names_the_cause(
    width: float, grey: float
) -> None:
    renderer = SceneRenderer(replace(LABORATORY, wall=grey, wall_width=width), walls=WALLS[:2], seed=5)
    tracker = Tracker()
    for _ in range(12):
        place = (500 + width / 2 + 17.5 + renderer.rng.uniform(0, 6, 2)).tolist()
        found = tracker.detect(renderer.frame((), (tuple(place),)))
        if not any(position_error(food, *place) < 1 for food in found):
            assert tracker.warnings["bright area"].startswith("the area around (")


@pytest.mark.parametrize(("width", "least"), [(4, 40), (8, 10), (12, 0)])
def test_food_under_a_cable_is_found_or_a_warning_names_its_place(width: float, least: int) -> None:
    renderer, tracker, found = SceneRenderer(seed=5), Tracker(), 0
    for _ in range(40):
        x, y = renderer.rng.uniform((300, 300), (2900, 2100)).tolist()

        def crossed(picture: Frame, place: tuple[float, float] = (x, y)) -> Frame:
            draw_cable(picture, across(place, 2, renderer.rng), width / 5, LABORATORY.cable)
            return picture

        seen = tracker.detect(renderer.frame((), ((x, y),), crossed))
        assert all(position_error(food, x, y) < 1 for food in seen)
        assert list(tracker.warnings) == ([] if seen else ["crossed food"])
        found += len(seen)
    assert found >= least
