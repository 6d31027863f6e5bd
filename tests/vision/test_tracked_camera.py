"""The tracked camera, and a scene drawn over its frame."""

import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest

from khepera_forage.vision.calibration import Calibration
from khepera_forage.vision.overlay import caption, draw_scene
from khepera_forage.vision.scene import Camera, Region, Scene
from khepera_forage.vision.tracker import TrackedCamera, Tracker
from tests.vision.scene_renderer import LABORATORY, Frame, SceneRenderer

MARKERS = ((500.0, 500.0, 1.0, 1), (1500.0, 900.0, 2.0, 2))
FOODS = ((800.0, 800.0), (300.0, 1500.0))


class RenderedSource:
    """A frame source of rendered frames that counts its calls."""

    def __init__(self) -> None:
        self.renderer, self.calls, self.closed = SceneRenderer(), 0, 0
        self.foods = FOODS

    def newest(self) -> tuple[Frame, float]:
        self.calls += 1
        return self.renderer.frame(MARKERS, self.foods), 0.25

    def close(self) -> None:
        self.closed += 1


def test_look_takes_no_frame_and_expose_takes_one() -> None:
    source = RenderedSource()
    camera = TrackedCamera(source, Tracker())
    as_camera: Camera = camera
    assert as_camera.look() == Scene(())
    camera.reset()
    assert source.calls == 1
    scene = camera.look()
    assert camera.look() is scene
    assert sorted(r.holes for r in scene.regions) == [0, 0, 1, 2]
    camera.expose()
    assert source.calls == 2
    assert [r.label for r in camera.look().regions] == [r.label for r in scene.regions]


def test_reset_forgets_the_tracks() -> None:
    source = RenderedSource()
    camera = TrackedCamera(source, Tracker())
    camera.reset()
    source.foods = ((2500.0, 2000.0),)  # type: ignore[assignment] # another number of foods
    for _ in range(2):
        camera.expose()
    assert max(r.label for r in camera.look().regions) == 4
    camera.reset()
    assert sorted(r.label for r in camera.look().regions) == [0, 1, 2]
    camera.close()
    assert source.closed == 1


def test_bad_picture_is_reported_once(caplog: pytest.LogCaptureFixture) -> None:
    source = RenderedSource()
    source.renderer = SceneRenderer(replace(LABORATORY, blur=2.3))
    camera = TrackedCamera(source, Tracker())
    camera.reset()
    camera.reset()
    assert [record.getMessage()[:28] for record in caplog.records] == ["camera picture out of focus:"]
    source.renderer = SceneRenderer()
    camera.reset()
    assert len(caplog.records) == 1


def test_overlay_draws_regions_at_their_places() -> None:
    """Markers are red, food is green, lost regions are grey; all other pixels stay unchanged."""
    renderer, tracker = SceneRenderer(), Tracker()
    frame = renderer.frame(MARKERS, FOODS)
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


def test_overlay_follows_the_calibration() -> None:
    """In a picture turned by 180 degrees the outline must still lie on the marker."""
    renderer = SceneRenderer()
    frame = np.ascontiguousarray(renderer.frame(MARKERS[:1])[::-1, ::-1])
    plain = Calibration.identity()
    turned = Calibration(tuple((640 - u, 480 - v) for u, v in plain.picture), plain.floor)
    tracker = Tracker(calibration=turned)
    picture = draw_scene(frame, tracker.update(frame), turned)
    rows, columns = np.nonzero((picture != frame[:, :, None]).any(axis=2))
    assert abs(float(np.median(columns)) - (640 - 100)) < 15
    assert abs(float(np.median(rows)) - 100) < 25, "the caption is above it"


@pytest.mark.parametrize(("holes", "expected"), [(9, "7: marker 9"), (0, "7: food")])
def test_captions_name_the_kind_of_region(holes: int, expected: str) -> None:
    region = Region(7, 10.0, 10.0, holes, 0, True, False, 0.0, 0.0, 0.0, 0.0)
    assert caption(region) == expected
    assert caption(region._replace(found=False)) == f"{expected}, lost"


def test_overlay_refuses_other_frames() -> None:
    with pytest.raises(ValueError, match=r"frame is \(2, 2, 2, 2\)"):
        draw_scene(np.zeros((2, 2, 2, 2), np.uint8), Scene(()))


def test_missing_opencv_is_reported_with_what_to_install() -> None:
    program = (
        "import sys; sys.modules['cv2'] = None\n"
        "import khepera_forage\n"
        "from khepera_forage.vision import calibration, overlay, video\n"
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
