"""The tracker: calibration, tracks over many frames, lost food, and settings."""

import math
from dataclasses import replace

import cv2
import numpy as np
import pytest

from khepera_forage.vision.calibration import Calibration
from khepera_forage.vision.tracker import Tracker, TrackerSettings
from tests.vision.scene_renderer import (
    LABORATORY,
    Frame,
    Marker,
    SceneRenderer,
    heading_error,
    only_region,
    position_error,
    random_marker,
)

# ---------------------------------------------------------------- calibration


def test_tilted_and_turned_camera_is_corrected() -> None:
    """With a camera that looks down at an angle, positions and headings are those on the floor."""
    corners = np.array([[0, 480], [640, 480], [640, 0], [0, 0]], np.float32)
    seen = np.array([[60, 430], [600, 470], [570, 40], [110, 10]], np.float32)
    warp = cv2.getPerspectiveTransform(corners - 0.5, seen - 0.5)
    picture = tuple((float(u), float(v)) for u, v in seen)
    calibration = Calibration(picture, ((0.0, 0.0), (3200.0, 0.0), (3200.0, 2400.0), (0.0, 2400.0)))
    rng, renderer, tracker = np.random.default_rng(4), SceneRenderer(), Tracker(calibration=calibration)
    for _ in range(60):
        markers = (random_marker(rng, 1, 300, 1400), random_marker(rng, 2, 1700, 2900))
        food = (float(rng.uniform(1500, 1600)), float(rng.uniform(300, 2100)))
        frame = cv2.warpPerspective(renderer.frame(markers, (food,)), warp, (640, 480), borderValue=80)
        tracker.reset()
        scene = tracker.update(frame.astype(np.uint8))
        for x, y, heading, holes in markers:
            assert position_error(only_region(scene, holes), x, y) < 0.6
            assert heading_error(only_region(scene, holes), heading) < 4.0
            assert only_region(scene, holes).area == pytest.approx((384 - 16 * holes), rel=0.2)
        assert min(position_error(r, *food) for r in scene.regions if not r.holes) < 0.6


def test_parallax_of_a_low_camera_is_corrected() -> None:
    renderer = SceneRenderer(replace(LABORATORY, height=2700.0, marker_height=70.0))
    frame = renderer.frame(((500.0, 400.0, 1.0, 1),), ((2800.0, 2000.0),))
    camera = Calibration.identity((1600.0, 1200.0, 2700.0))
    corrected = Tracker(TrackerSettings(marker_height=70.0), camera).update(frame)
    assert position_error(only_region(corrected, 1), 500, 400) < 0.2
    assert position_error(only_region(corrected, 0), 2800, 2000) < 0.2
    assert position_error(only_region(Tracker().update(frame), 1), 500, 400) > 6
    with pytest.raises(ValueError, match=r"height is 70\.0 mm; allowed: below the camera"):
        Tracker(calibration=Calibration.identity((0.0, 0.0, 60.0)))


# ---------------------------------------------------------------- tracks


def test_labels_are_kept_while_robots_pass_each_other() -> None:
    """Two robots pass close to each other and to food many times."""
    renderer, tracker = SceneRenderer(LABORATORY, (1000.0, 1900.0)), Tracker()
    foods = ((700.0, 1300.0), (1300.0, 700.0))
    labels: dict[int, int] = {}
    for i in range(100):
        t = i / 20
        one = (1000 + 300 * math.cos(t), 1000 + 300 * math.sin(t), t + math.pi / 2, 1)
        two = (1000 + 130 * math.cos(-t * 0.7), 1000 + 130 * math.sin(-t * 0.7), -t, 2)
        scene = tracker.update(renderer.frame((one, two), foods))
        for x, y, heading, holes in (one, two):
            region = only_region(scene, holes)
            assert labels.setdefault(holes, region.label) == region.label
            assert region.found
            assert position_error(region, x, y) < 1
            assert heading_error(region, heading) < 4
        for x, y in foods:
            assert any(not r.holes and r.found and position_error(r, x, y) < 1.5 for r in scene.regions)


def test_featureless_tracking_uses_place_alone() -> None:
    renderer = SceneRenderer()
    by_place, by_holes = Tracker(TrackerSettings(featureless=True)), Tracker()
    start, away = (600.0, 600.0, 0.0, 1), (1500.0, 1500.0, 0.0, 1)
    for tracker in (by_place, by_holes):
        assert [r.label for r in tracker.update(renderer.frame((start,))).regions] == [0]
    for _ in range(5):
        frame = renderer.frame((away,))
        placed, held = by_place.update(frame), by_holes.update(frame)
    assert [(r.label, r.holes, r.found) for r in held.regions] == [(0, 1, True)]
    assert [(r.label, r.holes, r.found) for r in placed.regions] == [(1, 1, True)]


# ---------------------------------------------------------------- lost food: dropped when its place was visible


FOOD = (1000.0, 1000.0)
FAR: Marker = (2000.0, 500.0, 0.0, 1)
OVER: Marker = (1030.0, 1010.0, 0.5, 1)
COLUMN, ROW = 200, 280
SEEN, LOST, GONE = [(0, True)], [(0, False)], list[tuple[int, bool]]()
Frames = list[tuple[Marker | None, bool, int, list[tuple[int, bool]]]]
STORIES: dict[str, tuple[int, Frames]] = {
    "removed": (3, [(FAR, False, 2, LOST), (FAR, False, 1, GONE)]),
    "removed, patience 1": (1, [(FAR, False, 1, GONE)]),
    "removed, patience 7": (7, [(FAR, False, 6, LOST), (FAR, False, 1, GONE)]),
    "under a marker": (3, [(OVER, True, 30, LOST), (FAR, True, 1, SEEN)]),
    "removed under a marker": (3, [(OVER, False, 5, LOST), (FAR, False, 2, LOST), (FAR, False, 1, GONE)]),
    "removed with the robot over it": (3, [(OVER, True, 12, LOST), (None, False, 10, LOST), (FAR, False, 2, LOST)]),
    "floor in separate frames": (3, [(OVER, False, 1, LOST), (FAR, False, 2, LOST)] * 7),
}
"""Patience, and after a first frame with food: a marker, whether the food is there, frames, and what is tracked."""


def foods(tracker: Tracker, frame: Frame) -> list[tuple[int, bool]]:
    return [(r.label, r.found) for r in tracker.update(frame).regions if r.holes == 0]


@pytest.mark.parametrize("story", STORIES)
def test_food_is_kept_where_it_may_be_hidden_and_dropped_where_the_floor_is_seen(story: str) -> None:
    patience, frames = STORIES[story]
    renderer, tracker = SceneRenderer(), Tracker(TrackerSettings(patience=patience))
    shown = only_region(tracker.update(renderer.frame((FAR,), (FOOD,))), 0)
    for marker, is_there, count, tracked in frames:
        for _ in range(count):
            assert foods(tracker, renderer.frame((marker,) if marker else (), (FOOD,) * is_there)) == tracked
            if tracked == LOST:
                assert only_region(tracker.scene, 0) == shown._replace(found=False)


def test_new_food_counts_when_two_frames_agree_and_a_new_marker_when_three_do() -> None:
    renderer, tracker = SceneRenderer(), Tracker()
    tracker.update(renderer.frame(()))
    scenes = [tracker.update(renderer.frame((FAR,), (FOOD,))) for _ in range(3)]
    assert [sorted(region.holes for region in scene.regions) for scene in scenes] == [[], [0], [0, 1]]


@pytest.mark.parametrize("changed", [(1200.0, 900.0, 0.0, 1), (*FAR[:2], math.pi, 1)], ids=["jump", "reversal"])
def test_marker_that_jumps_or_is_reversed_counts_when_three_frames_agree(changed: Marker) -> None:
    renderer, tracker = SceneRenderer(), Tracker()
    tracker.update(renderer.frame((FAR,)))
    found = [only_region(tracker.update(renderer.frame((changed,))), 1).found for _ in range(3)]
    assert found == [False, False, True]


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


def test_removed_food_is_dropped_although_a_cable_covers_its_place() -> None:
    renderer, tracker = SceneRenderer(), Tracker()
    tracker.update(renderer.frame((FAR,), (FOOD,)))
    for i in range(3):
        frame = renderer.frame((FAR,))
        cv2.line(frame, (COLUMN - 40, ROW - 10), (COLUMN + 40, ROW + 8), 40, 1, cv2.LINE_AA)
        assert foods(tracker, frame) == (LOST if i < 2 else GONE)


def test_food_under_a_cable_or_another_object_is_kept() -> None:
    """Under a body, a hand or a sheet of paper it is lost; a cable two pixels wide splits the disc, but is no floor."""
    renderer, tracker = SceneRenderer(), Tracker()
    tracker.update(renderer.frame((FAR,), (FOOD,)))
    for grey in (10, 45, 70, 160, 250):
        for _ in range(10):
            frame = renderer.frame((FAR,))
            cv2.rectangle(frame, (COLUMN - 8, ROW - 8), (COLUMN + 8, ROW + 8), grey, cv2.FILLED)
            assert foods(tracker, frame) == LOST
    for turn in np.linspace(0, np.pi, 20):
        for grey in (20, 70, 110):
            frame = renderer.frame((FAR,), (FOOD,))
            reach = (round(40 * float(np.cos(turn))), round(40 * float(np.sin(turn))))
            start, end = (COLUMN - reach[0], ROW - reach[1]), (COLUMN + reach[0], ROW + reach[1])
            cv2.line(frame, start, end, grey, 2, cv2.LINE_AA)
            assert [label for label, _ in foods(tracker, frame)] == [0]


def test_tracker_without_a_marker_is_refused() -> None:
    with pytest.raises(ValueError, match=r"numbers is \[\]; allowed: at least one number"):
        TrackerSettings(numbers=())
