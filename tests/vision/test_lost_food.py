"""Dropping of lost food on real frames: the floor must be visible at its last place for `patience` frames."""

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from khepera_forage.vision.rendering import CameraAppearance
from khepera_forage.vision.scene import Region
from khepera_forage.vision.tracker import Tracker, TrackerSettings
from tests.vision.scene_renderer import Marker, SceneRenderer, only_region

FOOD = (1000.0, 1000.0)
FAR: Marker = (2000.0, 500.0, 0.0, 1)
OVER: Marker = (1030.0, 1010.0, 0.5, 1)
COLUMN, ROW = 200, 280


def foods(tracker: Tracker, frame: NDArray[np.uint8]) -> list[tuple[int, bool]]:
    return [(r.label, r.found) for r in tracker.update(frame).regions if r.holes == 0]


def food(tracker: Tracker, frame: NDArray[np.uint8]) -> Region:
    return only_region(tracker.update(frame), 0)


@pytest.mark.parametrize("patience", [1, 3, 7])
def test_removed_food_is_dropped_after_patience_frames(patience: int) -> None:
    renderer, tracker = SceneRenderer(), Tracker(TrackerSettings(patience=patience))
    shown = food(tracker, renderer.frame((FAR,), (FOOD,)))
    for _ in range(patience - 1):
        assert food(tracker, renderer.frame((FAR,))) == shown._replace(found=False)
    assert foods(tracker, renderer.frame((FAR,))) == []


def test_food_under_a_marker_is_kept_and_found_again() -> None:
    renderer, tracker = SceneRenderer(), Tracker()
    shown = food(tracker, renderer.frame((FAR,), (FOOD,)))
    for _ in range(30):
        assert food(tracker, renderer.frame((OVER,), (FOOD,))) == shown._replace(found=False)
    back = food(tracker, renderer.frame((FAR,), (FOOD,)))
    assert (back.label, back.found) == (shown.label, True)


def test_food_removed_under_a_marker_is_dropped_when_the_marker_has_left() -> None:
    renderer, tracker = SceneRenderer(), Tracker()
    shown = food(tracker, renderer.frame((FAR,), (FOOD,)))
    for _ in range(5):
        assert food(tracker, renderer.frame((OVER,))).label == shown.label
    assert foods(tracker, renderer.frame((FAR,))) == [(0, False)]
    assert foods(tracker, renderer.frame((FAR,))) == [(0, False)]
    assert foods(tracker, renderer.frame((FAR,))) == []


def test_floor_visible_in_separate_frames_does_not_drop_food() -> None:
    renderer, tracker = SceneRenderer(), Tracker()
    tracker.update(renderer.frame((FAR,), (FOOD,)))
    for i in range(20):
        frame = renderer.frame((FAR,) if i % 3 else (OVER,))
        assert foods(tracker, frame) == [(0, False)]


def test_food_at_the_rim_of_a_marker_is_kept() -> None:
    """A robot over the edge of the disc of food, from whichever side it came, does not drop the food."""
    renderer, tracker = SceneRenderer(), Tracker()
    labels = set()
    for distance in (90.0, 80.0, 74.0, 70.0, 60.0, 50.0, 60.0, 70.0, 74.0, 80.0, 90.0):
        for _ in range(5):
            scene = tracker.update(renderer.frame(((FOOD[0] - distance, FOOD[1], 0.0, 1),), (FOOD,)))
            labels.add(only_region(scene, 0).label)
            assert len(scene.regions) == 2
    assert len(labels) == 1


@pytest.mark.parametrize("grey", [10, 45, 70, 160, 250])
def test_food_under_another_object_is_kept(grey: int) -> None:
    """A robot's body, a hand, a sheet of paper: anything that does not look like floor."""
    renderer, tracker = SceneRenderer(), Tracker()
    tracker.update(renderer.frame((FAR,), (FOOD,)))
    for _ in range(10):
        frame = renderer.frame((FAR,))
        cv2.rectangle(frame, (COLUMN - 8, ROW - 8), (COLUMN + 8, ROW + 8), grey, cv2.FILLED)
        assert foods(tracker, frame) == [(0, False)]


def test_removed_food_is_dropped_although_a_cable_covers_its_place() -> None:
    renderer, tracker = SceneRenderer(CameraAppearance.laboratory()), Tracker()
    tracker.update(renderer.frame((FAR,), (FOOD,)))
    for i in range(3):
        frame = renderer.frame((FAR,))
        cv2.line(frame, (COLUMN - 40, ROW - 10), (COLUMN + 40, ROW + 8), 40, 1, cv2.LINE_AA)
        assert foods(tracker, frame) == ([(0, False)] if i < 2 else [])


def test_food_under_a_cable_is_kept() -> None:
    """A cable two pixels wide splits the disc. The food may be lost, but its place does not look like floor."""
    renderer, tracker = SceneRenderer(), Tracker()
    tracker.update(renderer.frame((FAR,), (FOOD,)))
    for turn in np.linspace(0, np.pi, 20):
        for grey in (20, 70, 110):
            frame = renderer.frame((FAR,), (FOOD,))
            reach = (round(40 * float(np.cos(turn))), round(40 * float(np.sin(turn))))
            start, end = (COLUMN - reach[0], ROW - reach[1]), (COLUMN + reach[0], ROW + reach[1])
            cv2.line(frame, start, end, grey, 2, cv2.LINE_AA)
            assert [label for label, _ in foods(tracker, frame)] == [0]


def test_food_at_the_last_place_of_a_lost_marker_is_kept() -> None:
    renderer, tracker = SceneRenderer(), Tracker()
    tracker.update(renderer.frame((FAR,), (FOOD,)))
    for _ in range(12):
        tracker.update(renderer.frame((OVER,), (FOOD,)))
    for _ in range(10):  # robot and food were both removed
        regions = tracker.update(renderer.frame(())).regions
        assert [(r.holes, r.found) for r in regions] == [(0, False), (1, False)]
    for _ in range(3):
        regions = tracker.update(renderer.frame((FAR,))).regions
    assert [(r.holes, r.found) for r in regions] == [(1, True)]
