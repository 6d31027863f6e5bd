"""Frames in, regions out: how exact, how sure, and what disturbs it."""

import math
from dataclasses import replace

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from khepera_forage.noise import Noise
from khepera_forage.vision.association import Detection
from khepera_forage.vision.calibration import Calibration
from khepera_forage.vision.rendering.appearance import CameraAppearance
from khepera_forage.vision.rendering.canvas import Box, Disc, ImagePose, draw_shapes
from khepera_forage.vision.simulated_camera import OverheadCamera
from khepera_forage.vision.tracker import Tracker, TrackerSettings
from tests.vision.filming import Film, Marker, off, only, turned

LABORATORY = CameraAppearance.laboratory()
LOOKS = {
    "laboratory": LABORATORY,
    "dim": replace(LABORATORY, white=150.0, floor=70.0, wall=55.0, body=30.0, black=18.0),
    "blurred": replace(LABORATORY, blur=1.2),
    "noisy": replace(LABORATORY, grain=6.0),
    "uneven light": replace(LABORATORY, gradient=0.3, vignette=0.4),
    "dark cables": replace(LABORATORY, cable=30.0, cable_width=6.0),
}


def somewhere(rng: np.random.Generator, holes: int, left: float = 120.0, right: float = 3080.0) -> Marker:
    heading = float(rng.uniform(-math.pi, math.pi))
    return float(rng.uniform(left, right)), float(rng.uniform(120, 2280)), heading, holes


# ---------------------------------------------------------------- how exact


@pytest.mark.parametrize("name", LOOKS)
def test_poses_and_holes_anywhere(name: str) -> None:
    """The issue's bounds, 1 pixel and 3 degrees in 99 % of frames; here in each, for poses all over the picture."""
    rng, film, tracker = np.random.default_rng(1), Film(LOOKS[name], (1500.0, 1200.0)), Tracker()
    distances, angles = [], []
    for _ in range(150):
        markers = (somewhere(rng, 1, right=1400), somewhere(rng, 2, left=1700))
        scene = tracker.update(film.shoot(markers))
        for x, y, heading, holes in markers:
            region = only(scene, holes)
            assert region.found
            distances.append(off(region, x, y))
            angles.append(turned(region, heading))
    assert max(distances) < 1.0
    assert max(angles) < 3.5
    assert float(np.quantile(angles, 0.99)) < 3.0
    assert float(np.median(distances)) < 0.1


def test_centres_have_no_bias() -> None:
    rng, film, tracker = np.random.default_rng(2), Film(), Tracker()
    errors = []
    for _ in range(200):
        marker, food = somewhere(rng, 1, right=1500), somewhere(rng, 0, left=1700)[:2]
        for d in tracker.detect(film.shoot((marker,), (food,))):
            x, y = marker[:2] if d.holes else food
            errors.append((d.holes, d.x - x / 5, d.y - y / 5))
    for holes in (0, 1):
        part = np.array([e[1:] for e in errors if e[0] == holes])
        assert len(part) == 200
        assert np.abs(part.mean(axis=0)).max() < 0.02
        assert np.abs(part).max() < 0.3


def test_features_are_those_of_the_shapes() -> None:
    (marker,) = Tracker().detect(Film(CameraAppearance.none()).shoot(((1000.0, 1000.0, 0.0, 2),)))
    assert (marker.first_x, marker.first_y) == pytest.approx((188, 208), abs=1)
    assert marker.area == pytest.approx(24 * 16 - 2 * 16, rel=0.1)
    assert marker.perimeter == pytest.approx(80, rel=0.1)
    assert marker.compactness == pytest.approx(80**2 / 352, rel=0.2)
    (food,) = Tracker().detect(Film(CameraAppearance.none()).shoot((), ((1000.0, 1000.0),)))
    assert (food.x, food.y) == pytest.approx((200, 200), abs=0.05)
    assert food.area == pytest.approx(math.pi * 3.5**2, rel=0.15)
    assert food.compactness == pytest.approx(4 * math.pi, rel=0.3)
    assert (food.holes, food.orientation, food.edge) == (0, 0, False)


def test_edge_flag() -> None:
    film, tracker = Film(), Tracker()
    for x, edge in ((66.0, False), (58.0, True)):
        (marker,) = tracker.detect(film.shoot(((x, 1000.0, 0.0, 1),)))
        assert marker.edge is edge
        assert abs(marker.x - x / 5) < 1


def test_every_result_twice() -> None:
    film = Film()
    frame = film.shoot(((500.0, 500.0, 1.0, 1), (1500.0, 900.0, 2.0, 2)), ((800.0, 800.0), (300.0, 1500.0)))
    before, tracker = frame.copy(), Tracker()
    assert tracker.detect(frame) == tracker.detect(frame) == Tracker().detect(frame)
    assert (frame == before).all()
    scene = tracker.update(frame)
    assert tracker.scene is scene
    assert tracker.update(frame) == scene


# ---------------------------------------------------------------- what is none


def floor(grey: int = 100) -> NDArray[np.uint8]:
    return np.full((480, 640), grey, np.uint8)


@pytest.mark.parametrize("grey", [0, 5, 100, 250, 255])
def test_an_empty_floor_is_empty(grey: int) -> None:
    assert Tracker().detect(floor(grey)) == []


def test_white_walls_paper_lines_and_specks_are_nothing() -> None:
    frame = floor()
    cv2.rectangle(frame, (100, 100), (146, 230), 240, 2)  # walls around a corridor
    cv2.rectangle(frame, (300, 100), (420, 180), 240, cv2.FILLED)  # a sheet of paper
    cv2.rectangle(frame, (500, 100), (524, 116), 240, cv2.FILLED)  # a marker whose holes are not seen
    cv2.line(frame, (50, 400), (600, 300), 230, 2)
    cv2.circle(frame, (200, 50), 1, 255, cv2.FILLED)
    cv2.ellipse(frame, (300, 440), (12, 3), 20, 0, 360, 230, cv2.FILLED)
    assert Tracker().detect(frame) == []
    draw_shapes(frame, ImagePose(123.5, 314.5, 1, 0, 0.2), [Disc(17.5, 230)])  # food inside the walls
    (food,) = Tracker().detect(frame)
    assert (food.x, food.y) == pytest.approx((123.5, 480 - 165.5), abs=0.2)


def test_random_pictures_do_no_harm() -> None:
    rng, tracker = np.random.default_rng(0), Tracker()
    for scale in (1, 2, 4, 8, 16, 32):
        small = rng.integers(0, 256, (480 // scale + 1, 640 // scale + 1), dtype=np.uint8)
        frame = np.kron(small, np.ones((scale, scale), np.uint8))[:480, :640]
        for region in tracker.update(np.ascontiguousarray(frame)).regions:
            assert all(math.isfinite(value) for value in region)


@pytest.mark.parametrize(
    "frame", [np.zeros((240, 320), np.uint8), np.zeros((480, 640)), np.zeros((480, 640, 3), np.uint8)]
)
def test_other_frames_are_refused(frame: NDArray[np.uint8]) -> None:
    with pytest.raises(ValueError, match=r"frame is \(.*allowed: \(480, 640\)"):
        Tracker().update(frame)


# ---------------------------------------------------------------- food beside things


@pytest.mark.parametrize("gap", [0.5, 3.0, 8.0])
@pytest.mark.parametrize("turn", [0.0, 0.4, 0.8])
def test_foods_that_touch_are_two(gap: float, turn: float) -> None:
    reach = 17.5 + gap / 2
    foods = tuple((1000 + s * reach * math.cos(turn), 1000 + s * reach * math.sin(turn)) for s in (-1, 1))
    found = Tracker().detect(Film().shoot((), foods))
    assert len(found) == 2
    for x, y in foods:
        assert min(math.hypot(d.x - x / 5, d.y - y / 5) for d in found) < 0.6


@pytest.mark.parametrize("angle", range(0, 360, 20))
def test_food_under_the_rim_does_not_move_the_marker(angle: int) -> None:
    """All the way round, from all but hidden to beside it; food half seen is not reported."""
    film, tracker = Film(), Tracker()
    for way in (20.0, 45.0, 58.0, 75.0, 95.0):
        x, y = 1000 + way * math.cos(math.radians(angle)), 1000 + way * math.sin(math.radians(angle))
        scene = tracker.detect(film.shoot(((1000.0, 1000.0, 0.3, 2),), ((x, y),)))
        (marker,) = [d for d in scene if d.holes]
        assert math.hypot(marker.x - 200, marker.y - 200) < 0.5
        assert abs(marker.orientation - math.degrees(0.3)) < 3
        for food in (d for d in scene if not d.holes):
            assert math.hypot(food.x - x / 5, food.y - y / 5) < 1.0
        if way == 20.0:
            assert len(scene) == 1


def test_a_cable_may_lose_something_but_never_changes_a_number_of_holes() -> None:
    """Lines of any darkness across a marker and food at all angles, about 7 mm wide and about 17: as wide as a hole."""
    rng, film, tracker = np.random.default_rng(3), Film(), Tracker()
    lost = {1: 0, 2: 0}
    for _ in range(400):
        holes = int(rng.integers(1, 3))
        frame = film.shoot(((1000.0, 1000.0, float(rng.uniform(-3, 3)), holes),), ((1250.0, 1000.0),))
        angle, across = rng.uniform(0, math.pi), rng.uniform(-9, 9)
        along = np.array([math.cos(angle), math.sin(angle)])
        start = np.array([200, 280]) + across * np.array([-along[1], along[0]])
        one, other = (np.rint(start + s * 150 * along).astype(int).tolist() for s in (-1, 1))
        width = int(rng.integers(1, 3))
        cv2.line(frame, one, other, int(rng.choice([20, 60, 80, 130])), width, cv2.LINE_AA)
        markers = [d for d in tracker.detect(frame) if d.holes]
        assert [d.holes for d in markers] in ([], [holes])
        lost[width] += not markers
        for d in markers:
            assert math.hypot(d.x - 200, d.y - 200) < 1.3
    assert lost[1] < 0.25 * 200 < lost[2]


# ---------------------------------------------------------------- calibration


def test_a_tilted_and_turned_camera() -> None:
    """The picture of a camera that looks down askew: places and headings are still those on the floor."""
    corners = np.array([[0, 480], [640, 480], [640, 0], [0, 0]], np.float32)
    seen = np.array([[60, 430], [600, 470], [570, 40], [110, 10]], np.float32)
    warp = cv2.getPerspectiveTransform(corners - 0.5, seen - 0.5)
    picture = tuple((float(u), float(v)) for u, v in seen)
    calibration = Calibration(picture, ((0.0, 0.0), (3200.0, 0.0), (3200.0, 2400.0), (0.0, 2400.0)))
    rng, film, tracker = np.random.default_rng(4), Film(), Tracker(calibration=calibration)
    for _ in range(60):
        markers = (somewhere(rng, 1, 300, 1400), somewhere(rng, 2, 1700, 2900))
        food = (float(rng.uniform(1500, 1600)), float(rng.uniform(300, 2100)))
        frame = cv2.warpPerspective(film.shoot(markers, (food,)), warp, (640, 480), borderValue=80)
        scene = tracker.update(frame.astype(np.uint8))
        for x, y, heading, holes in markers:
            assert off(only(scene, holes), x, y) < 0.6
            assert turned(only(scene, holes), heading) < 4.0
            assert only(scene, holes).area == pytest.approx((384 - 16 * holes), rel=0.2)
        tracker.reset()
        assert (
            min(math.hypot(r.x - food[0] / 5, r.y - food[1] / 5) for r in scene.regions if not r.holes) < 0.6
        )


def test_parallax_of_a_low_camera() -> None:
    look = replace(LABORATORY, height=2700.0, marker_height=70.0)
    film = Film(look)
    frame = film.shoot(((500.0, 400.0, 1.0, 1),), ((2800.0, 2000.0),))
    camera = Calibration.identity((1600.0, 1200.0, 2700.0))
    corrected = Tracker(TrackerSettings(marker_height=70.0), camera).update(frame)
    assert off(only(corrected, 1), 500, 400) < 0.2
    assert off(only(corrected, 0), 2800, 2000) < 0.2
    assert off(only(Tracker().update(frame), 1), 500, 400) > 6


def test_a_marker_above_the_camera_is_refused() -> None:
    with pytest.raises(ValueError, match=r"height is 70\.0 mm; allowed: below the camera"):
        Tracker(calibration=Calibration.identity((0.0, 0.0, 60.0)))


# ---------------------------------------------------------------- tracks


def test_identities_and_foods_through_a_film_with_cables() -> None:
    """Two robots pass close by each other again and again; against the simulated camera, which knows the truth."""
    film, tracker = Film(LABORATORY, (1000.0, 1900.0)), Tracker()
    model = OverheadCamera(lambda: film.truth, Noise.none())
    foods = ((700.0, 1300.0), (1300.0, 700.0))
    labels: dict[int, int] = {}
    for i in range(300):
        t = i / 20
        one = (1000 + 300 * math.cos(t), 1000 + 300 * math.sin(t), t + math.pi / 2, 1)
        two = (1000 + 130 * math.cos(-t * 0.7), 1000 + 130 * math.sin(-t * 0.7), -t, 2)
        scene = tracker.update(film.shoot((one, two), foods))
        if i == 0:
            model.reset(np.random.default_rng(0))
        else:
            model.expose()
        for x, y, heading, holes in (one, two):
            region = only(scene, holes)
            assert labels.setdefault(holes, region.label) == region.label
            assert region.found
            assert off(region, x, y) < 1
            assert turned(region, heading) < 4
        for x, y in foods:
            shown = any(not r.holes and r.found and off(r, x, y) < 0.01 for r in model.look().regions)
            seen = any(not r.holes and r.found and off(r, x, y) < 1.5 for r in scene.regions)
            assert seen or not shown


def symmetric(x: float, y: float, degrees: float) -> NDArray[np.uint8]:
    """A user's own marker, with its one hole in the middle."""
    frame, heading = floor(), math.radians(degrees)
    parts = (Box(-60, -40, 60, 40, 225), Box(-10, -10, 10, 10, 25))
    draw_shapes(frame, ImagePose(x, y, math.cos(heading), math.sin(heading), 0.2), parts)
    return frame


def test_a_marker_that_does_not_tell_its_front_is_followed() -> None:
    tracker = Tracker()
    for degrees in range(0, 720, 15):
        region = only(tracker.update(symmetric(300 + degrees / 10, 200, degrees)), 1)
        assert turned(region, math.radians(degrees)) < 3
    tracker.reset()
    assert turned(only(tracker.update(symmetric(300, 200, 170)), 1), math.radians(-10)) < 3, (
        "in the first frame: between -90 and 90"
    )


def test_featureless_tracking_goes_by_place_alone() -> None:
    film = Film()
    by_place, by_holes = Tracker(TrackerSettings(featureless=True)), Tracker()
    start, away = (600.0, 600.0, 0.0, 1), (1500.0, 1500.0, 0.0, 1)
    for tracker in (by_place, by_holes):
        assert [r.label for r in tracker.update(film.shoot((start,))).regions] == [0]
    for _ in range(5):
        frame = film.shoot((away,))
        placed, held = by_place.update(frame), by_holes.update(frame)
    assert [(r.label, r.holes, r.found) for r in held.regions] == [(0, 1, True)]
    assert [(r.label, r.holes, r.found) for r in placed.regions] == [(1, 1, True)]


# ---------------------------------------------------------------- settings


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"contrast": 1.0}, r"contrast is 1\.0; allowed: above 1"),
        ({"contrast": math.nan}, "contrast is nan"),
        ({"hole_contrast": 1.0}, "hole_contrast"),
        ({"tolerance": 0.0}, "tolerance"),
        ({"food_radius": 0.0}, "food_radius"),
        ({"marker_length": 80.0}, r"marker_length is 80\.0.*1\.2 times"),
        ({"hole_side": 50.0}, r"hole_side is 50\.0"),
        ({"patience": 0}, "patience is 0"),
        ({"patience": 1.5}, r"patience is 1\.5"),
    ],
)
def test_settings_that_make_no_sense(settings: dict[str, float], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        TrackerSettings(**settings)  # type: ignore[arg-type] # wrong on purpose


def test_detections_are_plain_numbers() -> None:
    found = Tracker().detect(Film().shoot(((1000.0, 1000.0, 0.0, 2),), ((500.0, 500.0),)))
    assert len(found) == 2
    for detection in found:
        assert isinstance(detection, Detection)
        assert {type(value) for value in detection} <= {int, float, bool}
        assert type(detection.holes) is type(detection.orientation) is int
