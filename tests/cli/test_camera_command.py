"""`khepera-forage camera` with the virtual camera and with films."""

import math
import re
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pygame
import pytest

from khepera_forage.cli.main import main
from khepera_forage.cli.window import Window
from khepera_forage.rollouts.rendered_training import RenderedTraining
from khepera_forage.vision.calibration import Calibration, Lens
from tests.cli.running import Run
from tests.vision.scene_renderer import write_film
from tests.vision.test_tags import floor_places, floor_scene

CALIBRATE = "camera calibrate --points"
CORNERS = "0,0=0,2400 640,0=3200,2400 640,480=3200,0 0,480=0,0"


# ---------------------------------------------------------------- preview


PREVIEW = "camera preview --source"


def test_preview_prints_the_true_places_of_regions(run: Run) -> None:
    # A slow machine prints earlier frames, too.
    *_, printed, quality = run(f"{PREVIEW} virtual --frames 2 --seed 3").splitlines()
    assert re.search(r"picture: contrast 2\.\d\d \(at least 1\.68\), blur 0\.\d px \(at most", quality)
    assert "warning" not in quality
    camera = RenderedTraining(3)
    camera.newest()
    camera.newest()
    truth = camera.world.truth()
    camera.close()
    for x, y, heading, holes in truth.markers:
        (seen,) = re.findall(rf"marker {holes} \((\d+), (\d+)\) mm (\d+) deg,", printed)
        assert math.hypot(int(seen[0]) - x, int(seen[1]) - y) < 5
        assert math.cos(math.radians(int(seen[2])) - heading) > math.cos(math.radians(4))
    foods = [(int(x), int(y)) for x, y in re.findall(r"food \((\d+), (\d+)\) mm", printed)]
    assert len(foods) == len(truth.foods)
    for x, y in truth.foods:
        assert min(math.hypot(x - a, y - b) for a, b in foods) < 5
    assert "frames/s, 0 ms old" in printed


def test_preview_saves_pictures_and_films_that_it_can_read(run: Run) -> None:
    run(f"{PREVIEW} virtual --out one.png --frames 3")
    picture = cv2.imread("one.png")
    assert picture is not None
    assert picture.shape == (480, 640, 3)
    assert (np.ptp(picture, axis=2) > 60).sum() > 50, "the regions are drawn in colour"
    run(f"{PREVIEW} virtual --out new/film.gif --frames 3")
    assert Path("new/film.gif").read_bytes().startswith(b"GIF")
    assert "film.avi: 5 pictures" in run(f"{PREVIEW} virtual --out film.avi --frames 5")
    # A film is also a source, up to its end; the tracker ignores the regions drawn on it.
    for frames, shown in ((2, "marker 2 ("), (50, "the video has ended")):
        printed = run(f"{PREVIEW} film.avi --frames {frames} --out last.png")
        assert shown in printed
        assert "last.png: 1 picture" in printed
    run(f"{PREVIEW} film.avi --frames 3 --out copy.avi")
    assert cv2.VideoCapture("copy.avi").get(cv2.CAP_PROP_FPS) == 10, "the film runs at its own speed"
    run(f"{PREVIEW} virtual --food-tags 20 --food-tag-size 70 --frames 1 --out last.png")


def test_preview_names_the_setting_to_change_and_uses_the_calibration(run: Run) -> None:
    blurred = cv2.GaussianBlur(floor_scene(640, 480).frame(), (0, 0), 2.5).astype(np.uint8)
    write_film(Path("blurred.avi"), [blurred] * 50, 25)
    assert "warning: out of focus" in run(f"{PREVIEW} blurred.avi --frames 1")
    half = ((0.0, 1200.0), (1600.0, 1200.0), (1600.0, 0.0), (0.0, 0.0))
    # A calibration with half the millimetres per pixel: all regions are too small for a marker.
    Calibration(((0.0, 0.0), (640.0, 0.0), (640.0, 480.0), (0.0, 480.0)), half).save("half.toml")
    assert run(f"{PREVIEW} virtual --frames 1 --calibration half.toml").startswith("nothing seen;")


# ---------------------------------------------------------------- calibrate


def test_calibration_from_four_points_is_exact(run: Run) -> None:
    printed = run(f"{CALIBRATE} {CORNERS} --out new/calibration.toml")
    assert "residual 0.0 mm" in printed
    assert "held-out error unknown, because four points always fit" in printed
    assert "lens not calibrated: that takes at least 8 points" in printed
    assert "5.00 mm wide" in printed
    calibration = Calibration.load("new/calibration.toml")
    assert calibration.to_region(100.5, 79.5) == pytest.approx((100.5, 400.5))


def test_calibration_of_a_lens_reports_the_error_of_held_out_points(run: Run) -> None:
    plain = Calibration.identity()
    true = Calibration(plain.picture, plain.floor, lens=Lens(-0.0125))
    points = []
    for u in (30, 220, 420, 610):
        for v in (20, 240, 460):
            x, y = true.to_region(u, v)
            points.append(f"{u},{v}={5 * x},{5 * y}")
    printed = run(CALIBRATE, *points[:3], *points[9:])
    assert float(re.findall(r"held-out error (\d+\.\d) mm", printed)[0]) > 8
    assert "lens not calibrated" in printed
    printed = run(CALIBRATE, *points)
    assert "lens: k1 -0.0125" in printed
    assert float(re.findall(r"held-out error (\d+\.\d) mm", printed)[0]) < 0.2
    assert Calibration.load("calibration.toml").lens is not None


def test_wrong_points_are_reported(run: Run) -> None:
    points = [f"{u},{v}={5 * u},{2400 - 5 * v}" for u, v in ((200, 200), (300, 200), (300, 300), (200, 300))]
    assert "the points enclose 3 % of the picture" in run(CALIBRATE, *points)
    for middle, largest in (("320,240=1600,1300", (30, 200)), ("320,240=1600,1200", (0, 0.01))):
        distances = re.findall(r": (\d+\.\d) mm off", run(f"{CALIBRATE} {CORNERS} {middle}"))
        assert largest[0] <= max(map(float, distances)) <= largest[1]


@pytest.mark.parametrize(
    ("more", "hint"),
    [
        ("", "360.6 mm, above 10 mm; from six points on, this line names the worst"),
        ("320,10=500,800", "664.5 mm, above 10 mm; without the point 320,240=200,200 it is 0.0 mm"),
    ],
)
def test_calibration_with_a_wrong_point_is_written_with_a_warning(
    more: str, hint: str, capsys: pytest.CaptureFixture[str]
) -> None:
    points = f"10,10=0,800 630,10=1000,800 630,470=1000,0 10,470=0,0 320,240=200,200 {more}"
    assert main([*CALIBRATE.split(), *points.split()]) == 0
    assert capsys.readouterr().err == f"warning: the held-out error is {hint}\n"
    assert Path("calibration.toml").exists()


def test_calibrate_from_clicks_in_a_window(monkeypatch: pytest.MonkeyPatch, run: Run) -> None:
    monkeypatch.setenv("SDL_VIDEODRIVER", "dummy")
    show, clicks = Window.show_picture, [(100, 100), (500, 100), (500, 400), (100, 400)]

    def show_and_click(window: Window, *shown: Any) -> None:
        show(window, *shown)
        pygame.event.post(pygame.event.Event(pygame.MOUSEBUTTONDOWN, pos=clicks.pop(0), button=1))

    monkeypatch.setattr(Window, "show_picture", show_and_click)
    printed = run("camera calibrate --source virtual --places 0,1500 2000,1500 2000,0 0,0")
    assert "pixel (500.5, 100.5) is (2000, 1500) mm: 0.0 mm off" in printed
    found = Calibration.load("calibration.toml")
    assert found.to_region(100.5, 100.5) == pytest.approx((0, 300), abs=1e-6)


# ---------------------------------------------------------------- markers and tags


def test_tags_are_printed_and_calibrate_a_camera_that_is_then_watched(run: Run) -> None:
    """From a film of the floor to a preview that notices that the camera was knocked."""
    assert "tags.pdf: 2 pages of A4; print at 100 %" in run("camera tags --robots 1-2 --floor 38 --out new/tags.pdf")
    assert Path("new/tags.pdf").read_bytes().startswith(b"%PDF")
    for name, shift in (("before", (20.0, 10.0)), ("after", (20.0, 50.0))):
        write_film(Path(f"{name}.avi"), [floor_scene(848, 480, shift).frame()] * 10)
    tags = [f"{tag}={x},{y}" for tag, (x, y, _) in floor_places(3200 * 480 / 848).items()]
    cv2.imwrite("still.png", floor_scene(848, 480, (20.0, 10.0)).frame())
    run("camera calibrate --source still.png --out c.toml --tags", *tags)
    assert "size = [848, 480]" in Path("c.toml").read_text(encoding="utf-8")
    for name, moved in (("before.avi", False), ("after.avi", True), ("still.png", False)):
        printed = run(f"{PREVIEW} {name} --calibration c.toml --frames 2 --out picture.png")
        assert ("the camera has moved since its calibration" in printed) is moved
