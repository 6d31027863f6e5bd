"""When lost food is dropped on real frames: its last place must show the floor, with patience. It decides outcomes."""

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from khepera_forage.vision.rendering.appearance import CameraAppearance
from khepera_forage.vision.scene import Region
from khepera_forage.vision.tracker import Tracker, TrackerSettings
from tests.vision.filming import Film, Marker, only

FOOD = (1000.0, 1000.0)
FAR: Marker = (2000.0, 500.0, 0.0, 1)
OVER: Marker = (1030.0, 1010.0, 0.5, 1)
COLUMN, ROW = 200, 280


def foods(tracker: Tracker, frame: NDArray[np.uint8]) -> list[tuple[int, bool]]:
    return [(r.label, r.found) for r in tracker.update(frame).regions if r.holes == 0]


def food(tracker: Tracker, frame: NDArray[np.uint8]) -> Region:
    return only(tracker.update(frame), 0)


@pytest.mark.parametrize("patience", [1, 3, 7])
def test_food_that_is_gone_is_dropped_after_so_many_frames_of_floor(patience: int) -> None:
    film, tracker = Film(), Tracker(TrackerSettings(patience=patience))
    shown = food(tracker, film.shoot((FAR,), (FOOD,)))
    for _ in range(patience - 1):
        assert food(tracker, film.shoot((FAR,))) == shown._replace(found=False)
    assert foods(tracker, film.shoot((FAR,))) == []


def test_a_marker_hides_it_for_any_time_and_its_leaving_shows_it_again() -> None:
    film, tracker = Film(), Tracker()
    shown = food(tracker, film.shoot((FAR,), (FOOD,)))
    for _ in range(30):
        assert food(tracker, film.shoot((OVER,), (FOOD,))) == shown._replace(found=False)
    back = food(tracker, film.shoot((FAR,), (FOOD,)))
    assert (back.label, back.found) == (shown.label, True)


def test_food_taken_away_under_a_marker_is_dropped_when_the_marker_has_left() -> None:
    film, tracker = Film(), Tracker()
    shown = food(tracker, film.shoot((FAR,), (FOOD,)))
    for _ in range(5):
        assert food(tracker, film.shoot((OVER,))).label == shown.label
    assert foods(tracker, film.shoot((FAR,))) == [(0, False)]
    assert foods(tracker, film.shoot((FAR,))) == [(0, False)]
    assert foods(tracker, film.shoot((FAR,))) == []


def test_floor_seen_now_and_then_is_not_enough() -> None:
    film, tracker = Film(), Tracker()
    tracker.update(film.shoot((FAR,), (FOOD,)))
    for i in range(20):
        frame = film.shoot((FAR,) if i % 3 else (OVER,))
        assert foods(tracker, frame) == [(0, False)]


def test_the_rim_of_a_marker_beside_it_hides_it() -> None:
    """A robot that stands over the edge of food's disc, wherever it came from, has not taken it away."""
    film, tracker = Film(), Tracker()
    for way in (90.0, 80.0, 74.0, 70.0, 60.0, 50.0, 60.0, 70.0, 74.0, 80.0, 90.0):
        for _ in range(5):
            scene = tracker.update(film.shoot(((FOOD[0] - way, FOOD[1], 0.0, 1),), (FOOD,)))
            assert only(scene, 0).label == only(scene, 0).label
            assert [r.label for r in scene.regions if r.holes == 0] == [r.label for r in scene.regions][-1:]
    assert len(scene.regions) == 2


@pytest.mark.parametrize("grey", [10, 45, 70, 160, 250])
def test_something_else_over_it_hides_it(grey: int) -> None:
    """A robot's body, a hand, a sheet of paper: whatever does not look like floor."""
    film, tracker = Film(), Tracker()
    tracker.update(film.shoot((FAR,), (FOOD,)))
    for _ in range(10):
        frame = film.shoot((FAR,))
        cv2.rectangle(frame, (COLUMN - 8, ROW - 8), (COLUMN + 8, ROW + 8), grey, cv2.FILLED)
        assert foods(tracker, frame) == [(0, False)]


def test_a_cable_over_the_empty_place_does_not_keep_it() -> None:
    film, tracker = Film(CameraAppearance.laboratory()), Tracker()
    tracker.update(film.shoot((FAR,), (FOOD,)))
    for i in range(3):
        frame = film.shoot((FAR,))
        cv2.line(frame, (COLUMN - 40, ROW - 10), (COLUMN + 40, ROW + 8), 40, 1, cv2.LINE_AA)
        assert foods(tracker, frame) == ([(0, False)] if i < 2 else [])


def test_a_cable_over_food_does_not_drop_it() -> None:
    """Two pixels of cable cut the disc in two: it may be lost, but its place does not look like floor."""
    film, tracker = Film(), Tracker()
    tracker.update(film.shoot((FAR,), (FOOD,)))
    for turn in np.linspace(0, np.pi, 20):
        for grey in (20, 70, 110):
            frame = film.shoot((FAR,), (FOOD,))
            reach = (round(40 * float(np.cos(turn))), round(40 * float(np.sin(turn))))
            start, end = (COLUMN - reach[0], ROW - reach[1]), (COLUMN + reach[0], ROW + reach[1])
            cv2.line(frame, start, end, grey, 2, cv2.LINE_AA)
            assert [label for label, _ in foods(tracker, frame)] == [0]


def test_a_lost_marker_hides_what_is_at_its_last_place_until_it_is_found() -> None:
    film, tracker = Film(), Tracker()
    tracker.update(film.shoot((FAR,), (FOOD,)))
    tracker.update(film.shoot((OVER,), (FOOD,)))
    for _ in range(10):  # the robot has been taken away, the food as well
        regions = tracker.update(film.shoot(())).regions
        assert [(r.holes, r.found) for r in regions] == [(0, False), (1, False)]
    for _ in range(3):
        regions = tracker.update(film.shoot((FAR,))).regions
    assert [(r.holes, r.found) for r in regions] == [(1, True)]


def test_food_carried_off_is_a_new_region_where_it_is_put_down() -> None:
    film, tracker = Film(), Tracker()
    tracker.update(film.shoot((FAR,), (FOOD,)))
    for x in range(1000, 1400, 15):
        tracker.update(film.shoot(((x + 10.0, 1000.0, 0.0, 1),), ((x + 40.0, 1000.0),)))
    for _ in range(3):
        scene = tracker.update(film.shoot(((1300.0, 1000.0, 0.0, 1),), ((1440.0, 1000.0),)))
    (put,) = [r for r in scene.regions if r.holes == 0]
    assert put.found
    assert put.label > 0
    assert abs(put.x - 288) < 0.5


def test_a_reset_forgets_how_long_a_place_has_been_empty() -> None:
    film, tracker = Film(), Tracker()
    for _ in range(2):
        tracker.reset()
        tracker.update(film.shoot((FAR,), (FOOD,)))
        for _ in range(2):
            assert foods(tracker, film.shoot((FAR,))) == [(0, False)]
