"""The real camera's contract, and a scene drawn on its frame."""

import subprocess
import sys

import numpy as np
import pytest
from numpy.typing import NDArray

from khepera_forage.vision.calibration import Calibration
from khepera_forage.vision.overlay import draw_scene
from khepera_forage.vision.scene import Camera, Scene
from khepera_forage.vision.tracked_camera import TrackedCamera
from khepera_forage.vision.tracker import Tracker
from tests.vision.filming import Film

MARKERS = ((500.0, 500.0, 1.0, 1), (1500.0, 900.0, 2.0, 2))
FOODS = ((800.0, 800.0), (300.0, 1500.0))


class Shots:
    """A source whose every frame a test has taken itself; it counts how many were asked for."""

    def __init__(self) -> None:
        self.film, self.asked, self.closed = Film(), 0, 0
        self.foods = FOODS

    def newest(self) -> tuple[NDArray[np.uint8], float]:
        self.asked += 1
        return self.film.shoot(MARKERS, self.foods), 0.25

    def close(self) -> None:
        self.closed += 1


def test_look_does_nothing_and_exposing_takes_one_frame() -> None:
    shots = Shots()
    camera = TrackedCamera(shots, Tracker())
    as_camera: Camera = camera
    assert as_camera.look() == Scene(())
    with pytest.raises(RuntimeError, match="expose"):
        _ = camera.frame
    camera.reset()
    assert shots.asked == 1
    scene = camera.look()
    assert camera.look() is scene
    assert camera.age == 0.25
    assert sorted(r.holes for r in scene.regions) == [0, 0, 1, 2]
    camera.expose()
    assert shots.asked == 2
    assert [r.label for r in camera.look().regions] == [r.label for r in scene.regions]


def test_a_reset_forgets_the_tracks() -> None:
    shots = Shots()
    camera = TrackedCamera(shots, Tracker())
    camera.reset()
    shots.foods = ((2500.0, 2000.0),)  # type: ignore[assignment] # one is gone
    camera.expose()
    assert max(r.label for r in camera.look().regions) == 4
    camera.reset()
    assert sorted(r.label for r in camera.look().regions) == [0, 1, 2]


def test_closing_closes_the_source() -> None:
    shots = Shots()
    with TrackedCamera(shots, Tracker()) as camera:
        camera.reset()
    assert shots.closed == 1


def test_a_scene_is_drawn_where_it_is() -> None:
    """Red for markers, green for food, grey for what is lost; nothing anywhere else."""
    film, tracker = Film(), Tracker()
    frame = film.shoot(MARKERS, FOODS)
    scene = tracker.update(frame)
    picture = draw_scene(frame, scene)
    assert picture.shape == (480, 640, 3)
    assert picture.dtype == np.uint8
    changed = (picture != frame[:, :, None]).any(axis=2)
    for x, y in FOODS:
        column, row = int(x / 5), int(480 - y / 5)
        spot = picture[row - 6 : row + 7, column - 6 : column + 7].astype(int)
        assert (spot[:, :, 1] > spot[:, :, 0] + 50).sum() > 15
        changed[row - 20 : row + 20, column - 20 : column + 60] = False
    for x, y, *_ in MARKERS:
        column, row = int(x / 5), int(480 - y / 5)
        spot = picture[row - 16 : row + 17, column - 16 : column + 17].astype(int)
        assert (spot[:, :, 0] > spot[:, :, 1] + 50).sum() > 50
        changed[row - 40 : row + 40, column - 40 : column + 70] = False
    assert not changed.any()
    lost = Scene(tuple(r._replace(found=False) for r in scene.regions))
    grey = draw_scene(frame, lost).astype(int)
    assert np.abs(grey[:, :, 0] - grey[:, :, 1]).max() < 20


def test_drawing_follows_the_calibration() -> None:
    """A picture upside down: the outline must still lie on the marker."""
    film = Film()
    frame = np.ascontiguousarray(film.shoot(MARKERS[:1])[::-1, ::-1])
    plain = Calibration.identity()
    turned = Calibration(tuple((640 - u, 480 - v) for u, v in plain.picture), plain.floor)
    tracker = Tracker(calibration=turned)
    picture = draw_scene(frame, tracker.update(frame), turned)
    rows, columns = np.nonzero((picture != frame[:, :, None]).any(axis=2))
    assert abs(float(np.median(columns)) - (640 - 100)) < 15
    assert abs(float(np.median(rows)) - 100) < 15


def test_other_frames_are_not_drawn_on() -> None:
    with pytest.raises(ValueError, match=r"frame is \(2, 2\)"):
        draw_scene(np.zeros((2, 2), np.uint8), Scene(()))


def test_without_opencv_one_reads_what_to_install() -> None:
    program = (
        "import sys; sys.modules['cv2'] = None\n"
        "import khepera_forage\n"
        "from khepera_forage.vision import calibration, overlay, tracked_camera, video\n"
        "from khepera_forage.vision.tracker import Tracker, TrackerSettings\n"
        "TrackerSettings(); calibration.Calibration.identity()\n"
        "for make in (Tracker, lambda: video.VideoSource(0), lambda: overlay.draw_scene(None, None)):\n"
        "    try:\n"
        "        make()\n"
        "    except ImportError as error:\n"
        "        print(error)\n"
    )
    run = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    lines = run.stdout.splitlines()
    assert len(lines) == 3
    assert all("pip install 'khepera-forage[camera]'" in line for line in lines)
