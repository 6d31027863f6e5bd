"""The tracked camera, and a scene drawn over its frame."""

import sys
from dataclasses import replace

import numpy as np
import pytest

from khepera_forage.vision.calibration import Calibration
from khepera_forage.vision.overlay import caption, draw_scene
from khepera_forage.vision.scene import Region, Scene
from khepera_forage.vision.tracker import TrackedCamera, Tracker
from khepera_forage.vision.video import VideoSource
from tests.vision.scene_renderer import LABORATORY, Frame, SceneRenderer

MARKERS = ((500.0, 500.0, 1.0, 1), (1500.0, 900.0, 2.0, 2))
FOODS = ((800.0, 800.0), (300.0, 1500.0))


class RenderedSource:
    """A frame source of rendered frames."""

    def __init__(self, renderer: SceneRenderer) -> None:
        self.renderer = renderer

    def newest(self) -> tuple[Frame, float]:
        return self.renderer.frame(MARKERS, FOODS), 0.25

    def close(self) -> None: ...


def test_bad_picture_is_reported_once(caplog: pytest.LogCaptureFixture) -> None:
    source = RenderedSource(SceneRenderer(replace(LABORATORY, blur=2.3)))
    camera = TrackedCamera(source, Tracker())
    assert camera.look() == Scene(())
    camera.reset()
    camera.reset()
    assert [record.getMessage()[:28] for record in caplog.records] == ["camera picture out of focus:"]
    source.renderer = SceneRenderer()
    camera.reset()
    assert len(caplog.records) == 1
    assert sorted(r.holes for r in camera.look().regions) == [0, 0, 1, 2]


def test_overlay_draws_regions_at_their_places() -> None:
    """Markers are red, food is green, lost regions are grey; all other pixels stay unchanged."""
    renderer, tracker = SceneRenderer(), Tracker()
    frame = renderer.frame(MARKERS, FOODS)
    scene = tracker.update(frame)
    picture = draw_scene(frame, scene)
    assert picture.shape == (480, 640, 3)
    assert picture.dtype == np.uint8
    changed = (picture != frame[:, :, None]).any(axis=2)
    spots = [(*food, 1, 6, 15) for food in FOODS] + [(x, y, 0, 16, 50) for x, y, *_ in MARKERS]
    for x, y, colour, reach, least in spots:
        column, row = int(x / 5), int(480 - y / 5)
        spot = picture[row - reach : row + reach + 1, column - reach : column + reach + 1].astype(int)
        assert (spot[:, :, colour] > spot[:, :, 1 - colour] + 50).sum() > least
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


def test_captions_name_the_kind_of_region() -> None:
    for holes, expected in ((9, "7: marker 9"), (0, "7: food")):
        region = Region(7, 10.0, 10.0, holes, 0, True, False, 0.0, 0.0, 0.0, 0.0)
        assert caption(region) == expected
        assert caption(region._replace(found=False)) == f"{expected}, lost"


def test_missing_opencv_is_reported_with_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "cv2", None)
    for use in (Tracker, lambda: VideoSource(0), lambda: draw_scene(np.zeros((9, 9), np.uint8), Scene(()))):
        with pytest.raises(ImportError, match=r"pip install 'khepera-forage\[camera\]'"):
            use()
